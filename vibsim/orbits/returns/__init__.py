"""Where orbits are cut: coordinates of the section, and the map from one cut to the next."""
