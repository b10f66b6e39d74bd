"""The flow of any mode by Taylor series."""
