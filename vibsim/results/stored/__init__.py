"""A run on file: what its file holds and says of itself, how it is written, and how it is read."""
