"""The tangent bundle of a run: disturbances kept apart, how fast they grow, and its check by volume."""
