"""What a statement can be about: quantities of a run, each with its unit and its definition."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vibsim.analysis.capture import FAR, NEAR
from vibsim.analysis.drift import CYCLES
from vibsim.analysis.holds import BAND, LEAST_TURNS, TURNS
from vibsim.engine.section import has_section
from vibsim.fitting.goals import measures as by
from vibsim.fitting.goals.measures import NONE, Measure
from vibsim.sweeps.computations.capture_verdict import VERDICTS as CAPTURES
from vibsim.sweeps.computations.regime_label import VERDICTS as REGIMES

if TYPE_CHECKING:
    from vibsim.cases import Case


@dataclass(frozen=True)
class Observable:
    """A quantity of a run.

    Attributes
    ----------
    definition : in words, for the documentation and every file
    dimension : of `cases/values/units.py`; "share" for a number that may be in percent; "" for a verdict
    measure : from the run, the window [s] (None: that of the definition) and the argument
    needs : what the scene must have, of "motor", "source", "stop", "friction"; "blocks" and
        "block2" are those of a case in the short form
    windowed : whether a statement may name a span of time
    argument : dimension of a further quantity in its phrase, such as the speed that is passed; or ""
    words : what each verdict is called -> its code
    instant : whether the value is itself the time at which it is decided
    """

    definition: str
    dimension: str
    measure: Measure
    needs: tuple[str, ...] = ()
    windowed: bool = False
    argument: str = ""
    words: Mapping[str, int] | None = None
    instant: bool = False


_HOLD = (
    f"the longest stretch, of at least {LEAST_TURNS} turns, in which the mean speed over {TURNS} turns stays "
    f"within {BAND:.0%} of its middle, {FAR:.0%} or more below the no-load speed or within {NEAR:.0%} of a "
    "resonance"
)
_LATE = "in the second half unless a span is named"
_MEAN_X2 = f"x2, averaged over {CYCLES} cycles,"
_MOTOR, _SOURCE, _STOP, _DRIVEN = ("motor",), ("source",), ("stop",), ("block2", "source")
_BLOCKS = ("blocks", "source")

OBSERVABLES: dict[str, Observable] = {
    "capture": Observable(
        "verdict on capture, as `vibsim analyse` gives it", "", by.capture_code, _MOTOR, words=CAPTURES
    ),
    "final speed": Observable(
        f"mean speed over the last {TURNS} turns", "angular rate", by.final_speed, _MOTOR
    ),
    "mean speed": Observable(
        f"whole cycles over their time, {_LATE}", "angular rate", by.mean_speed, _SOURCE, True
    ),
    "released": Observable(
        f"end of {_HOLD}; none where it lasts to the end", "time",
        by.of_hold(lambda hold: NONE if hold.at_end else hold.end), _MOTOR, instant=True,
    ),
    "held from": Observable(f"begin of {_HOLD}", "time", by.of_hold(lambda hold: hold.begin), _MOTOR),
    "held for": Observable(
        f"length of {_HOLD}", "time", by.of_hold(lambda hold: hold.end - hold.begin), _MOTOR
    ),
    "held at": Observable(
        f"mean speed in {_HOLD}", "angular rate", by.of_hold(lambda hold: hold.speed_hz), _MOTOR
    ),
    "passes": Observable(
        f"when the mean speed over {TURNS} turns last rose through the speed named", "time", by.passage,
        _MOTOR, argument="angular rate", instant=True,
    ),
    "drift rate": Observable(
        f"of block 2, {_LATE}, as `vibsim analyse` gives it", "velocity", by.drift_rate, ("block2",), True
    ),
    "impacts": Observable("number of impacts", "number", by.impact_count, _STOP, True),
    "impacts per cycle": Observable(
        f"mean number, {_LATE}", "number", by.per_cycle("impacts"), ("stop", "source"), True
    ),
    "sticks per cycle": Observable(
        f"mean number, {_LATE}", "number", by.per_cycle("sticks"), ("friction", "source"), True
    ),
    "impact velocity": Observable(
        f"mean closing velocity, {_LATE}", "velocity", by.mean_impact_velocity, _STOP, True
    ),
    "regime": Observable(
        f"verdict on the regime, {_LATE}, as `vibsim analyse` gives it", "", by.regime_code, _SOURCE, True,
        words=REGIMES,
    ),
    "period": Observable(
        f"cycles after which a periodic motion repeats itself, {_LATE}", "number", by.period_of_motion,
        _SOURCE, True,
    ),
    "frequency": Observable(
        f"strongest line of x1 - x2, {_LATE}", "angular rate", by.strongest_frequency, _BLOCKS, True
    ),
    **{
        f"vibration of {name}": Observable(
            f"half the peak-to-peak of {name} in one cycle, mean over the cycles {_LATE}", "length",
            by.vibration(name), needs, True,
        )
        for name, needs in (("x1", _BLOCKS), ("x2", _DRIVEN), ("x1 - x2", _BLOCKS))
    },
    "x2 peaks": Observable(
        f"when {_MEAN_X2} is greatest", "time",
        by.of_course(lambda times, mean: float(times[np.argmax(mean)])), _DRIVEN,
    ),
    "x2 falls": Observable(
        f"how much lower {_MEAN_X2} is at the end than at its greatest, as a share of that", "share",
        by.of_course(by.fall), _DRIVEN,
    ),
    "x2 ends": Observable(
        f"{_MEAN_X2} at the end", "length", by.of_course(lambda times, mean: float(mean[-1])), _DRIVEN
    ),
    "rest distance": Observable(
        "rest distance needed, max(x1 - x2)", "length", by.rest_distance, ("block2",)
    ),
}  # fmt: skip


def missing_of(observable: Observable, case: Case) -> list[str]:
    """Parts that an observable needs and the case does not have, in words.

    Statements on x1 and x2 are of the two blocks of the short form; a scene of named parts has none.
    """
    scene = case.scene()
    names = {
        "motor": ("a motor", scene.has_motor),
        "source": ("a source", has_section(scene)),
        "blocks": ("blocks 1 and 2 (the short form of a case)", not case.is_long),
        "block2": ("a moving block 2", not case.is_long and len(scene.bodies) > 1),
        "friction": ("friction", bool(scene.frictions) or (not case.is_long and len(scene.bodies) > 1)),
        "stop": ("a stop", scene.has_stop),
    }
    return [words for words, is_there in (names[need] for need in observable.needs) if not is_there]
