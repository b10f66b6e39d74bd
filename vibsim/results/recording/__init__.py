"""A run of the engine recorded as it comes, sample by sample, and judged on the way; see `recording`."""
