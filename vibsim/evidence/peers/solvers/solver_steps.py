"""The solvers of scipy, counted and timed step by step under solve_ivp."""

from collections.abc import Callable
from typing import Any

import scipy.integrate


def watched(method: str, taken: Callable[[Any], None]) -> Any:
    """The solver class `method` of scipy that calls taken(solver) after every step."""
    base: Any = getattr(scipy.integrate, method)

    class Watched(base):
        def step(self) -> Any:
            message = super().step()
            taken(self)
            return message

    return Watched
