"""The points of a sweep: computed one by one, in batches, and gathered in a table."""
