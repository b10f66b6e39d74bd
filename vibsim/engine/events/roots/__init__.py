"""The first zero of an event function within a step, proved to be the first."""
