"""The ledgers of energy and momentum."""
