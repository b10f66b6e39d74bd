"""Where a sweep is kept: the journal while it runs, the HDF5 file, and the check of what they hold."""
