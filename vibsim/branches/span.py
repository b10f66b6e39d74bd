"""Ranges of a parameter: FROM:TO with a unit."""

import re
from math import nan

from vibsim.branches.curve.scene_path import ScenePath
from vibsim.branches.plan import BranchError
from vibsim.cases import Case, UnknownKeyError
from vibsim.cases.problems import shown
from vibsim.cases.schema.keys import measured_at
from vibsim.cases.values.ranges import parse_range, without_log
from vibsim.cases.values.units import UNITS, si_unit

FACTORS = {"": 1.0, "J": 1.0, "mJ": 1e-3, "uJ": 1e-6, "kJ": 1e3}
ENERGIES = re.compile(r"\s*(?P<ends>[^:\sa-df-zA-DF-Z]+:[^:\sa-df-zA-DF-Z]+)\s*(?P<unit>[mku]?J|)\s*")


def read_span(case: Case, key: str, text: str) -> tuple[tuple[str, ...], str, tuple[float, float]]:
    """Dotted keys, unit and ends of a range such as "3:9 Hz" of a key, or of several, KEY=KEY.

    Raises BranchError where it is no range or its ends are not allowed, UnknownKeyError for a key that is
    none of the case's numbers.
    """
    if not key or not isinstance(key, str):
        raise BranchError("name what is to vary: a key of the case, such as excitation.Omega0")
    keys = tuple(number_key(case, each.strip()) for each in key.split("="))
    dimension = _dimension(keys[0])
    try:
        if text.count(":") != 1 or without_log(text) is not None:
            raise ValueError(text)
        low, high = parse_range(f"{text}/2", _bare_unit(dimension))
    except ValueError as error:
        raise BranchError(f"{shown(text)} is not FROM:TO with an optional unit, such as 3:9 Hz") from error
    if UNITS[low.unit].dimension != dimension:
        raise BranchError(f"{keys[0]} is no {UNITS[low.unit].dimension}: {shown(text)}")
    ends = float(low.value), float(high.value)
    path = ScenePath(case, keys, low.unit)
    for end in ends:
        try:
            path.scene(end)
        except ValueError as error:
            raise BranchError(str(error)) from error
    return keys, low.unit, ends


def read_energy_span(text: str) -> tuple[float, float]:
    """Ends [J] of a range of energies such as "1e-5:0.1 J"; bare numbers are J. Raises BranchError."""
    match = ENERGIES.fullmatch(text)
    try:
        low, high = (float(each) for each in match["ends"].split(":")) if match else (nan, nan)
    except ValueError:
        match = None
    if match is None:
        raise BranchError(f"{shown(text)} is not FROM:TO with an optional unit, such as 0.01:1 J or 5:50 mJ")
    low, high = low * FACTORS[match["unit"]], high * FACTORS[match["unit"]]
    if not 0 < low < high:
        raise BranchError(f"{shown(text)}: energies must be above 0 and the first the lesser")
    return low, high


def number_key(case: Case, key: str) -> str:
    """The dotted key of a number of the case. Raises UnknownKeyError that names the key."""
    try:
        case.quantity(key)
        return case.full_key(key)
    except UnknownKeyError as error:
        words = str(error)
        raise UnknownKeyError(words if words.startswith(f"{key} ") else f"{shown(key)}: {words}") from None


def _dimension(key: str) -> str:
    measured = measured_at(key)
    return measured.dimension if measured else "number"


def _bare_unit(dimension: str) -> str:
    return "Hz" if dimension == "angular rate" else si_unit(dimension).name
