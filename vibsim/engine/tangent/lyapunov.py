"""Lyapunov exponents of a scene: a run with a tangent bundle and next to no samples.

found = lyapunov_exponents(scene, count=1)
found.exponents, found.growth, found.rank_losses
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from math import nan
from typing import Any

import numpy as np

from vibsim.engine.tangent.tangent_space import dimension
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import Scene


@dataclass(frozen=True)
class LyapunovExponents:
    """Lyapunov exponents from a tangent bundle over a span of a run.

    Attributes
    ----------
    exponents : growth rates of disturbances [1/s], the largest first; -inf where sticking or rest took the
        direction, NaN where the run ended before the span began and where the motion has no derivative
    growth : rows (t [s], logarithm of each disturbance's growth since the first row), at 101 times at most
    rank_losses : directions that sticking, rest and impacts without restitution took
    volume_residual : what is missing in the identity of Liouville over the whole run [-], where all exponents
        were asked for; else NaN
    tangencies : events crossed almost tangentially, turns almost in contact; `closest_tangency` [-] at
        `closest_tangency_time` [s]; see `vibsim.engine.tangent.tangencies`
    tangent_pieces : stretches that the residual adds up over
    undefined_time : when the motion first had no derivative [s], grazing a rigid stop say; NaN without that
    """

    exponents: np.ndarray
    growth: np.ndarray
    rank_losses: int
    volume_residual: float
    tangencies: int
    closest_tangency: float
    closest_tangency_time: float
    tangent_pieces: int
    undefined_time: float

    @property
    def span(self) -> tuple[float, float]:
        """Begin and end [s] of what the exponents are taken over; NaN without any."""
        return (float(self.growth[0, 0]), float(self.growth[-1, 0])) if len(self.growth) else (nan, nan)


def lyapunov_exponents(
    scene: Scene,
    count: int | None = None,
    discard: float | None = None,
    between: Callable[[], None] = lambda: None,
) -> LyapunovExponents:
    """The largest `count` Lyapunov exponents of the motion from the start of `scene`; None: all of them.

    discard : time [s] after which they are taken, for the motion to settle and the disturbances to turn into
    their directions; None: half of the run.
    between : called after every few milliseconds of work; what it raises ends the run

    Exponents that are 0 by construction are left out: see `vibsim.engine.tangent.tangent_space`. Raises
    ValueError for more exponents than the scene has, EngineError when the run fails.
    """
    count = dimension(scene) if count is None else count
    begin = scene.t_end / 2 if discard is None else discard
    trajectory = open_trajectory(scene.without_samples(), tangent=count, tangent_from=begin)
    for _ in trajectory.blocks():
        between()
    return exponents_of(trajectory.totals)


def exponents_of(totals: dict[str, Any]) -> LyapunovExponents:
    """The exponents in the totals of a run that carried a tangent bundle."""
    return LyapunovExponents(**{field.name: totals[field.name] for field in fields(LyapunovExponents)})
