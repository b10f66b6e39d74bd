"""What can be wrong with a bench that is asked for."""


class BenchError(ValueError):
    """A wish that no bench can meet: an unknown method, a span too short, a truth of another case."""
