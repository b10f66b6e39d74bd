"""The solvers of scipy, counted and timed step by step under solve_ivp."""

from collections.abc import Callable
from typing import Any

import scipy.integrate


def watched(method: str, taken: Callable[[Any], None]) -> Any:
    """The solver class `method` of scipy that calls taken(solver) after every step."""
    base: Any = getattr(scipy.integrate, method)

    def step(solver: Any) -> Any:
        message = base.step(solver)
        taken(solver)
        return message

    return type("Watched", (base,), {"step": step})
