"""Where a branch is kept: the journal while it is traced, the HDF5 file, and the check of what they hold."""
