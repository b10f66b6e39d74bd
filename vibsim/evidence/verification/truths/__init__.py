"""Stored truths of 25 digits, one JSON file a case: read, and their events matched with those of a run."""
