"""Runs of a scene on either engine, as blocks of columns by name."""
