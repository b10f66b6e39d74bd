"""Pictures of branches of periodic orbits and of loci: one kind in each module with `draw`."""
