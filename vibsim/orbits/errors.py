"""Why there is no orbit."""


class OrbitError(ValueError):
    """An orbit that cannot be looked for, or was not found: cause and remedy in one sentence.

    >>> import vibsim
    >>> try:
    ...     vibsim.orbit("gallery/three-balls")
    ... except vibsim.OrbitError as error:
    ...     print(str(error).partition(":")[0])
    nothing drives the scene with a period
    """


class NoSection(OrbitError):
    """A scene whose motion has no section that it comes back to."""


class NotConverged(OrbitError):
    """Newton's method found no orbit near its start; `residual` [m/s], as weighed: the least of its way."""

    def __init__(self, message: str, residual: float) -> None:
        super().__init__(message)
        self.residual = residual
