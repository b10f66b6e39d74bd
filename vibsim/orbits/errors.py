"""Why there is no orbit."""

from typing import Any


class OrbitError(ValueError):
    """An orbit that cannot be looked for, or was not found: cause and remedy in one sentence.

    >>> import vibsim
    >>> try:
    ...     vibsim.orbit("gallery/three-balls")
    ... except vibsim.OrbitError as error:
    ...     print(str(error).partition(" (")[0])
    an orbit needs a periodic source
    """


class NoSection(OrbitError):
    """A scene whose motion has no section that it comes back to."""


class NotConverged(OrbitError):
    """Newton's method found no orbit near its start; `residual` [m/s], as weighed: the least of its way."""

    def __init__(self, message: str, residual: float) -> None:
        super().__init__(message)
        self.residual = residual

    def __reduce__(self) -> tuple[Any, ...]:
        """For pickle, as between processes."""
        return type(self), (str(self), self.residual)


def check_count(name: str, value: object, least: int = 1) -> None:
    """Raise OrbitError unless an argument is a whole number, no less than `least`."""
    if isinstance(value, bool) or not hasattr(value, "__index__") or int(value.__index__()) < least:
        words = "one" if least == 1 else str(least)
        raise OrbitError(f"{name} must be a whole number, {words} or more, got {value!r}")
