"""Results and cases in words: what commands print."""
