"""The figures of the report: the paper's, and those that decide a claim."""
