"""A periodic orbit, and what is known of it."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import cached_property
from math import inf
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.cases.quantities import number
from vibsim.engine.trajectory import Trajectory, open_trajectory
from vibsim.orbits.coordinates import case_on_orbit, placed
from vibsim.orbits.return_map import returns
from vibsim.orbits.stability import exponents_of, multipliers_of, sides_of_circle, sliding_margin
from vibsim.orbits.words import Word, circle, spelled
from vibsim.results.labelled import Arrays, Labelled, few
from vibsim.results.recording import Recording, TrajectoryWriter
from vibsim.results.result import Result
from vibsim.results.simulation import simulate
from vibsim.results.trajectory_file import DATASETS, DIGITS, GROUP, TrajectoryFile
from vibsim.signals import held_back

if TYPE_CHECKING:
    from vibsim.cases.case import Case
    from vibsim.orbits.newton import Solution
    from vibsim.orbits.orbit_digits import OrbitDigits
    from vibsim.orbits.return_map import Return, ReturnMap
    from vibsim.physics.parts import Scene


@dataclass(frozen=True, repr=False)
class Orbit(Labelled):
    """One orbit of a scene.

    return_map, solution : the map over its n periods, and its fixed point
    case : the case it belongs to, or None

    >>> import vibsim
    >>> orbit = vibsim.orbit("gallery/friction-oscillator")
    >>> orbit.n, bool(orbit.stable), round(orbit.period, 6), abs(orbit.multipliers).round(4)
    (1, True, 6.981317, array([0.5694, 0.0872]))
    """

    return_map: ReturnMap
    solution: Solution = field(repr=False)
    case: Case | None = None

    @property
    def scene(self) -> Scene:
        return self.return_map.scene

    @property
    def n(self) -> int:
        """Periods of the source, or turns of the motor, that it takes."""
        return self.return_map.n

    @property
    def end(self) -> Return:
        """The motion over one period, as `Return`."""
        return self.solution.end

    @property
    def period(self) -> float:
        """[s]"""
        return self.end.T

    @property
    def X(self) -> np.ndarray:
        """The unknowns on the section."""
        return self.end.X

    @property
    def coordinates(self) -> dict[str, float]:
        """The unknowns on the section by name, e.g. x1-x2 [m]."""
        return self.end.coordinates.named(self.X)

    @property
    def state(self) -> dict[str, float]:
        """The state on the section by name of the column; what may be shifted stands at 0."""
        return self.end.coordinates.state(self.X)

    @cached_property
    def multipliers(self) -> np.ndarray:
        """Complex, the largest first; that of a shift along the orbit is left out where T is free."""
        return multipliers_of(self.end)

    @cached_property
    def exponents(self) -> list[float]:
        """ln |multiplier| / period [1/s]."""
        return exponents_of(self.multipliers, self.period)

    @property
    def stable(self) -> bool:
        """Whether all multipliers are inside the unit circle, by more than rounding."""
        inside, _, _ = sides_of_circle(self.multipliers)
        return inside == len(self.multipliers)

    @property
    def events(self) -> Word:
        """(kind, number of the part) in the order from the section."""
        return self.end.events

    @property
    def word(self) -> Word:
        """The events as a circle: the least rotation of them."""
        return circle(self.events)

    @property
    def spelled(self) -> str:
        """The events in letters, from the section."""
        return spelled(self.scene, self.events)

    @property
    def drift(self) -> dict[str, float]:
        """By body that stands for a set held nowhere: its displacement per period [m]."""
        return self.end.drift

    @property
    def turns(self) -> dict[str, int]:
        """Whole turns in a period by column of the angles that make any, such as that of a pendulum."""
        return self.end.coordinates.turns(self.X, self.end.carried.state)

    @property
    def drift_rates(self) -> dict[str, float]:
        """By body: its displacement per period over the period [m/s], 0 where something holds it."""
        bodies, reference, moved = self.scene.line, self.end.coordinates.reference, self.drift
        shifts = [moved[bodies[reference[i]].name] if i in reference else 0.0 for i in range(len(bodies))]
        return {body.name: shift / self.period for body, shift in zip(bodies, shifts, strict=True)}

    @property
    def residual(self) -> float:
        """The distance by which it fails to close [m/s]; displacements weigh by a natural rate."""
        return self.end.residual

    @property
    def margin(self) -> float:
        """Smallest gap at a turn without contact [m]; inf without any."""
        return self.end.margin

    @cached_property
    def sliding(self) -> float:
        """Smallest distance of a tie's force from its limit where a sliding velocity is zero [N]; inf without
        any.
        """
        return sliding_margin(self.scene, self.end.carried)

    @cached_property
    def energy(self) -> dict[str, float]:
        """Energy that went in and was lost in one period [J]: the sums of the ledger."""
        return energy_of(self)

    @cached_property
    def points(self) -> np.ndarray:
        """The unknowns at each of its n returns to the section, (n, m)."""
        return points_of(self)

    @cached_property
    def run(self) -> Result:
        """One period as a run, from the section on. Raises ValueError for the orbit of a scene alone."""

        return run_of_orbit(self)

    def save(self, path: str | PathLike[str], force: bool = False) -> Path:
        """Write the orbit to an HDF5 file, which every command takes; its absolute path.

        force : replace what is there

        Raises ResultFileError where it cannot be written, ValueError for an orbit of a scene without a case.
        """

        target = Path(path).absolute()
        save_orbit(self, target, force)
        return target

    def arrays(self) -> Arrays:
        """The columns of one period on it, over time."""
        return self.run.arrays()

    def heading(self) -> str:
        """Name of the case, period, and whether it is stable."""
        name = f"of {self.case.name}: " if self.case is not None else ""
        _, on_circle, outside = sides_of_circle(self.multipliers)
        stability = "unstable" if outside else "neither stable nor unstable" if on_circle else "stable"
        return f"{name}period {self.period:.8g} s, {stability}"

    def lines(self) -> list[tuple[str, str]]:
        """Unknowns on the section, events, multipliers and margin."""
        start = ", ".join(f"{name} = {number(value, 6)}" for name, value in self.coordinates.items())
        multipliers = few(_text(mu) for mu in self.multipliers.tolist())
        return [
            ("section", start),
            ("events", self.spelled or "none"),
            ("multipliers", multipliers or "none"),
            ("margin", "no turn of a gap" if self.margin == inf else f"{number(self.margin, 5)} m"),
        ]

    @property
    def certified(self) -> bool:
        """Whether it is sure that no event was missed on it."""
        return self.end.uncertified == 0


def _text(mu: complex) -> str:
    sign = "-" if mu.imag < 0 else "+"
    return f"{number(mu.real, 5)}{sign}{number(abs(mu.imag), 5)}i"


# An orbit as a run of one period, in memory or in a file for every command, with what is known of it.


def run_of_orbit(orbit: Orbit) -> Result:
    """One period in memory, with what its file would know of the orbit.

    Raises ValueError for an orbit of a scene without a case.
    """
    if orbit.case is None:
        raise ValueError("the orbit of a scene alone has no case to be run")
    run = simulate(case_on_orbit(orbit.case, orbit.state, orbit.period))
    known = {name: value for name, value in _attributes(orbit).items() if value is not None}
    arrays = {
        name: np.asarray(values, dtype=object if isinstance(values[0], str) else None)
        for name, values in _values(orbit).items()
    }
    samples = {name: run[name] for name in run}
    return Result({**run.attrs, **known}, samples, dict(run.events), case=run.case, orbit=arrays)


def save_orbit(
    orbit: Orbit, path: str | Path, force: bool = False, digits: OrbitDigits | None = None
) -> Result:
    """Write an orbit to an HDF5 file and open it.

    digits : the orbit in many digits, or None. Raises ResultFileError where it cannot be written, ValueError
    for an orbit of a scene without a case.
    """
    if orbit.case is None:
        raise ValueError("an orbit of a scene alone has no case to be stored with")
    case = case_on_orbit(orbit.case, orbit.state, orbit.period)
    recording = Recording(case)
    start = {**recording.start, **_attributes(orbit, digits)}
    with ExitStack() as at_the_end:
        with held_back():
            writer = TrajectoryWriter(path, recording.tables, start, force)
            at_the_end.callback(writer.close)
        recording.into(writer)
        values = {f"{GROUP}/{name}": value for name, value in _values(orbit, digits).items()}
        writer.attach(DATASETS + (DIGITS if digits else []), values)
        target = writer.finish(recording.end())
    file = TrajectoryFile(target)
    return Result(file.attrs, file.samples, file.events, case=file.case, orbit=file.orbit)


def _attributes(orbit: Orbit, digits: OrbitDigits | None = None) -> dict[str, Any]:
    return {
        "orbit_periods": orbit.n,
        "orbit_period_s": orbit.period,
        "orbit_stable": int(orbit.stable),
        "orbit_events": orbit.spelled,
        "orbit_residual": orbit.residual,
        "orbit_sliding_margin": orbit.sliding,
        "orbit_digits": digits.digits if digits else None,
    }


def _values(orbit: Orbit, digits: OrbitDigits | None = None) -> dict[str, Any]:
    """By name within the group of the file."""
    at, multipliers = orbit.end.coordinates, orbit.multipliers
    values = {
        "unknown": at.names,
        "units": at.units,
        "multiplier": np.arange(len(multipliers)),
        "multiplier_real": multipliers.real,
        "multiplier_imaginary": multipliers.imag,
        "return": np.arange(orbit.n),
        "points": orbit.points,
        "derivative": orbit.end.derivative,
    }
    if digits:
        real, imaginary = digits.multiplier_texts
        values |= {
            "digits_start": np.array(list(digits.coordinates.values()), dtype="S"),
            "digits_real": np.array(real, dtype="S"),
            "digits_imaginary": np.array(imaginary, dtype="S"),
        }
    return values


# What an orbit does in one period, from a run of that length: energies, and its points on the section.


WORKS = ("work_source", "work_base", "work_belt")
LOSSES = ("loss_viscous", "loss_stops", "loss_friction")
ENERGIES = (*WORKS, *LOSSES, "energy_residual")


def energy_of(orbit: Orbit) -> dict[str, float]:
    """Sums of the energy ledger over one period [J], by name."""
    trajectory = _run(orbit, ledger=True)
    for _ in trajectory.blocks():
        pass
    totals = trajectory.totals
    return {name: float(totals[name]) for name in ENERGIES}


def points_of(orbit: Orbit) -> np.ndarray:
    """The unknowns at each return to the section, (n, m); the first is the start."""
    at = orbit.end.coordinates
    rows = [orbit.X]
    if at.section.turning:
        if orbit.n > 1:
            scene = placed(orbit.scene, orbit.state, orbit.period)
            rows += list(at.of(returns(scene, at)[1]))
        return np.array(rows[: orbit.n])
    for block in _run(orbit, section=True).blocks():
        rows += list(at.of(at.gathered(block.section)))
    return np.array(rows[: orbit.n])


def _run(orbit: Orbit, section: bool = False, ledger: bool = False) -> Trajectory:
    scene = placed(orbit.scene, orbit.state, orbit.period)
    return open_trajectory(scene.without_samples(), section=section, ledger=ledger)
