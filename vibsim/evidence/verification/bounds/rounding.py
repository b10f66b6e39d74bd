"""What rounding may do to a motion that does not amplify errors: the bounds of the cases with a closed form.

Every number of the scene is off by SCENE_UNITS of round-off, which moves the result by as much times its
conditioning; every event, and every Taylor step, adds STATE_UNITS of the size of the motion. Bounds add the
absolute values, as if no two errors ever cancelled.
"""

from math import inf, ulp

from vibsim.evidence.verification.bounds.kicks import SCENE_UNITS, STATE_UNITS, UNIT
from vibsim.results import Result

REASON = "rounding: 4 units per number of the scene x conditioning, 16 per event or Taylor step"


def roundings(result: Result, memory: float = inf) -> float:
    """How many states of the run were rounded: one at each event and Taylor step, and the one asked for.

    memory : time [s] in which the motion forgets an error but for the part 1/e; older ones do not count
    """
    steps = result.attrs["steps"] if result.attrs["method"] == "taylor" else 0
    return float(1 + (result.attrs["events"] + steps) * min(1.0, memory / result.t_reached))


def relative_rounding(result: Result, conditioning: float = 1.0, memory: float = inf) -> float:
    """Bound of the error relative to the size of the motion."""
    return UNIT * (SCENE_UNITS * conditioning + STATE_UNITS * roundings(result, memory))


def time_rounding(result: Result, t: float, conditioning: float = 1.0, rate: float = 1.0) -> float:
    """Bound of the error of an event's time t [s], with errors of states turned into time by `rate` [1/s].

    The time itself is a double; numbers of the scene scale it.
    """
    return ulp(t) + UNIT * (SCENE_UNITS * conditioning * t + STATE_UNITS * roundings(result) / rate)
