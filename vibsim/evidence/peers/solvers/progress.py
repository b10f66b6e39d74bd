"""Whether time goes on from event to event."""

MOST = 1000  # events at one instant that are no error: far more than a scene has parts


class Progress:
    """Counts events at one instant, as a zero that is met again and again makes them."""

    def __init__(self) -> None:
        self._t, self._count = -1.0, 0

    def event(self, t: float) -> None:
        """Raise ArithmeticError where events go on without time going on."""
        self._count = self._count + 1 if t == self._t else 0
        self._t = t
        if self._count == MOST:
            raise ArithmeticError(f"{MOST} events at {t:.9g} s: time does not go on")
