"""Fits and their runs on file."""
