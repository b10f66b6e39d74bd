"""Pictures of sweeps: one kind in each module with `draw`; axes, curves, panels and maps for all."""
