"""What of a run grows without end, period by period: why it comes to no orbit, in words."""

from __future__ import annotations

import numpy as np

from vibsim.cases.number import number
from vibsim.orbits.returns.coordinates import Coordinates
from vibsim.physics.body_sets import body_sets
from vibsim.physics.parts import RigidStop, Scene, Stop

LEAST = 4  # periods in a third of what is looked at
EVEN = (
    0.05  # of the growth over a third: how much it may differ from the line, or parabola, through all three
)
LASTING = 0.9  # of the growth over the first third that is left over the last: what settles has less
ROUNDING = 1e-9  # of the greatest value: no growth


def growing(points: np.ndarray, coordinates: Coordinates, n: int = 1) -> str | None:
    """Words on the unknowns that grow without end along the last points (k, m) of a run on its section, every
    n periods a turn of it; None where none does.

    A displacement alone drifts; where velocities grow, they are told in place of those that they carry along.
    """
    third = n * ((len(points) - 1) // (3 * n))
    if third < LEAST * n:
        return None
    last = points[-1 - 3 * third :]
    first, middle, behind = (last[(i + 1) * third] - last[i * third] for i in range(3))
    steps = last[n:] - last[:-n]
    steady = ((steps > 0).all(axis=0) | (steps < 0).all(axis=0)) & (abs(behind) >= LASTING * abs(first))
    steady &= abs(behind - 2 * middle + first) <= EVEN * abs(behind)
    steady &= abs(behind) > ROUNDING * abs(last).max(axis=0)
    if not steady.any():
        return None
    rates, grown = behind * n / third, np.flatnonzero(steady)
    speeds = [i for i in grown if coordinates.units[i] != "m"]
    told = [
        f"{coordinates.names[i]} by {number(rates[i], 4)} {coordinates.units[i]}" for i in speeds or grown
    ]
    every = "period" if n == 1 else f"{n} periods"
    changes = f"the run does not repeat itself: in each {every} it changes {' and '.join(told)}"
    if speeds:
        return f"{changes}; it speeds up for ever"
    return f"{changes}; {_released(coordinates, int(grown[0]))}"


def _released(coordinates: Coordinates, i: int) -> str:
    """What lets a displacement drift, and what to do about it."""
    scene = coordinates.scene
    body = coordinates.columns.index(coordinates.names[i].partition("-")[0])
    stops = [stop.name for stop in _stops_of(scene, body)]
    if not stops:
        return "nothing holds it there"
    one, them = ("stop", "it") if len(stops) == 1 else ("stops", "them")
    return (
        f"it drifts away from the {one} {', '.join(stops)}; leave {them} out, and the motion has an orbit "
        "with a drift per period"
    )


def _stops_of(scene: Scene, body: int) -> list[Stop | RigidStop]:
    """The stops that alone join the set of a body, as springs do, to others."""
    sets = body_sets(scene, [link for link in scene.links if link.k])
    own = next(set(one.bodies) for one in sets if body in one.bodies)
    return [stop for stop in scene.stops if (stop.P in own) != (stop.Q in own)]
