"""Computations of a sweep on demand: section, velocities and power of contacts, certificate, end state."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.engine.blocks import Block
from vibsim.engine.columns import OF_IMPACTS, of_kinds, part_columns, stop_column
from vibsim.engine.resume import Row, rows_of_instant
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.elementary import mean
from vibsim.physics.parts import IMPACTS, Scene, columns_of
from vibsim.physics.rates import Period, common_period, turning_columns
from vibsim.results.file_contents import Column
from vibsim.sweeps.quantities import RELATIVE_RATE, Columns, MeasuredMotion, Quantities, distinct
from vibsim.sweeps.statistics import BEFORE, MeasuredRun, velocities

if TYPE_CHECKING:
    from vibsim.analysis.attractor import KnownOrbits


@dataclass(frozen=True)
class Task:
    """A run of `scene`, in which what `of` names is measured.

    Attributes
    ----------
    begin : time at which the transient ends [s]
    section : length of sections
    known : stable orbits of the scene with which the run is compared, or None
    """

    scene: Scene
    of: Quantities
    begin: float
    section: int
    known: "KnownOrbits | None" = None


# The beginnings of contact of a run, block by block: when, where, how fast, at what phase of the source.


TURN = 2 * math.pi
Contact = dict[str, np.ndarray]


class Contacts:
    """Beginnings of contact from the time `begin` [s] on. Memory grows with their number."""

    def __init__(self, task: Task):
        self._task, self._scene = task, task.scene
        self._names = [stop.name for stop in task.scene.stops]
        self._rates = [MeasuredMotion("", "", "", "", stop.P, stop.Q) for stop in task.scene.stops]
        columns = part_columns(task.scene)
        self._numbers = [columns.index(stop_column(name)) for name in self._names]
        self._turning = turning_columns(task.scene)
        self._period = None if self._turning else common_period(task.scene)
        self._parts: list[Contact] = []

    def update(self, block: Block) -> None:
        """Take the next block."""
        events = block.events
        chosen = OF_IMPACTS[events["kind"]] & (events["t"] >= self._task.begin)
        self._parts.append(self._of({name: column[chosen] for name, column in events.items()}))

    def _of(self, events: Contact) -> Contact:
        columns = {"t": events["t"], "part": events["part"], "velocity": self._velocity(events)}
        if self._scene.has_motor:
            columns |= {"phase": events["phase"] / TURN, "speed": events["phidot"] / TURN}
        elif self._turning is not None:
            columns["phase"] = np.mod(events[self._turning[0]] / TURN, 1.0)
        elif self._period is not None:
            columns["phase"] = _phase(self._period, events["t"])
        return columns

    def _velocity(self, events: Contact) -> np.ndarray:
        """v_P - v_Q of the stop that each contact is at, in front of it [m/s] (n)."""
        before = {name.removeprefix(BEFORE): c for name, c in events.items() if name.startswith(BEFORE)}
        states = {**events, **before, "time": events["t"]}
        velocity = np.zeros(len(events["t"]))
        for number, each in zip(self._numbers, velocities(self._scene, self._rates, states), strict=True):
            at = events["part"] == number
            velocity[at] = each[at]
        return velocity

    def table(self, stop: str = "") -> Contact:
        """Each (n), of one stop or of all: t [s], velocity v_P - v_Q [m/s], with a source its phase [turns],
        speed [Hz].
        """
        names = self._parts[0] if self._parts else ("t", "part", "velocity")
        whole = {name: np.concatenate([part[name] for part in self._parts]) for name in names}
        number = self._numbers[self._names.index(stop)] if stop else None
        at = whole["part"] == number if stop else slice(None)
        return {name: column[at] for name, column in whole.items() if name != "part"}


def _phase(period: Period, t: np.ndarray) -> np.ndarray:
    """Phase in a common period of `turns` turns [turns of the period], 0 to 1."""
    cycles = t * period.cycles + t * period.cycles_lo
    turns = cycles / period.turns
    return turns - np.floor(turns)


# The Poincare section at contact: the states in which the last contacts began (there g = 0).
#
# In a scene of named parts each stop has a section of its own.


CONTACT_SECTION_TITLE = "Poincare section at the beginning of contact"


def contact_section_columns(of: Quantities) -> Columns:
    """Velocity, phase and motor speed at the last contacts of each stop; none without a stop."""
    columns_of_parts: Columns = {}
    for stop in _stops(of):
        at = "at the last beginnings of contact" + (f" with {stop}" if stop else "")
        rate = f"velocity v_P - v_Q of {stop}" if stop else RELATIVE_RATE
        columns_of_parts[_name("velocity", stop)] = Column(
            f"{of.gaps[stop]} s-1", f"{rate} {at}", dimension="contact"
        )
        if of.has_source:
            columns_of_parts[_name("phase", stop)] = Column(
                "1", f"phase of the source in turns, 0 to 1, {at}", "contact"
            )
        if of.has_motor:
            columns_of_parts[_name("speed", stop)] = Column("Hz", f"motor speed {at}", dimension="contact")
    return columns_of_parts


def _stops(of: Quantities) -> tuple[str, ...]:
    """Names of the stops; of the two blocks' one stop, no name."""
    return (of.stops if of.of_parts else ("",)) if of.has_stop else ()


def _name(quantity: str, stop: str) -> str:
    return f"contact_{quantity}_{stop}" if stop else f"contact_{quantity}"


class ContactSection:
    """The last contacts of one run."""

    def __init__(self, task: Task):
        self._contacts, self._of, self._count = Contacts(task), task.of, task.section

    def update(self, block: Block) -> None:
        """Take the next block."""
        self._contacts.update(block)

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, Any]:
        """The last contacts, oldest first."""
        sections: dict[str, Any] = {}
        for stop in _stops(self._of):
            table = self._contacts.table(stop)
            first = max(len(table["t"]) - self._count, 0)
            sections |= {_name(name, stop): column[first:] for name, column in table.items() if name != "t"}
        return sections


# The spectrum of impact velocities: how fast the ends of a stop approach each other when contact begins.
#
# As quantiles, which need no bins that suit all points of a sweep: the inverse of the distribution function.
# In a scene of named parts of all stops together, and of each.


IMPACT_VELOCITY_TITLE = "spectrum of impact velocities"
QUANTILES = np.arange(21) / 20


def impact_velocity_columns(of: Quantities) -> Columns:
    """Mean and quantiles; none without a stop."""
    return distinct(*(_columns_of(stop, of.gaps[stop]) for stop in ("", *of.stops))) if of.has_stop else {}


def _columns_of(stop: str, length: str) -> Iterator[tuple[str, Column]]:
    contacts = f"contact with {stop}" if stop else "contact"
    words = f"relative velocity at the beginnings of {contacts} in the whole periods after the transient"
    mean_name, spectrum = _names(stop)
    yield mean_name, Column(f"{length} s-1", f"mean {words}")
    yield (
        spectrum,
        Column(f"{length} s-1", f"quantiles of the {words}; 0: least, 1: greatest", dimension="quantile"),
    )


def _names(stop: str) -> tuple[str, str]:
    """Columns of mean and quantiles, of one stop or of all."""
    behind = f"_{stop}" if stop else ""
    return f"impact_velocity_mean{behind}", f"impact_velocity{behind}"


class ImpactVelocity:
    """Impact velocities |v_P - v_Q| [m/s] of one run."""

    def __init__(self, task: Task):
        self._contacts, self._stops = Contacts(task), ("", *task.of.stops)

    def update(self, block: Block) -> None:
        """Take the next block."""
        self._contacts.update(block)

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, Any]:
        """Mean and quantiles; nothing where there was no impact."""
        spectra: dict[str, Any] = {}
        for stop in self._stops:
            contacts = self._contacts.table(stop)
            inside = (contacts["t"] >= window[0]) & (contacts["t"] < window[1])
            speeds = np.abs(contacts["velocity"][inside])
            if len(speeds):
                values = float(mean(speeds)), np.quantile(speeds, QUANTILES)
                spectra |= zip(_names(stop), values, strict=True)
        return spectra


# How near to grazing the steady motion is: the smallest gap at which the ends of a stop turn back.


GRAZING_TITLE = "grazing margin after the transient"
NAME = "grazing_margin_late"


def grazing_columns(of: Quantities) -> Columns:
    """The margin of all stops, and of each; none without a stop."""
    words = "smallest gap at a turn without contact{} after the transient"
    names = ("", *of.stops) if of.has_stop else ()
    return {
        f"{NAME}_{stop}" if stop else NAME: Column(
            of.gaps[stop], words.format(f" with {stop}" if stop else "")
        )
        for stop in names
    }


class Grazing:
    """Grazing margins of one run after its transient; the engine's total is that of the whole run."""

    def __init__(self, task: Task):
        self._stops = task.of.stops

    def update(self, block: Block) -> None:
        """The engine keeps them."""

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, float]:
        """The margins; nothing where no turn was seen."""
        margins = run.extremes[2]
        by_stop = dict(zip((f"{NAME}_{name}" for name in self._stops), margins, strict=False))
        return {name: one for name, one in {NAME: min(margins), **by_stop}.items() if math.isfinite(one)}


# Where the power goes: what sources give on the average, and what dampers, friction and storage take.
#
# From the energy ledger of the engine, over the whole periods after the transient; so what is given = what is
# taken, to round-off (first law). In a scene of named parts each force, damper, stop, friction and belt has a
# column of its own beside the sums.


POWER_TITLE = "mean power of the sources, and where it goes"
_SPAN = "over the whole periods after the transient"
SUMS = {  # column -> total of the ledger
    "power_source": "work_source",
    "power_base": "work_base",
    "power_belts": "work_belt",
    "power_damper": "loss_viscous",
    "power_stops": "loss_stops",
    "power_friction": "loss_friction",
}
WORDS = {
    "power_source": "mean power that forces and motor give",
    "power_base": "mean power that the moving base gives",
    "power_belts": "mean power that belts give",
    "power_damper": "mean power that the dampers of links take",
    "power_stops": "mean power that stops take",
    "power_friction": "mean power that friction takes",
}
STORED = Column("W", f"mean rate at which the stored energy grows, {_SPAN}")

Rows = list[Row]


def power_columns(of: Quantities) -> Columns:
    """Sums and, in a scene of named parts, the power of each part; none without a source."""
    if not of.is_powered:
        return {}
    if not of.of_parts:
        return {
            "power_source": Column("W", f"mean power that the source gives, {_SPAN}"),
            "power_damper": Column("W", f"mean power that the damper takes, {_SPAN}"),
            "power_friction": Column("W", f"mean power that friction takes, {_SPAN}"),
            "power_stored": STORED,
        }
    sums = {name: Column("W", f"{words}, {_SPAN}") for name, words in WORDS.items()}
    each = {name: Column("W", f"{words}, {_SPAN}") for name, (_, words) in of.powers.items()}
    return {**sums, "power_stored": STORED, **each}


class Power:
    """Mean powers [W] of one run, whose ledger is kept from the end of the transient on."""

    def __init__(self, task: Task):
        self._scene = task.scene
        self._entries = {**SUMS, **{name: entry for name, (entry, _) in task.of.powers.items()}}
        self._last: Rows | None = None  # of events of one instant
        self._before_period_end: Rows | None = None  # events that the last period's end follows on

    def update(self, block: Block) -> None:
        """Remember the last event before the last stroboscopic point."""
        times, marks = block.events["t"], block.section["time"]
        if len(marks):
            before = times.searchsorted(marks[-1], side="right")
            self._before_period_end = self._rows(block, before - 1) if before else self._last
        if len(times):
            self._last = self._rows(block, len(times) - 1)

    def _rows(self, block: Block, at: int) -> Rows:
        return rows_of_instant(block.events, at, self._last or ())

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, float]:
        """Changes of the ledger's entries within the window, by its length; nothing of one without length.

        The ledger is that of a run from the events `run.rows` to the end. What lies outside the window, from
        that event to the first period and from the last one on, is run once more and taken off.
        """
        first, last = window
        if not last > first:
            return {}
        sums = _less(*(self._ledger(run, run.rows, t) for t in (run.t_reached, first)))
        if last < run.t_reached:
            behind = [self._ledger(run, self._before_period_end, t) for t in (last, run.t_reached)]
            sums = _less(sums, _less(behind[1], behind[0]))
        return {name: energy / (last - first) for name, energy in sums.items()}

    def _ledger(self, run: MeasuredRun, rows: Rows | None, t_end: float) -> dict[str, float]:
        """The ledger from an instant of events to a later time [s], which is as the run itself had it."""
        quiet = replace(self._scene, t_end=t_end).without_samples()
        trajectory = open_trajectory(quiet, resume=rows, ledger=True)
        for _ in trajectory.blocks():
            run.ask()
        return self._energies(trajectory.totals)

    def _energies(self, totals: dict[str, Any]) -> dict[str, float]:
        """Energies [J] by column; a part that is not in the scene, as friction with mu = 0, has none."""
        stored = totals["energy_end"] - totals["energy_start"]
        return {"power_stored": stored, **{name: totals.get(at, 0.0) for name, at in self._entries.items()}}


def _less(energies: dict[str, float], others: dict[str, float]) -> dict[str, float]:
    return {name: value - others[name] for name, value in energies.items()}


# Whether it is proved that no event of the run was missed.


CERTIFICATE_TITLE = "stretches in which an event may have been missed"


def certificate_columns(of: Quantities) -> Columns:
    """The number of doubtful stretches."""
    stretches = "stretches of the whole run in which an event may have been missed; 0: all are certified"
    return {"uncertified": Column("1", stretches)}


class CertificateComputation:
    """Certificate of one run."""

    def __init__(self, task: Task):
        pass

    def update(self, block: Block) -> None:
        """The engine counts them."""

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, float]:
        """The engine's total, of transient and rest."""
        return {"uncertified": run.totals["uncertified"]}


# What a motion without a source that changes comes to: rest, or vibration that goes on.
#
# Judged on the time after the transient, in two halves. Where stops or frictions go on to change their states
# in the second half, the motion is a vibration (stick-slip, impacts): events are exact, so no threshold
# decides. Where they do not, it is smooth, and rests if its kinetic energy falls from one half to the other.


END_STATE_TITLE = "rest or vibration, without a source that changes"
END_STATE = "end_state"
VERDICTS = {"undecided": 0, "rest": 1, "vibration": 2}
OF_FRICTION = ("reversal", "stick_begin", "stick_end")
CHANGES = (*OF_FRICTION, *IMPACTS, "contact_end", "rest_begin", "rest_end")
OF_CHANGES = of_kinds(CHANGES)
FALLS = 0.99  # of the greatest kinetic energy in the first half
CLEARLY = 0.5  # the same of a fall that samples which miss the peaks by much do not make up
# of the sampling interval: near the golden ratio of a sixteenth, so that samples do not meet each cycle of a
# vibration at the same phases
FINER = Fraction(55, 16 * 89)
MOST_FINER = 10**7  # samples


def end_state_columns(of: Quantities) -> Columns:
    """The verdict; none with a source, whose motions have a regime."""
    return {} if of.has_source else {END_STATE: Column("1", "what the motion comes to", flags=VERDICTS)}


class EndState:
    """End state of one run. Memory grows with its samples and events after the transient."""

    def __init__(self, task: Task):
        self._scene, bodies = task.scene, task.scene.line
        self._half_masses = {columns_of(body.name)[1]: float(body.m) / 2 for body in bodies}
        self._changes: list[np.ndarray] = []
        self._times: list[np.ndarray] = []
        self._energies: list[np.ndarray] = []

    def update(self, block: Block) -> None:
        """Take the next block."""
        events, samples = block.events, block.samples
        self._changes.append(events["t"][OF_CHANGES[events["kind"]]])
        self._times.append(samples["time"])
        self._energies.append(self._energies_of(block))

    def _energies_of(self, block: Block) -> np.ndarray:
        """Kinetic energies of the bodies at the samples of a block [J]."""
        energy = np.zeros(len(block.samples["time"]))
        for v, half in self._half_masses.items():
            energy = energy + half * block.samples[v] ** 2
        return energy

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, float]:
        """The verdict on the window."""
        middle = (window[0] + window[1]) / 2
        if any(len(changes) and changes[-1] >= middle for changes in self._changes):
            return {END_STATE: float(VERDICTS["vibration"])}
        times, energies = np.concatenate(self._times), np.concatenate(self._energies)
        late, early = times >= middle, (times >= window[0]) & (times < middle)
        known = late.any() and early.any()
        greatest = (energies[early].max(), energies[late].max()) if known else (0.0, math.inf)
        if CLEARLY * greatest[0] < greatest[1] <= FALLS * greatest[0]:
            greatest = self._by_finer_samples(window, run) or greatest
        falls = greatest[1] <= FALLS * greatest[0]
        return {END_STATE: float(VERDICTS["rest" if falls else "undecided"])}

    def _by_finer_samples(self, window: tuple[float, float], run: MeasuredRun) -> tuple[float, float] | None:
        """The greatest kinetic energies of both halves of the window [J], from samples that meet sharp peaks,
        as of a relaxation oscillation, too; None where these would be too many.
        """
        scene, middle = self._scene, (window[0] + window[1]) / 2
        every = Fraction(scene.every_num, scene.every_den) * FINER
        if window[1] > MOST_FINER * every:
            return None
        finer = replace(scene, every_num=every.numerator, every_den=every.denominator)
        greatest = [0.0, 0.0]
        for block in open_trajectory(finer, run.rows).blocks():
            run.ask()
            times, energies = block.samples["time"], self._energies_of(block)
            for half, (begin, end) in enumerate(((window[0], middle), (middle, math.inf))):
                within = (times >= begin) & (times < end)
                greatest[half] = max(greatest[half], float(energies[within].max(initial=0.0)))
        return greatest[0], greatest[1]
