"""What commands do when they are called: plan, compute, tell how far they are, write, and report."""
