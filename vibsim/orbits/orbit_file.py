"""An orbit as a run of one period, in memory or in a file for every command, with what is known of it."""

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.files.signals import held_back
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.returns.start import case_on_orbit
from vibsim.results.recording.recording import Recording
from vibsim.results.result import Result
from vibsim.results.simulation import simulate
from vibsim.results.stored.orbit_structure import DATASETS, DIGITS, GROUP
from vibsim.results.stored.trajectory_file import TrajectoryFile
from vibsim.results.stored.trajectory_writer import TrajectoryWriter

if TYPE_CHECKING:
    from vibsim.orbits.orbit_digits import OrbitDigits


def run_of_orbit(orbit: Orbit) -> Result:
    """One period in memory, with what its file would know of the orbit.

    Raises ValueError for an orbit of a scene without a case.
    """
    if orbit.case is None:
        raise ValueError("the orbit of a scene alone has no case to be run")
    run = simulate(
        case_on_orbit(orbit.case, orbit.state, orbit.period), engine=orbit.return_map.carrier.engine
    )
    known = {name: value for name, value in _attributes(orbit).items() if value is not None}
    arrays = {
        name: np.asarray(values, dtype=object if isinstance(values[0], str) else None)
        for name, values in _values(orbit).items()
    }
    samples = {name: run[name] for name in run}
    return Result({**run.attrs, **known}, samples, dict(run.events), case=run.case, orbit=arrays)


def save_orbit(
    orbit: Orbit, path: str | Path, force: bool = False, digits: "OrbitDigits | None" = None
) -> Result:
    """Write an orbit to an HDF5 file and open it.

    digits : the orbit in many digits, or None. Raises ResultFileError where it cannot be written, ValueError
    for an orbit of a scene without a case.
    """
    if orbit.case is None:
        raise ValueError("an orbit of a scene alone has no case to be stored with")
    case = case_on_orbit(orbit.case, orbit.state, orbit.period)
    recording = Recording(case, orbit.return_map.carrier.engine)
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


def _attributes(orbit: Orbit, digits: "OrbitDigits | None" = None) -> dict[str, Any]:
    return {
        "orbit_periods": orbit.n,
        "orbit_period_s": orbit.period,
        "orbit_stable": int(orbit.stable),
        "orbit_events": orbit.spelled,
        "orbit_residual": orbit.residual,
        "orbit_sliding_margin": orbit.sliding,
        "orbit_digits": digits.digits if digits else None,
    }


def _values(orbit: Orbit, digits: "OrbitDigits | None" = None) -> dict[str, Any]:
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
