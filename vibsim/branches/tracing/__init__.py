"""From point to point along a branch, until it ends, closes or joins another; and what is kept of it."""
