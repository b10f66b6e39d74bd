"""Runs of as many digits as are asked for, and how many of them are right; `truth` runs a case."""
