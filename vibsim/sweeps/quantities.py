"""Quantities that a sweep measures of a scene: motions of bodies and of pairs of ends, events of parts, by
name.

Cases in the long form take the names of their bodies and parts. The short form keeps those of the paper's two
blocks: x1, x2, and `relative` for x1 - x2, or for x1 where block 2 is fixed.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import chain
from typing import TYPE_CHECKING

from vibsim.cases.problems import counted
from vibsim.physics.parts import BODY, GROUND, ROTOR, STATE, Link, RigidStop, Scene, Stop, columns_of
from vibsim.physics.rates import is_driven
from vibsim.results.columns import starts_of, written_unit
from vibsim.results.file_contents import Column

if TYPE_CHECKING:
    from vibsim.cases import Case


RELATIVE = "x1 - x2 (x1 where block 2 is fixed)"
RELATIVE_RATE = "v1 - v2 (v1 where block 2 is fixed)"


@dataclass(frozen=True)
class MeasuredMotion:
    """The displacement x_P - x_Q of one end of a part against the other; Q is GROUND for that of a body.

    Attributes
    ----------
    name, rate : of displacement and velocity in the names of columns, such as x_ram and v_ram
    words, rate_words : what they are, for definitions
    P, Q : the ends, as of a part of a scene
    part : the stop or link that joins them, of a pair
    unit : of the displacement, m or rad
    """

    name: str
    rate: str
    words: str
    rate_words: str
    P: int
    Q: int = GROUND
    part: str = ""
    unit: str = "m"


@dataclass(frozen=True)
class Quantities:
    """The quantities that are measured, and their names.

    Attributes
    ----------
    motions : those whose amplitudes are taken: bodies, then pairs
    ranged : name in columns -> the motion whose least and greatest displacement is kept
    drifting : column of the drift rate -> the motion that drifts
    sections : column of the stroboscopic section -> (motion, whether its velocity)
    stops, frictions : names of the parts whose events are counted one by one
    has_stop, has_friction, has_motor, has_source : what the scene has; friction with mu = 0 too, which may
        be swept
    is_powered : whether something puts power in: a source, a constant force, a belt
    powers : column of a part's mean power -> (its entry in the energy ledger, what it is)
    starts : state (x_ram, phi) -> key of its start value in the case, and its unit there
    of_parts : whether the case has the long form
    gaps : unit of the gap of each stop by name, of all of them by ""
    rotors : name of each rotor -> columns of its angle and speed; states : name of each -> its unit
    """

    motions: tuple[MeasuredMotion, ...]
    ranged: dict[str, MeasuredMotion]
    drifting: dict[str, MeasuredMotion]
    sections: dict[str, tuple[MeasuredMotion, bool]]
    stops: tuple[str, ...]
    frictions: tuple[str, ...]
    has_stop: bool
    has_friction: bool
    has_motor: bool
    has_source: bool
    is_powered: bool
    powers: dict[str, tuple[str, str]]
    starts: dict[str, tuple[str, str]]
    of_parts: bool
    gaps: dict[str, str] = field(default_factory=lambda: {"": "m"})
    rotors: dict[str, tuple[str, str]] = field(default_factory=dict)
    states: dict[str, str] = field(default_factory=dict)


def quantities_of(case: "Case") -> Quantities:
    """Quantities that a sweep of a case measures."""
    scene = case.scene()
    if not case.is_long:
        return of_two_blocks(scene)
    return of_parts(scene, case.long_values().get("friction", {}))


def of_two_blocks(scene: Scene) -> Quantities:
    """Of the scene of a case in the short form."""
    two = len(scene.bodies) > 1
    x1, *x2 = _bodies(scene)
    pair = MeasuredMotion("relative", "velocity", "x1 - x2", RELATIVE_RATE, 0, 1 if two else GROUND)
    return Quantities(
        motions=(x1, *x2, pair) if two else (x1,),
        ranged={"relative": pair if two else x1},
        drifting={"drift_rate": x2[0]} if two else {},
        sections={"section_displacement": (pair, False), "section_velocity": (pair, True)},
        stops=(),
        frictions=(),
        has_stop=bool(scene.stops),
        has_friction=two,
        has_motor=scene.has_motor,
        has_source=is_driven(scene),
        is_powered=is_driven(scene),
        powers={},
        starts=starts_of(scene, is_long=False),
        of_parts=False,
    )


def of_parts(scene: Scene, frictions: Iterable[str]) -> Quantities:
    """Of a scene of named parts; frictions: names of all, of those with mu = 0 too."""
    bodies, units = tuple(_bodies(scene)), dict(scene.state_units)
    motions = (*bodies, *_pairs(scene))
    frictions = tuple(frictions)
    turning = {body.name: body.columns for body in scene.bodies if body.kind == ROTOR}
    return Quantities(
        motions=motions,
        ranged={motion.name: motion for motion in motions},
        drifting={f"drift_rate_{motion.name}": motion for motion in bodies},
        sections={
            f"section_{name}": (motion, is_rate)
            for motion in motions
            for name, is_rate in ((motion.name, False), (motion.rate, True))
        },
        stops=tuple(stop.name for stop in scene.stops),
        frictions=frictions,
        has_stop=bool(scene.stops),
        has_friction=bool(frictions),
        has_motor=scene.has_motor,
        has_source=is_driven(scene),
        is_powered=is_driven(scene) or bool(scene.forces) or any(f.runs for f in scene.frictions),
        powers=_powers(scene, frictions),
        starts=starts_of(scene, is_long=True),
        of_parts=True,
        gaps={"": scene.unit_of_stops(), **{s.name: scene.unit_of_stops(s.name) for s in scene.stops}},
        rotors={name: (phi, w) for name, (phi, w) in turning.items() if phi is not None},
        states={
            body.name: written_unit(units.get(body.name, "")) for body in scene.bodies if body.kind == STATE
        },
    )


def _bodies(scene: Scene) -> Iterator[MeasuredMotion]:
    for i, body in enumerate(scene.line):
        x, v = columns_of(body.name)
        yield MeasuredMotion(x, v, x, v, i, unit=scene.unit_of(scene.bodies[i]))


def _pairs(scene: Scene) -> Iterator[MeasuredMotion]:
    """Each pair of ends that a stop or a link joins, called after the first of them, stops before links.

    Ends on the ground make no pair: there the relative motion is that of the body.
    """
    listed = set()
    parts: tuple[Stop | RigidStop | Link, ...] = (*scene.stops, *scene.links)
    for part in parts:
        ends = frozenset((part.P, part.Q))
        if GROUND not in ends and ends not in listed:
            listed.add(ends)
            (x, v), (other_x, other_v) = (_end_columns(scene, end) for end in (part.P, part.Q))
            names = f"relative_{part.name}", f"velocity_{part.name}"
            words, unit = (f"{x} - {other_x}", f"{v} - {other_v}"), scene.unit_between(part.P, part.Q)
            yield MeasuredMotion(*names, *words, part.P, part.Q, part.name, unit)


def _end_columns(scene: Scene, end: int) -> tuple[str, str]:
    """x and v of an end; those of the base are called X and V."""
    return columns_of(scene.bodies[end].name) if end >= 0 else ("X of the base", "V of the base")


def _damped_stops(scene: Scene) -> list[str]:
    """Names of the stops that take energy: elastic ones with a damper, and rigid ones."""
    return [stop.name for stop in scene.stops if isinstance(stop, RigidStop) or stop.jumps]


def _powers(scene: Scene, frictions: Iterable[str]) -> dict[str, tuple[str, str]]:
    """The parts that give or take power: forces, torques of rotors, motor, belts; dampers and formulas of
    links, stops with one, frictions. A rate of a state has no power.
    """
    of_kind = {
        kind: [f.name for f in scene.forces if scene.bodies[f.on].kind == kind] for kind in (BODY, ROTOR)
    }
    powers = {f"power_force_{name}": (f"work.forces.{name}", f"force {name} gives") for name in of_kind[BODY]}
    powers |= {
        f"power_rotor_{name}": (f"work.rotors.{name}", f"the torque on {name} gives")
        for name in of_kind[ROTOR]
    }
    if scene.has_motor:
        powers["power_motor"] = "work.motor", "the motor gives"
    belts, damped = [f.name for f in scene.frictions if f.runs], _damped_stops(scene)
    powers |= {f"power_belt_{name}": (f"work.friction.{name}", f"the belt of {name} gives") for name in belts}
    dampers = [link.name for link in scene.links if link.c]
    powers |= {
        f"power_damper_{name}": (f"loss.links.{name}", f"the damper of {name} takes") for name in dampers
    }
    formulas = [link.name for link in scene.links if link.force is not None]
    powers |= {
        f"power_link_{name}": (f"loss.links.{name}", f"the formula of {name} takes") for name in formulas
    }
    powers |= {f"power_stop_{name}": (f"loss.stops.{name}", f"the stop {name} takes") for name in damped}
    powers |= {
        f"power_friction_{name}": (f"loss.friction.{name}", f"the friction {name} takes")
        for name in frictions
    }
    return {name: (entry, f"mean power that {words}") for name, (entry, words) in powers.items()}


# What a sweep stores per point: names, units, definitions. The definitions go into every file.


MISSING, DONE, FAILED = 0, 1, 2
STATUS_FLAGS = {"missing": MISSING, "done": DONE, "failed": FAILED}

Columns = dict[str, Column]

NOT_REPRODUCIBLE = ("wall_time",)

DEFINITIONS = (
    "An excitation period runs from one stroboscopic point to the next: t = k/f of a harmonic source, of "
    "several their common period, phi = 2 pi k passed forwards of a motor. Only whole periods between the "
    "transient and the end count. "
    "Amplitudes are half the peak-to-peak within one period, so that a drift does not add up; without "
    "periods they are half the peak-to-peak of the whole time after the transient, and what is counted "
    "per period is NaN. Extremes are those of the motion between its events, exact to rounding. The mean "
    "speed is whole turns over their time. Stroboscopic points are counted back from the last."
)

_LATE = "after the transient"
_HALF = f"half the peak-to-peak of {{}} in one excitation period, {{}} over the whole periods {_LATE}"
_END = (
    "{} where a carried sweep goes on: at the end of the run, with a harmonic source at its last whole period"
)


def always(of: Quantities) -> Columns:
    """The columns that every sweep of a scene has."""
    return {**statistics(of), **totals(of), **end_state(of), **section(of)}


def distinct(*tables: Iterable[tuple[str, Column]]) -> Columns:
    """All columns of tables of (name, column). Raises ValueError where two have one name."""
    columns: Columns = {}
    for name, column in chain(*tables):
        if name in columns:
            raise ValueError(f"two columns would be called {name}: give a body or stop another name")
        columns[name] = column
    return columns


def statistics(of: Quantities) -> Columns:
    """Statistics of the time after the transient."""
    whole = f"whole excitation periods {_LATE}, from which the statistics are taken"
    return distinct(
        _speeds().items() if of.has_motor else (),
        _rotor_speeds(of),
        _amplitudes(of),
        _ranges(of),
        _drifts(of),
        _counts("impacts_per_period", "beginnings of contact", of.stops).items() if of.has_stop else (),
        _counts("sticks_per_period", "beginnings of stick", of.frictions).items() if of.has_friction else (),
        [("periods", Column("1", whole))],
    )


def _amplitudes(of: Quantities) -> Iterator[tuple[str, Column]]:
    for motion in of.motions:
        yield f"amplitude_{motion.name}", Column(motion.unit, _HALF.format(motion.words, "mean"))
        yield f"amplitude_{motion.name}_max", Column(motion.unit, _HALF.format(motion.words, "greatest"))


def _drifts(of: Quantities) -> Iterator[tuple[str, Column]]:
    for name, motion in of.drifting.items():
        line = f"slope of the least-squares line through {motion.words} at the stroboscopic points {_LATE}"
        yield name, Column(f"{motion.unit} s-1", line)


def _speeds() -> Columns:
    return {
        "mean_speed": Column("Hz", f"mean motor speed over the whole periods {_LATE}"),
        "min_speed": Column("Hz", f"least motor speed {_LATE}"),
        "max_speed": Column("Hz", f"greatest motor speed {_LATE}"),
    }


def _rotor_speeds(of: Quantities) -> Iterator[tuple[str, Column]]:
    for name in of.rotors:
        yield f"mean_speed_{name}", Column("Hz", f"mean speed of {name} over the whole periods {_LATE}")


def _ranges(of: Quantities) -> Iterator[tuple[str, Column]]:
    """Least and greatest displacements; of the two blocks the greatest is the rest distance needed."""
    for name, motion in of.ranged.items():
        words, needed = (motion.words, "") if of.of_parts else (RELATIVE, ": the rest distance needed")
        yield f"{name}_min", Column(motion.unit, f"least {words} {_LATE}")
        yield f"{name}_max", Column(motion.unit, f"greatest {words} {_LATE}{needed}")


def _counts(name: str, what: str, parts: Iterable[str]) -> Columns:
    """Events per period, of all parts together and of each."""
    per = f"per excitation period {_LATE}"
    by_part = {f"{name}_{part}": Column("1", f"{what} of {part} {per}") for part in parts}
    return {name: Column("1", f"{what} {per}"), **by_part}


def totals(of: Quantities) -> Columns:
    """Totals of the whole run."""
    whole = "in the whole run"
    margin = Column(of.gaps[""], f"smallest gap at a turn without contact {whole}")
    return {
        **({"impacts": Column("1", f"beginnings of contact {whole}")} if of.has_stop else {}),
        **({"sticks": Column("1", f"beginnings of stick {whole}")} if of.has_friction else {}),
        "events": Column("1", f"events {whole}"),
        **({"grazing_margin": margin} if of.has_stop else {}),
        "t_reached": Column("s", "time that the run reached"),
        "wall_time": Column("s", "time that the point took to compute, waiting included"),
    }


def end_state(of: Quantities) -> Columns:
    """The state that a carried sweep goes on from."""
    rotor = {
        "phi": Column("rad", _END.format("rotor angle, reduced to one turn,")),
        "phidot": Column("rad s-1", _END.format("rotor speed")),
    }
    angles = {
        phi: Column("rad", _END.format(f"{phi}, reduced to one turn,")) for phi, _ in of.rotors.values()
    }
    known = {**angles, **rotor}
    return {
        f"end_{name}": known.get(name) or Column(written_unit(unit), _END.format(name))
        for name, (_, unit) in of.starts.items()
    }


def last_points(count: int) -> str:
    """In words: "the last 100 stroboscopic points"; of one "the last stroboscopic point"."""
    return f"the last {counted(count, 'stroboscopic point').removeprefix('1 ')}"


def section(of: Quantities) -> Columns:
    """The last stroboscopic points."""
    points = "at the last stroboscopic points"
    columns = {
        name: Column(f"{motion.unit} s-1", f"{motion.rate_words} {points}", dimension="section")
        if is_rate
        else Column(motion.unit, f"{motion.words if of.of_parts else RELATIVE} {points}", dimension="section")
        for name, (motion, is_rate) in of.sections.items()
    }
    for name, (_, w) in of.rotors.items():
        columns[f"section_{w}"] = Column("Hz", f"speed of {name} {points}", dimension="section")
    for name, unit in of.states.items():
        columns[f"section_{name}"] = Column(unit, f"{name} {points}", dimension="section")
    speed = Column("Hz", f"motor speed {points}", dimension="section")
    return {**columns, "section_speed": speed} if of.has_motor else columns


# The attractor that a run ends on, as it is stored. How a run is labelled with it stands in
# `vibsim.sweeps.attractor_labels`, which is loaded where attractors are asked for.


KINDS = {
    "undecided": 0,
    "rest": 1,
    "periodic": 2,
    "quasi-periodic": 3,
    "chaotic": 4,
    "running away": 5,
    "turning": 6,  # for ever, with nothing that drives it
}
REASONS = {  # why a run is undecided
    "decided": 0,
    "no section": 1,
    "too few cycles": 2,
    "still on its way": 3,
    "no stable orbit": 4,
    "tests disagree": 5,
}
NONE = -1  # the number of no attractor, as of an undecided run
ATTRACTOR_TITLE = "attractor that the run ends on: rest, orbit, quasi-periodic or chaotic set"
NAME = "attractor"
INITIAL = "initial."  # begins the keys of what a run starts from


def attractor_columns(of: Quantities) -> Columns:
    """Columns stored of each point; `vibsim.sweeps.attractors` makes numbers of attractors of them."""
    unknowns, observed = "unknown", "observable"
    return {
        "attractor_kind": Column("1", "what the run ends on", flags=KINDS),
        "attractor_reason": Column("1", "why it is undecided", flags=REASONS),
        "attractor_period": Column("1", "returns to the section that its orbit takes; NaN of other kinds"),
        "attractor_multiplier": Column("1", "greatest modulus of the multipliers of its orbit"),
        "attractor_time": Column("s", "when it was sure to end there; NaN: at the end of the run"),
        "attractor_state": Column("1", "state on the section of its orbit or rest, SI", dimension=unknowns),
        "attractor_means": Column("1", "means over its section, of sets, SI", dimension=observed),
        "attractor_errors": Column("1", "standard errors of these, SI", dimension=observed),
    }


def unknowns(scene: Scene) -> int:
    """Number of unknowns of the orbits of a scene; 0 without a section."""
    from vibsim.orbits.coordinates import OrbitError, coordinates_of_rest

    try:
        return coordinates_of_rest(scene).count
    except OrbitError:
        return 0


def observed(scene: Scene) -> int:
    """Number of observables that tell sets apart, see `vibsim.analysis.attractor.observables`."""
    return 3 * unknowns(scene)
