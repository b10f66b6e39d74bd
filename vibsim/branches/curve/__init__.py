"""The curve of orbits over a parameter: its unknowns and equations, its points, ways between them."""
