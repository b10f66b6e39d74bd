"""The solvers themselves: scipy's with events and without, heyoka, the classical Runge-Kutta method."""
