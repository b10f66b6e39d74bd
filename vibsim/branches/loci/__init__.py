"""Special points followed in a second parameter."""
