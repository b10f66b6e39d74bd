"""Arrays as an xarray Dataset, the same as xarray reads from the file."""

from typing import Any

import numpy as np

from vibsim.labelled.arrays import Arrays
from vibsim.labelled.extras import extra

DECODED = ("missing_value",)  # attributes that xarray takes out when it reads a file


def dataset_of(arrays: Arrays) -> Any:
    """The Dataset: dimensions, coordinates, units and attributes as in the file.

    Raises MissingExtra without xarray.
    """
    xarray = extra("xarray", "xarray")
    variables = {name: _variable(xarray, arrays, name) for name in arrays.datasets}
    scales = [name for name, dataset in arrays.datasets.items() if dataset.is_scale]
    data = {name: variable for name, variable in variables.items() if name not in scales}
    attrs = {name: value for name, value in arrays.attrs.items() if value is not None}
    return xarray.Dataset(data, {name: variables[name] for name in scales}, attrs)


def _variable(xarray: Any, arrays: Arrays, name: str) -> Any:
    dataset = arrays.datasets[name]
    described = dataset.column.attributes().items()
    attrs = {key: value for key, value in described if value is not None and key not in DECODED}
    values = np.asarray(arrays.read(name))
    if dataset.column.dtype == "text":
        values = values.astype(str)
    return xarray.Variable(dataset.dims, values, attrs)
