"""How solve_ivp is told a tolerance."""

TIGHTEST = 2.3e-14  # smallest rtol that it takes: 100 units of round-off
SHARE = 1e-3  # atol / rtol, as in its own defaults: displacements are of the order of 1e-2 m
