"""The kinds of pictures, and which of them fit what.

A new kind is a `PictureKind` here and a function `<kind>_picture(subjects, view) -> Figure` in a module of
`DRAWN_IN`. Nothing here imports matplotlib: `vibsim plot --list` and shell completion read this table.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from vibsim.cases.problems import nearest
from vibsim.lazy import named
from vibsim.plots.subject import PlotError

if TYPE_CHECKING:
    from vibsim.plots.subject import Subject


# module of vibsim.plots -> the kinds that it draws, each by a function `<kind>_picture(subjects, view)`
DRAWN_IN: dict[str, tuple[str, ...]] = {
    "branch_curves": ("branch",),
    "branches_over_sweeps": ("multipliers", "locus"),
    "capture_pictures": ("regime", "capture"),
    "fit_and_bench": ("fit", "work-precision"),
    "frequency_pictures": ("displacement-frequency", "spectrum", "spectrogram", "waterfall"),
    "load_curves": ("load-curve", "motor"),
    "overview": ("overview", "stiffness"),
    "picture": ("columns",),
    "poincare_sections": ("impact-velocity", "stroboscopic"),
    "portraits": ("phase", "phase-drift-free", "relative", "orbit-portrait"),
    "slow_passages": ("run-up",),
    "sweep_pictures": ("sommerfeld", "lyapunov", "power", "end-state"),
    "sweep_responses": ("amplitude", "orbit", "basins"),
    "time_histories": ("displacement", "velocity", "motor-speed", "rotor-speed", "states"),
}
MODULES = {kind: module for module, kinds in DRAWN_IN.items() for kind in kinds}


@dataclass(frozen=True)
class PictureKind:
    """One kind of picture.

    Attributes
    ----------
    name : as on the command line
    reads : "trajectory", "sweep", "branch", "locus", "fit" or "bench" (a result file of that kind), or
        "case" (any of one case)
    summary : one line for `--list`
    needs : keys of NEEDS; what the subject must have
    width : "column" or "page", the width unless the user says otherwise
    alone : whether it shows one file at a time
    besides : what else it lays over that, as `reads`
    spans : what it takes of a view: "window", "detail", "poincare"
    also : what else it shows by itself, as `reads`
    """

    name: str
    reads: str
    summary: str
    needs: tuple[str, ...] = ()
    width: str = "column"
    alone: bool = False
    besides: tuple[str, ...] = ()
    spans: tuple[str, ...] = ("window",)
    also: tuple[str, ...] = ()

    @property
    def draw(self) -> Callable[..., Any]:
        """The function that draws it; its module (and matplotlib) is imported here."""
        function: Callable[..., Any] = named(
            f"vibsim.plots.{MODULES[self.name]}:{self.name.replace('-', '_')}_picture"
        )
        return function


KINDS = (
    PictureKind(
        "overview",
        "trajectory",
        "one page: the machine, displacements, detail, relative portrait, speed",
        width="page",
        spans=("window", "detail"),
    ),
    PictureKind(
        "displacement",
        "trajectory",
        "displacements of the bodies against time, impacts marked, with a detail",
        spans=("window", "detail"),
    ),
    PictureKind(
        "velocity",
        "trajectory",
        "velocities of the bodies against time, impacts marked, with a detail",
        spans=("window", "detail"),
    ),
    PictureKind(
        "phase",
        "trajectory",
        "phase portrait of each body, impacts marked",
        spans=("window", "poincare"),
    ),
    PictureKind(
        "phase-drift-free",
        "trajectory",
        "the same, less the drift of the blocks that nothing holds",
        ("excitation", "free blocks"),
        spans=("window", "poincare"),
    ),
    PictureKind(
        "relative",
        "trajectory",
        "phase portrait of the relative motion, with the stop",
        spans=("window", "poincare"),
    ),
    PictureKind(
        "motor-speed",
        "trajectory",
        "motor speed against time, with the natural frequencies",
        ("motor",),
    ),
    PictureKind(
        "run-up",
        "trajectory",
        "amplitude and speed of a motor against the speed of the source at that instant, over a sweep",
        ("motor or ramp",),
        besides=("sweep",),
    ),
    PictureKind(
        "rotor-speed",
        "trajectory",
        "speeds of the rotors against time, with the natural frequencies",
        ("rotor",),
    ),
    PictureKind("states", "trajectory", "further states (currents, ...) against time", ("states",)),
    PictureKind(
        "displacement-frequency", "trajectory", "displacements against the motor's speed", ("motor",)
    ),
    PictureKind(
        "impact-velocity", "trajectory", "closing velocity of each impact: time, phase, histogram", ("stop",)
    ),
    PictureKind(
        "stroboscopic",
        "trajectory",
        "Poincare section: relative motion once per period of the source",
        ("excitation",),
    ),
    PictureKind(
        "spectrum", "trajectory", "amplitude spectra of the displacements, natural frequencies marked"
    ),
    PictureKind(
        "spectrogram",
        "trajectory",
        "amplitude over time and frequency, with the motor's speed",
        alone=True,
    ),
    PictureKind(
        "waterfall", "trajectory", "spectra one behind the other: of pieces of a run, or of several runs"
    ),
    PictureKind(
        "orbit-portrait",
        "trajectory",
        "a stored orbit: phase plane with impacts, multipliers in the unit circle",
        ("orbit",),
        spans=(),
    ),
    PictureKind(
        "stiffness",
        "case",
        "force of springs and stops against the relative displacement",
        ("springs",),
        spans=(),
    ),
    PictureKind("motor", "case", "torque of the motor against its speed", ("motor torque",), spans=()),
    PictureKind(
        "sommerfeld",
        "sweep",
        "steady speed of the motor against its no-load speed or its voltage, and branches over it",
        ("speed", "Omega0"),
        besides=("branch",),
    ),
    PictureKind(
        "amplitude",
        "sweep",
        "frequency response: amplitudes against the frequency, or whatever was swept, and branches over it",
        besides=("branch",),
    ),
    PictureKind(
        "orbit",
        "sweep",
        "bifurcation diagram: stroboscopic points against what was swept, and branches over it",
        ("excitation", "section"),
        besides=("branch",),
    ),
    PictureKind("lyapunov", "sweep", "Lyapunov exponents against what was swept", ("exponents",)),
    PictureKind(
        "power",
        "sweep",
        "power of the source, and where it goes, against what was swept; of a run against time",
        ("power",),
        also=("trajectory",),
    ),
    PictureKind(
        "regime",
        "sweep",
        "map of two ranges: periodic, quasi-periodic or chaotic",
        ("regime", "map"),
        alone=True,
    ),
    PictureKind(
        "capture",
        "sweep",
        "where the motor is captured: a map, or a probability, and loci over it",
        ("motor", "capture", "map or starts"),
        alone=True,
        besides=("locus",),
    ),
    PictureKind(
        "branch", "branch", "periodic orbits over what was continued, stable or not, with bifurcations"
    ),
    PictureKind(
        "multipliers",
        "branch",
        "multipliers along a branch, and about the unit circle",
        width="page",
        alone=True,
    ),
    PictureKind("locus", "locus", "bifurcations of periodic orbits in the plane of two parameters"),
    PictureKind(
        "load-curve",
        "branch",
        "torque that vibration takes against speed, with the motor's lines",
        ("motor", "continued Omega0"),
        width="page",
    ),
    PictureKind(
        "end-state",
        "sweep",
        "what starts come to, rest or vibration: a map, starts, or shares",
        ("end states", "map or starts"),
        alone=True,
    ),
    PictureKind(
        "basins",
        "sweep",
        "which attractor every start ends on: a map, starts, or shares over a parameter",
        ("attractors", "starts of attractors"),
        alone=True,
    ),
    PictureKind(
        "fit",
        "fit",
        "penalty of the candidates over the free parameters",
        ("free parameters",),
        alone=True,
        spans=(),
    ),
    PictureKind(
        "work-precision", "bench", "error against computing time of every method", width="page", spans=()
    ),
)

# kinds that show no displacement, velocity or force; of the others all files must share the units
NOT_OF_BODIES = {
    *("capture", "columns", "fit", "load-curve", "locus", "lyapunov", "motor", "motor-speed"),
    *("multipliers", "power", "regime", "rotor-speed", "sommerfeld", "states", "work-precision"),
}

# other names by which kinds are known in the field; the first that shows a result is drawn
ALIASES: dict[str, tuple[str, ...]] = {
    "poincare": ("stroboscopic",),
    "bifurcation": ("orbit", "branch"),
    "frequency-response": ("amplitude",),
}

# drawn where two columns are named, and not one of `all`: any result of columns has it
COLUMNS = PictureKind("columns", "result", "any two columns against each other (--x and --y)")

NEEDS: dict[str, tuple[str, Callable[[Subject], bool]]] = {
    "motor": ("a motor", lambda subject: _has_motor(subject)),
    "speed": ("a motor", lambda subject: _has_speed(subject)),
    "motor or ramp": (
        "a motor or a ramp of the frequency of its source",
        lambda subject: _has_motor(subject) or _has_ramp(subject),
    ),
    "motor torque": (
        "a motor whose M0 and Omega0 are numbers",
        lambda subject: subject.scene.has_motor,
    ),
    "rotor": ("a rotor of section rotors", lambda subject: _has_kind(subject.scene, "rotor")),
    "states": ("further states", lambda subject: _has_kind(subject.scene, "state")),
    "stop": ("a stop", lambda subject: subject.scene.has_stop),
    "springs": ("springs or stops", lambda subject: bool(subject.scene.links or subject.scene.stops)),
    "excitation": ("a periodic source", lambda subject: _is_periodic(subject.scene)),
    "free blocks": (
        "a block that is free to drift away from the ground and the base",
        lambda subject: _drifts(subject.scene),
    ),
    "Omega0": (
        "a sweep over Omega0, or over a number that Omega0 or the torque depends on by a formula",
        lambda subject: _is_along_speed(subject),
    ),
    "continued Omega0": (
        'orbits continued over Omega0 (continue_branch(orbit, "Omega0", "FROM:TO"))',
        lambda subject: subject.result.key in ("excitation.Omega0", "motor.Omega0"),
    ),
    "map": (
        "two ranges without an ensemble (sweep with axes={KEY: RANGE})",
        lambda subject: _is_map(subject),
    ),
    "map or starts": (
        "two ranges, or an ensemble of at most two start values (sweep with axes={KEY: RANGE}, ensemble=N)",
        lambda subject: _is_map(subject) or _has_starts(subject),
    ),
    "exponents": (
        "Lyapunov exponents (sweep with compute='lyapunov')",
        lambda subject: _has(subject, "lyapunov") or _has(subject, "lyapunov_spectrum"),
    ),
    "power": ("powers (sweep with compute='power')", lambda subject: _has_powers(subject)),
    "regime": ("regimes (sweep with compute='regime')", lambda subject: _has(subject, "regime")),
    "end states": (
        "end states (sweep with compute='end-state')",
        lambda subject: _has(subject, "end_state"),
    ),
    "attractors": (
        "attractors (sweep with compute='attractor')",
        lambda subject: _has(subject, "attractor_kind"),
    ),
    "starts of attractors": (
        "two ranges, an ensemble of at most two start values, or starts at every value of one parameter",
        lambda subject: _shows_basins(subject),
    ),
    "capture": (
        "verdicts on capture (sweep with compute='capture')",
        lambda subject: _has(subject, "capture"),
    ),
    "free parameters": ("free parameters", lambda subject: bool(subject.result.plan.free)),
    "orbit": ("a periodic orbit (file of vibsim orbit)", lambda subject: subject.holds_orbit),
    "section": ("stroboscopic points", lambda subject: subject.result.plan.section > 0),
}

DEFAULTS = {
    "trajectory": ("overview",),
    "case": ("stiffness", "motor"),
    "sweep": ("sommerfeld",),
    "branch": ("branch",),
    "locus": ("locus",),
    "bench": ("work-precision",),
    "fit": ("fit",),
}


def _is_along_speed(subject: Subject) -> bool:
    """Whether the sweep is drawn along the motor constant, or what sets the speed of the source."""
    from vibsim.plots.sweep_axes import sets_speed

    return sets_speed(subject)


def _is_periodic(scene: Any) -> bool:
    from vibsim.physics.rates import has_section

    return has_section(scene)


def _has_motor(subject: Subject) -> bool:
    """Whether there is a motor; of a run, one whose torque is a formula too."""
    from vibsim.physics.rates import motor_columns

    by_formula = subject.reads == "trajectory" and motor_columns(subject.scene) is not None
    return by_formula or subject.scene.has_motor


def _has_speed(subject: Subject) -> bool:
    """Whether a sweep has the speed of a motor, or of the rotor that drives the scene."""
    from vibsim.plots.sweep_axes import speed_column

    return speed_column(subject) in subject.result


def _has_ramp(subject: Subject) -> bool:
    """Whether the frequency of a source has a ramp."""
    import numpy as np

    from vibsim.cases.ramps import drive_frequency

    return drive_frequency(subject.case, np.zeros(1)) is not None


def _has_powers(subject: Subject) -> bool:
    if subject.reads == "trajectory":
        from vibsim.engine.ledger_integrals import entries_of

        return bool(entries_of(subject.scene))
    return _has(subject, "power_source")


def _has_kind(scene: Any, kind: str) -> bool:
    return any(body.kind == kind for body in scene.bodies)


def _drifts(scene: Any) -> bool:
    from vibsim.physics.connections import drifting_sets

    return bool(drifting_sets(scene))


def _has(subject: Subject, column: str) -> bool:
    return column in subject.result.plan.columns


def _ranges(subject: Subject) -> int:
    """Number of axes with more than one value, members of an ensemble left out."""
    result = subject.result
    return sum(len(axis) > 1 for axis in result.axes if axis is not result.members)


def _is_map(subject: Subject) -> bool:
    return _ranges(subject) == 2 and subject.result.members is None


def _has_starts(subject: Subject) -> bool:
    """Whether there is an ensemble: at the points of up to two ranges, or of up to two start values."""
    members = subject.result.members
    if members is None:
        return False
    return len(members.spreads) <= 2 if _ranges(subject) == 0 else _ranges(subject) <= 2


def _shows_basins(subject: Subject) -> bool:
    """Whether basins can be drawn: in a plane, of starts, or as shares over the one parameter."""
    from vibsim.plots.sweep_responses import shows_shares

    if subject.result.members is not None and _ranges(subject) == 0:
        return len(subject.result.members.spreads) <= 2
    return _is_map(subject) or shows_shares(subject)


def misfit(kind: PictureKind, subject: Subject) -> str | None:
    """Reason why `kind` cannot show `subject`; None when it can."""
    if subject.reads in kind.besides:
        return None
    if kind.reads not in ("case", subject.reads) and subject.reads not in kind.also:
        return f"it shows a {kind.reads}, and {subject.path} is a {subject.reads}"
    if kind.reads == "case" and subject.reads == "sweep":
        return f"it shows one case, and {subject.path} is a sweep"
    for need in kind.needs:
        words, has = NEEDS[need]
        if not has(subject):
            return f"it needs {words}, and {subject.path} has none"
    return None


def fitting(subjects: Sequence[Subject]) -> list[PictureKind]:
    """The kinds that can show all the subjects together, in the order of the table."""
    kinds = [kind for kind in KINDS if not any(misfit(kind, subject) for subject in subjects)]
    return [kind for kind in kinds if (count := own(kind, subjects)) and (count == 1 or not kind.alone)]


def own(kind: PictureKind, subjects: Sequence[Subject]) -> int:
    """Number of the subjects that `kind` shows by itself, not laid over others."""
    return sum(subject.reads not in kind.besides for subject in subjects)


def kind_named(name: str) -> PictureKind:
    """The kind called `name`; PlotError with the nearest match when there is none."""
    for kind in KINDS:
        if kind.name == name:
            return kind
    if name in ALIASES:
        return kind_named(ALIASES[name][0])
    names = [*(kind.name for kind in KINDS), *ALIASES]
    near = nearest(name, [*names, "all"])
    hint = f"did you mean {near}? The" if near else "the"
    raise PlotError(f"unknown kind {name!r}: {hint} kinds are {', '.join(names)}")


def own_name(name: str, fit: Sequence[PictureKind]) -> str:
    """The name in the table of what is known in the field as `name`: of several kinds the first that fits."""
    fitting_names = [kind.name for kind in fit]
    several = ALIASES.get(name, (name,))
    return next((one for one in several if one in fitting_names), several[0])


def also_called(kind: PictureKind) -> tuple[str, ...]:
    """Other names of a kind."""
    return tuple(name for name, kinds in ALIASES.items() if kind.name in kinds)


def choose(names: Sequence[str] | None, subjects: Sequence[Subject]) -> list[PictureKind]:
    """The kinds to draw: those named, every fitting one for "all", the default ones for None.

    Raises PlotError for an unknown kind, or for one that does not fit (with those that do).
    """
    fit = fitting(subjects)
    if not fit and (names is None or "all" in names):
        paths = ", ".join(subject.path for subject in subjects)
        together = " together" if len(subjects) > 1 else ""
        raise PlotError(f"no kind shows {paths}{together}{_run_first(subjects)}")
    if names is None:
        preferred = _preferred(subjects)
        names = [kind.name for kind in fit if kind.name in preferred] or [kind.name for kind in fit[:1]]
    elif "all" in names:
        return fit
    chosen = list(dict.fromkeys(kind_named(own_name(name, fit)) for name in names))
    for kind in chosen:
        if own(kind, subjects) == 0:
            words = f"it lays a {subjects[0].reads} over a {kind.reads}, which is not there"
            raise PlotError(f"kind {kind.name}: {words}; {_those_that_fit(fit)}")
        if kind.alone and own(kind, subjects) > 1:
            raise PlotError(f"kind {kind.name}: it shows one file at a time; {_those_that_fit(fit)}")
        for subject in subjects:
            reason = misfit(kind, subject)
            if reason:
                raise PlotError(f"kind {kind.name}: {reason}; {_those_that_fit(fit)}")
    return chosen


def _run_first(subjects: Sequence[Subject]) -> str:
    """What to do with a case that has neither springs nor a motor, of which a picture is drawn."""
    if len(subjects) > 1 or subjects[0].reads != "case":
        return ""
    path = subjects[0].path
    return f", a case without spring or motor; vibsim cases {path} --draw draws it, vibsim run {path} runs it"


def _preferred(subjects: Sequence[Subject]) -> tuple[str, ...]:
    """Kinds to draw where none is named: basins where a sweep has attractors alone, and no statistics."""
    first = subjects[0]
    if all(subject.holds_orbit for subject in subjects):
        return ("orbit-portrait",)
    if first.reads == "sweep" and first.result.plan.compute == ("attractor",):
        return ("basins",)
    return DEFAULTS.get(first.reads, ())


def _those_that_fit(fit: Sequence[PictureKind]) -> str:
    return f"kinds that fit: {', '.join(kind.name for kind in fit)}" if fit else "no kind fits"
