"""What a sweep stores per point: names, units, definitions. The definitions go into every file."""

from collections.abc import Iterable, Iterator
from itertools import chain

from vibsim.files.declarations import Column
from vibsim.sweeps.statistics.quantities import RELATIVE, Quantities

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
        _amplitudes(of),
        _ranges(of),
        _drifts(of),
        _counts("impacts_per_period", "beginnings of contact", of.stops).items() if of.has_stop else (),
        _counts("sticks_per_period", "beginnings of stick", of.frictions).items() if of.has_friction else (),
        [("periods", Column("1", whole))],
    )


def _amplitudes(of: Quantities) -> Iterator[tuple[str, Column]]:
    for motion in of.motions:
        yield f"amplitude_{motion.name}", Column("m", _HALF.format(motion.words, "mean"))
        yield f"amplitude_{motion.name}_max", Column("m", _HALF.format(motion.words, "greatest"))


def _drifts(of: Quantities) -> Iterator[tuple[str, Column]]:
    for name, motion in of.drifting.items():
        line = f"slope of the least-squares line through {motion.words} at the stroboscopic points {_LATE}"
        yield name, Column("m s-1", line)


def _speeds() -> Columns:
    return {
        "mean_speed": Column("Hz", f"mean motor speed over the whole periods {_LATE}"),
        "min_speed": Column("Hz", f"least motor speed {_LATE}"),
        "max_speed": Column("Hz", f"greatest motor speed {_LATE}"),
    }


def _ranges(of: Quantities) -> Iterator[tuple[str, Column]]:
    """Least and greatest displacements; of the two blocks the greatest is the rest distance needed."""
    for name, motion in of.ranged.items():
        words, needed = (motion.words, "") if of.of_parts else (RELATIVE, ": the rest distance needed")
        yield f"{name}_min", Column("m", f"least {words} {_LATE}")
        yield f"{name}_max", Column("m", f"greatest {words} {_LATE}{needed}")


def _counts(name: str, what: str, parts: Iterable[str]) -> Columns:
    """Events per period, of all parts together and of each."""
    per = f"per excitation period {_LATE}"
    by_part = {f"{name}_{part}": Column("1", f"{what} of {part} {per}") for part in parts}
    return {name: Column("1", f"{what} {per}"), **by_part}


def totals(of: Quantities) -> Columns:
    """Totals of the whole run."""
    whole = "in the whole run"
    margin = Column("m", f"smallest gap at a turn without contact {whole}")
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
    units = {"x": "m", "v": "m s-1"}
    return {f"end_{name}": rotor.get(name) or Column(units[name[0]], _END.format(name)) for name in of.starts}


def section(of: Quantities) -> Columns:
    """The last stroboscopic points."""
    points = "at the last stroboscopic points"
    columns = {
        name: Column("m s-1", f"{motion.rate_words} {points}", dimension="section")
        if is_rate
        else Column("m", f"{motion.words if of.of_parts else RELATIVE} {points}", dimension="section")
        for name, (motion, is_rate) in of.sections.items()
    }
    speed = Column("Hz", f"motor speed {points}", dimension="section")
    return {**columns, "section_speed": speed} if of.has_motor else columns
