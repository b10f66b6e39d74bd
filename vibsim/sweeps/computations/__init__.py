"""What a sweep computes of each point on demand, see `registry`."""
