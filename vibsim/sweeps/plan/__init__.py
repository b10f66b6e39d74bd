"""What a sweep is to do: the values along its axes, the order of its points, and what is kept of each."""
