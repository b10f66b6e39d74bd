"""Statistics of one run, taken stretch by stretch; what a sweep stores per point, see `columns`."""
