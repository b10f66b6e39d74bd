"""Pictures of runs: one kind in each module with `draw`, the others what several kinds share."""
