"""The terminal: what goes to its streams, progress, and interruption."""
