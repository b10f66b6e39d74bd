"""Results as labelled arrays and tables: for xarray, pandas, notebooks, CSV and Parquet.

A kind of result says once what its arrays are (`Labelled.arrays`) and has them in every form.
"""
