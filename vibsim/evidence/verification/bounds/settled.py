"""What rounding may do to a number of a periodic motion that attracts: the bounds of V12 to V17.

A change of 1 of all numbers of the scene moves the number by `conditioning`, the sum of |p dq/dp| over them.
A rounding at each event, or Taylor step, of a period does no more than as large a change of the scene: either
persists from period to period and is forgotten as fast. Event times are doubles: half a unit in the last
place of t each, as much as a shift of the drive by the motion's rate times that.
"""

from math import ulp

from vibsim.evidence.verification.bounds.kicks import SCENE_UNITS, STATE_UNITS, UNIT

BECAUSE = (
    "rounding: (4 units of the scene, 16 per event or step of a period, half a unit of t) x conditioning"
)


def settled_bound(conditioning: float, t: float, roundings: float, rate: float = 1.0) -> float:
    """Bound of a number read at t [s]; `roundings` states of a period are rounded; rate [1/s] of motion."""
    return conditioning * (UNIT * (SCENE_UNITS + STATE_UNITS * roundings) + rate * ulp(t) / 2)


def last_digit(places: int) -> float:
    """Half a unit of the last of `places` decimals: how far a printed number may be off."""
    return 0.5 * 10.0**-places
