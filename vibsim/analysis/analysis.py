"""Everything that a run tells, judged at once."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any, TypeVar, Union

import numpy as np

from vibsim.analysis.capture import Capture, capture_of_turns, judge_capture
from vibsim.analysis.cycles import Span, later_part, span_of
from vibsim.analysis.dominant_frequencies import DominantFrequencies, find_frequencies, motions_of
from vibsim.analysis.drift import (
    Drift,
    ImpactsPerCycle,
    count_impacts,
    counted_parts,
    drifting,
    measure_drift,
)
from vibsim.analysis.regime import Regime, decided, judge_regime, largest_exponent
from vibsim.analysis.sections import MOST, Exponent, JudgedPoints, SectionCoordinates, judge_points
from vibsim.cases.case import texts
from vibsim.engine.blocks import Block
from vibsim.physics.parts import Scene
from vibsim.results.columns import IMPACT_CODES
from vibsim.results.labelled import Shown
from vibsim.results.result import Result, Window, read_window
from vibsim.results.simulation import as_result

if TYPE_CHECKING:
    from vibsim.cases import Case


T = TypeVar("T")
# a verdict, or those on several bodies or parts by their names
OneOrNamed = Union[T, dict[str, T]]  # noqa: UP007  (mypy knows no alias of T | ... before Python 3.12)

WHAT = ("capture", "drift", "impacts", "regime", "frequencies")


@dataclass(frozen=True, repr=False)
class Analysis(Shown):
    """Verdicts on a run; None where it was not asked for, or the scene lacks the part that it is about.

    Of drift, impacts and frequencies there is one verdict for two blocks, and for every other scene in which
    one thing alone can be meant; where there are several, a dictionary by the names of bodies or parts.

    Attributes
    ----------
    case : name of the case
    span : window that was looked at; capture is judged on all of it
    steady : what is left of it without the transient; the rest is judged on that

    >>> import vibsim
    >>> verdicts = vibsim.analyse("gallery/impact-pair", what=["impacts", "drift"])
    >>> [verdicts.impacts[wall].impacts for wall in ("left", "right")]  # per cycle
    [1.0, 1.0]
    >>> verdicts.capture is None  # it was not asked for
    True
    """

    case: str
    span: Span
    steady: Span
    capture: Capture | None = None
    drift: OneOrNamed[Drift] | None = None
    impacts: OneOrNamed[ImpactsPerCycle] | None = None
    regime: Regime | None = None
    frequencies: OneOrNamed[DominantFrequencies] | None = None

    def heading(self) -> str:
        """Name of the case, and what was looked at."""
        return f"of {self.case}, {_seconds(self.span)}, judged {_seconds(self.steady)}"

    def lines(self) -> list[tuple[str, str]]:
        """Every verdict with its reason; of several bodies or parts each behind its name."""
        return [line for what in WHAT for line in _verdict_lines(what, getattr(self, what))]


def _seconds(span: Span) -> str:
    return f"{span.begin:.5g} to {span.end:.5g} s"


def _verdict_lines(what: str, verdicts: Any) -> Iterator[tuple[str, str]]:
    """Label and text of one verdict, or of those by the names of bodies or parts."""
    if isinstance(verdicts, dict):
        for name, verdict in verdicts.items():
            yield what, f"{name}: {verdict.verdict}, {verdict.reason}"
    elif verdicts is not None:
        yield what, f"{verdicts.verdict}: {verdicts.reason}"


def analyse(
    result: "Result | Case | str | PathLike[str]",
    overrides: Mapping[str, object] | None = None,
    *,
    window: Window | str | None = None,
    discard: float | str | None = None,
    what: Collection[str] | str = WHAT,
    exponent: bool = True,
) -> Analysis:
    """Judge a run.

    Parameters
    ----------
    result : a Result, its file, or a case, as of `load_case`, which is run first
    overrides : values of the case that are changed; of a result none
    window : span to look at [s], (100, 110) or "100:110"; None: all of the run
    discard : transient at its begin that only the verdict on capture takes in, a time [s] or a text such as
        "100 s" or "50 %"; None: half the run without a window, nothing with one
    what : names out of WHAT, or one of them
    exponent : whether the largest Lyapunov exponent helps to judge a regime that is not periodic; costs one
        more run

    Raises ValueError for other names, a window outside the run, and a transient that leaves nothing.

    >>> import vibsim
    >>> verdicts = vibsim.analyse("gallery/impact-oscillator", what=["impacts", "regime"])
    >>> print(verdicts.regime.verdict, verdicts.regime.period, verdicts.impacts.verdict)
    periodic 2 some cycles
    """
    what = texts("what", what)
    unknown = [name for name in what if name not in WHAT]
    if unknown:
        raise ValueError(f"what must be among {', '.join(WHAT)}, got {unknown[0]!r}")
    result, window = as_result(result, overrides), None if window is None else read_window(window)
    span, steady = span_of(result, window), later_part(result, window, discard)
    scene = result.case.scene()
    verdicts: dict[str, Any] = {}
    if "capture" in what and scene.has_motor:
        verdicts["capture"] = judge_capture(result, span.window)
    if "regime" in what:
        verdicts["regime"] = _regime(result, steady, exponent)
    if "drift" in what and drifting(scene):
        regime = verdicts["regime"] if "regime" in what else judge_regime(result, steady)
        rates = regime.drift_rates
        drifts = {name: measure_drift(result, steady, of, rates) for name, of in drifting(scene).items()}
        verdicts["drift"] = _one_or_named(drifts)
    if "impacts" in what and scene.has_stop:
        of_parts = {name: count_impacts(result, steady, name) for name in counted_parts(scene)}
        verdicts["impacts"] = of_parts or count_impacts(result, steady)
    if "frequencies" in what:
        several = len(motions_of(scene)) > 1
        verdicts["frequencies"] = (
            {name: find_frequencies(result, steady, name) for name in motions_of(scene)}
            if several
            else find_frequencies(result, steady)
        )
    return Analysis(result.attrs["case_name"], span, span_of(result, steady), **verdicts)


def _one_or_named(verdicts: dict[str, T]) -> OneOrNamed[T]:
    """The only verdict, or all of several."""
    return next(iter(verdicts.values())) if len(verdicts) == 1 else verdicts


def _regime(result: Result, steady: Window, exponent: bool) -> Regime:
    """The regime; of a periodic motion without exponent: one return gives it better than any estimate."""
    regime = judge_regime(result, steady)
    if not exponent or regime.verdict in ("periodic", "at rest"):
        return regime
    return judge_regime(result, steady, largest_exponent(result, steady))


# Verdicts on a run while it is computed, for those who keep no trajectory, such as sweeps.


class StreamedVerdicts:
    """Gathers what the verdicts on capture and regime need from the blocks of a run.

    scene : what is run; begin : the regime is judged from then on [s], capture on everything taken

    The blocks carry the stroboscopic section. Memory grows with the cycles and impacts, not with the samples.
    """

    def __init__(self, scene: Scene, begin: float = 0.0):
        self.scene, self.begin = scene, begin
        self._points: list[dict[str, np.ndarray]] = []
        self._impacts: list[np.ndarray] = []
        self._coordinates = SectionCoordinates(scene)
        self._low, self._high = np.inf, -np.inf  # of each coordinate
        self._span = (np.inf, 0.0)

    def update(self, block: Block) -> None:
        """Take the next block."""
        self._points.append(dict(block.section))
        begun = np.isin(block.events["kind"], IMPACT_CODES)
        self._impacts.append(block.events["t"][begun])
        later = block.samples["time"] >= self.begin
        values = self._coordinates.of(block.samples)[:, later]
        self._low = np.minimum(self._low, values.min(axis=1, initial=np.inf))
        self._high = np.maximum(self._high, values.max(axis=1, initial=-np.inf))
        first = min([self._span[0], *block.events["t"][:1].tolist(), *block.samples["time"][:1].tolist()])
        self._span = first, block.t_reached

    def capture(self) -> Capture | None:
        """The verdict on a motor; None for another source."""
        if not self.scene.has_motor:
            return None
        return capture_of_turns(
            self._section()["time"], np.concatenate([[], *self._impacts]), self.scene, Span(*self._span)
        )

    def regime(self, exponent: Exponent | None = None) -> JudgedPoints:
        """The verdict on the stroboscopic section from `begin` on, settled by an orbit where one is near."""
        states, judged = self.late_section(), self.judged(exponent)
        if not len(states["time"]):
            return judged
        return decided(judged, self.scene, states, self._coordinates, self._sizes())

    def judged(self, exponent: Exponent | None = None) -> JudgedPoints:
        """The verdict on the points of the section from `begin` on alone, no orbit asked for."""
        states = self.late_section()
        if not len(states["time"]):
            return JudgedPoints("undecided", "no cycle of a source")
        return judge_points(self._coordinates.points(states, self._sizes()), exponent)

    def late_section(self) -> dict[str, np.ndarray]:
        """The points of the section from `begin` on, the last ones: time and states by name, each (n)."""
        section = self._section()
        rows = np.flatnonzero(section["time"] >= self.begin)[-MOST:]
        return {name: column[rows] for name, column in section.items()}

    def _sizes(self) -> np.ndarray:
        return self._coordinates.sizes(np.asarray(self._low), np.asarray(self._high))

    def _section(self) -> dict[str, np.ndarray]:
        """The stroboscopic points so far: time and states by name, each (n)."""
        if not self._points:
            return {"time": np.empty(0)}
        return {name: np.concatenate([part[name] for part in self._points]) for name in self._points[0]}
