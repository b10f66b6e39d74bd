"""Computations of a sweep on demand: exponents, orbits, regime, capture, end state."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from vibsim.cases.problems import did_you_mean
from vibsim.engine.blocks import Block
from vibsim.engine.columns import OF_IMPACTS
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.engine.tangent.tangent_space import dimension as exponents
from vibsim.physics.parts import Scene
from vibsim.results.file_contents import Column
from vibsim.sweeps import contact_computations, quantities
from vibsim.sweeps.contact_computations import Task
from vibsim.sweeps.quantities import Columns, Quantities
from vibsim.sweeps.statistics import MeasuredRun

if TYPE_CHECKING:
    from vibsim.analysis.capture import Capture
    from vibsim.analysis.sections import Exponent


# Lyapunov exponents of a point, by `vibsim.analysis.regime`: one more run, with a tangent bundle.


LARGEST, HALF_WIDTH = "lyapunov", "lyapunov_half_width"
LYAPUNOV_TITLE = "largest Lyapunov exponent"
SPECTRUM_TITLE = "all Lyapunov exponents"


def lyapunov_columns(of: Quantities) -> Columns:
    """The largest exponent."""
    return {
        LARGEST: Column("s-1", "largest Lyapunov exponent after the transient"),
        HALF_WIDTH: Column("s-1", "half width of its 95 % interval; NaN where unknown"),
        "lyapunov_warnings": Column("1", "number of reasons not to trust it, see vibsim.lyapunov"),
    }


def spectrum_columns(of: Quantities) -> Columns:
    """All exponents."""
    half_widths = "half widths of their 95 % intervals; NaN where unknown"
    return {
        "lyapunov_spectrum": Column("s-1", "Lyapunov exponents after the transient", dimension="exponent"),
        "lyapunov_spectrum_half_width": Column("s-1", half_widths, dimension="exponent"),
        "rank_losses": Column("1", "stickings after the transient that took a direction"),
        "volume_residual": Column("1", "what is missing in the identity of Liouville over the whole run"),
    }


class LyapunovComputation:
    """Lyapunov exponents of one run: the largest, or `everything`."""

    def __init__(self, task: Task, everything: bool = False):
        self._scene, self._begin, self._everything = task.scene, task.begin, everything

    def update(self, block: Block) -> None:
        """The exponents come from a run of their own."""

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, Any]:
        """The exponents and how well they are known."""
        from vibsim.analysis.regime import judged
        from vibsim.engine.tangent.lyapunov import lyapunov_exponents

        count = dimension(self._scene) if self._everything else 1
        computed = lyapunov_exponents(self._scene, count, self._begin, run.ask)
        known = judged(computed, self._scene.tol)
        if not self._everything:
            return {
                LARGEST: float(known.exponents[0]),
                HALF_WIDTH: float(known.half_widths[0]),
                "lyapunov_warnings": float(len(known.warnings)),
            }
        return {
            "lyapunov_spectrum": np.asarray(known.exponents, dtype="f8"),
            "lyapunov_spectrum_half_width": known.half_widths,
            "rank_losses": float(known.rank_losses),
            "volume_residual": known.volume_residual,
        }


class Spectrum(LyapunovComputation):
    """All Lyapunov exponents of one run."""

    def __init__(self, task: Task):
        super().__init__(task, everything=True)


# The periodic orbit that a point's run goes to, with its Floquet multipliers.


ORBIT_TITLE = "stable periodic orbit that the run goes to, and its multipliers"


def orbit_columns(of: Quantities) -> Columns:
    """Period, multipliers and the largest exponent; none without a source."""
    if not of.has_source:
        return {}
    none = "NaN where the run goes to none"
    return {
        "orbit_periods": Column("1", f"excitation periods of the periodic orbit; {none}"),
        "orbit_exponent": Column("s-1", f"largest exponent of the orbit; {none}"),
        "multiplier_real": Column("1", "real part of its Floquet multipliers", dimension="multiplier"),
        "multiplier_imaginary": Column("1", "imaginary part of them", dimension="multiplier"),
    }


def multipliers(scene: Scene) -> int:
    """Number of multipliers of the orbits of a scene; 0 without a section."""
    from vibsim.orbits.coordinates import OrbitError, section_of, unknown_count

    try:
        return 0 if section_of(scene).turning else unknown_count(scene)
    except OrbitError:
        return 0


class OrbitComputation:
    """Orbit of one run, by the same verdict as its regime."""

    def __init__(self, task: Task):
        from vibsim.analysis.analysis import StreamedVerdicts

        self._scene = task.scene
        self._verdicts = StreamedVerdicts(task.scene, task.begin)

    def update(self, block: Block) -> None:
        """Take the next block."""
        self._verdicts.update(block)

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, Any]:
        """Period, largest exponent and multipliers; NaN where there is no orbit that the run goes to."""
        judged = self._verdicts.regime()
        count = multipliers(self._scene)
        if judged.multipliers is None or judged.exponents is None or judged.period is None:
            return {name: np.full(count, np.nan) for name in ("multiplier_real", "multiplier_imaginary")}
        real, imaginary = np.array(judged.multipliers).reshape(-1, 2).T
        largest = judged.exponents[0] if judged.exponents else None
        return {
            "orbit_periods": float(judged.period),
            "orbit_exponent": -np.inf if largest is None else largest,
            "multiplier_real": real,
            "multiplier_imaginary": imaginary,
        }


# What kind of motion it is after the transient: the verdict of `vibsim.analysis` on its section.


REGIME_TITLE = "kind of motion (periodic, quasi-periodic, chaotic)"
REGIME_VERDICTS = {"undecided": 0, "periodic": 1, "transient": 2, "quasi-periodic": 3, "chaotic": 4}


def regime_columns(of: Quantities) -> Columns:
    """Verdict and period; none without a source."""
    if not of.has_source:
        return {}
    chaos = "K of the 0-1 test, 0: regular, 1: chaotic; NaN where not needed"
    return {
        "regime": Column("1", "kind of motion after the transient", flags=REGIME_VERDICTS),
        "regime_period": Column("1", "excitation periods after which it repeats itself"),
        "chaos_number": Column("1", chaos),
    }


class RegimeLabel:
    """Kind of motion of one run."""

    def __init__(self, task: Task):
        from vibsim.analysis.analysis import StreamedVerdicts

        self._verdicts = StreamedVerdicts(task.scene, task.begin)

    def update(self, block: Block) -> None:
        """Take the next block."""
        self._verdicts.update(block)

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, float]:
        """The verdict; a largest Lyapunov exponent that was computed too has its say."""
        judged = self._verdicts.regime(_exponent(measured))
        numbers = {"regime_period": judged.period, "chaos_number": judged.chaos_number}
        known = {name: float(value) for name, value in numbers.items() if value is not None}
        return {"regime": float(REGIME_VERDICTS[judged.verdict]), **known}


def _exponent(measured: dict[str, Any]) -> "Exponent | None":
    from vibsim.analysis.sections import Exponent

    value, half_width = (measured.get(name, math.nan) for name in (LARGEST, HALF_WIDTH))
    return Exponent(value, half_width) if math.isfinite(value) and math.isfinite(half_width) else None


# Whether the motor was captured, and when: the verdict of `vibsim.analysis.capture` on the whole run.


CAPTURE_TITLE = "verdict on capture, with times"
CAPTURE_VERDICTS = {"undecided": 0, "not met": 1, "passed": 2, "escaped": 3, "captured": 4}


def capture_columns(of: Quantities) -> Columns:
    """Verdict, times and speeds; none without a motor."""
    if not of.has_motor:
        return {}
    return {
        "capture": Column("1", "verdict on capture, from the whole run", flags=CAPTURE_VERDICTS),
        "capture_since": Column("s", "begin of the hold that decides the verdict"),
        "capture_until": Column("s", "its end; NaN where it lasts to the end of the run"),
        "capture_speed": Column("Hz", "mean speed over it"),
        "passage_time": Column("s", "when the mean speed last rose through a resonance"),
        "final_speed": Column("Hz", "mean speed over the last turns of the run"),
    }


class CaptureComputation:
    """Verdict on one run of a motor. Memory grows with its turns and impacts."""

    def __init__(self, task: Task):
        self._scene = task.scene
        self._early: list[Block] = []
        self._late: list[Block] = []

    def transient(self, block: Block) -> None:
        """Take the next block of the transient."""
        self._early.append(_thinned(block))

    def update(self, block: Block) -> None:
        """Take the next block of the rest, which begins with the last event in the transient."""
        self._late.append(_thinned(block))

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, float]:
        """The verdict and its times; NaN where there is none."""
        from vibsim.analysis.capture import capture_of_turns
        from vibsim.analysis.cycles import Span

        resumed = run.rows[-1]["t"] if run.rows else 0.0
        turns, impacts = (self._joined(table, resumed) for table in ("section", "events"))
        return _numbers(capture_of_turns(turns, impacts, self._scene, Span(0.0, run.t_reached)))

    def _joined(self, table: str, resumed: float) -> np.ndarray:
        """Times of the whole run: those of the transient up to where the rest goes on from, then the rest."""
        early = np.concatenate([[], *(getattr(block, table)["time"] for block in self._early)])
        late = [getattr(block, table)["time"] for block in self._late]
        return np.concatenate([early[early <= resumed], *late])


def _thinned(block: Block) -> Block:
    """Samples and events that the verdict needs: the times of the turns and of the impacts."""
    begun = OF_IMPACTS[block.events["kind"]]
    events, section = {"time": block.events["t"][begun]}, {"time": block.section["time"]}
    return replace(block, samples={}, events=events, section=section)


def _numbers(capture: "Capture") -> dict[str, float]:
    """The verdict as numbers by column."""
    last = max((passage.time for passage in capture.passages), default=math.nan)
    numbers = {
        "capture_since": capture.since,
        "capture_until": capture.until,
        "capture_speed": capture.speed_hz,
        "passage_time": last,
        "final_speed": capture.final_speed_hz,
    }
    known = {name: float(value) for name, value in numbers.items() if value is not None}
    return {"capture": float(CAPTURE_VERDICTS[capture.verdict]), **known}


# What a sweep computes of each point on demand, besides its usual statistics, while the run streams by.
#
# Each computation is made for one run, is shown its blocks from the transient's end on, and answers at the
# end.


Window = tuple[float, float]  # of the whole periods [s]; of everything after the transient without periods


class Computation(Protocol):
    """One computation of one run, made for a `Task`."""

    def update(self, block: Block) -> None:
        """Take the next block; the first may begin before the transient ends."""

    def values(self, window: Window, run: MeasuredRun, measured: dict[str, Any]) -> dict[str, Any]:
        """By column a float, or an array where the column has a further dimension.

        measured : what the computations before this one have come to
        """


@dataclass(frozen=True)
class ComputationKind:
    """A computation that can be asked for.

    Attributes
    ----------
    title : what it is, for the list
    columns : what it stores of a scene; nothing where it makes no sense
    suits : what the scene must have for it to make sense, in words
    make : the computation of one run
    samples : whether it reads samples
    """

    title: str
    columns: Callable[[Quantities], Columns]
    suits: str
    make: Callable[[Task], Computation]
    samples: bool = False


def _attractor_computation(task: Task) -> Computation:
    """The attractor of one run."""
    from vibsim.sweeps.attractor_labels import AttractorComputation

    return AttractorComputation(task)


COMPUTATIONS = {
    "power": ComputationKind(
        contact_computations.POWER_TITLE,
        contact_computations.power_columns,
        "with a source",
        contact_computations.Power,
    ),
    "impact-velocity": ComputationKind(
        contact_computations.IMPACT_VELOCITY_TITLE,
        contact_computations.impact_velocity_columns,
        "with a stop",
        contact_computations.ImpactVelocity,
    ),
    "contact-section": ComputationKind(
        contact_computations.CONTACT_SECTION_TITLE,
        contact_computations.contact_section_columns,
        "with a stop",
        contact_computations.ContactSection,
    ),
    "grazing": ComputationKind(
        contact_computations.GRAZING_TITLE,
        contact_computations.grazing_columns,
        "with a stop",
        contact_computations.Grazing,
    ),
    "certificate": ComputationKind(
        contact_computations.CERTIFICATE_TITLE,
        contact_computations.certificate_columns,
        "",
        contact_computations.CertificateComputation,
    ),
    "capture": ComputationKind(CAPTURE_TITLE, capture_columns, "with a motor", CaptureComputation),
    "lyapunov": ComputationKind(LYAPUNOV_TITLE, lyapunov_columns, "", LyapunovComputation),
    "lyapunov-spectrum": ComputationKind(SPECTRUM_TITLE, spectrum_columns, "", Spectrum),
    "regime": ComputationKind(REGIME_TITLE, regime_columns, "with a source", RegimeLabel, samples=True),
    "orbit": ComputationKind(ORBIT_TITLE, orbit_columns, "with a source", OrbitComputation, samples=True),
    "end-state": ComputationKind(
        contact_computations.END_STATE_TITLE,
        contact_computations.end_state_columns,
        "that move freely, under constant forces alone",
        contact_computations.EndState,
        samples=True,
    ),
    quantities.NAME: ComputationKind(
        quantities.ATTRACTOR_TITLE,
        quantities.attractor_columns,
        "",
        _attractor_computation,
        samples=True,
    ),
}


def read_computations(names: str | Iterable[str], of: Quantities) -> tuple[str, ...]:
    """The computations of these names (one, or several), each once, in the order of `COMPUTATIONS`.

    "all" stands for all that the scene has use for. Raises ValueError for a name that there is not.
    """
    chosen = {names} if isinstance(names, str) else set(names)
    if "all" in chosen:
        return fitting(COMPUTATIONS, of)
    for name in sorted(chosen - set(COMPUTATIONS)):
        allowed = ", ".join([*COMPUTATIONS, "all"])
        raise ValueError(
            f"nothing to compute is called {name!r}{did_you_mean(name, COMPUTATIONS)}; allowed: {allowed}"
        )
    return tuple(name for name in COMPUTATIONS if name in chosen)


def fitting(names: Iterable[str], of: Quantities) -> tuple[str, ...]:
    """Those of the computations that the scene has use for."""
    return tuple(name for name in names if COMPUTATIONS[name].columns(of))


def length_of(dimension: str, scene: Scene, section: int) -> int:
    """Length of a further dimension; sections have as many points as the sweep says."""
    lengths: dict[str, Callable[[], int]] = {
        "section": lambda: section,
        "contact": lambda: section,
        "quantile": lambda: len(contact_computations.QUANTILES),
        "exponent": lambda: exponents(scene),
        "multiplier": lambda: multipliers(scene),
        "unknown": lambda: quantities.unknowns(scene),
        "observable": lambda: quantities.observed(scene),
    }
    return lengths[dimension]()
