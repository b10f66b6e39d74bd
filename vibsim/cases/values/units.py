"""The units that a case may use: a small table, exact factors, angular rate a dimension of its own.

A turn is not a number here: Hz, rpm and deg carry the flag `per_turn`, and their factor counts turns instead
of radians, so that 5.5 Hz stays 11/2 turns per second and pi enters in one rounding at the very end.
"""

import re
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple


class Unit(NamedTuple):
    """One unit: value [SI] = number * factor, or value [turns, turns per second] where per_turn."""

    name: str
    dimension: str
    factor: Fraction
    per_turn: bool = False


# The first unit of a dimension is its SI unit, the meaning of a bare number.
FACTORS: dict[str, dict[str, str]] = {
    "mass": {"kg": "1", "g": "1e-3", "t": "1e3"},
    "length": {"m": "1", "mm": "1e-3", "um": "1e-6", "cm": "1e-2"},
    "time": {"s": "1", "ms": "1e-3", "us": "1e-6", "min": "60", "h": "3600"},
    "velocity": {"m/s": "1", "mm/s": "1e-3", "cm/s": "1e-2", "m/min": "1/60"},
    "inverse velocity": {"s/m": "1", "s/mm": "1e3", "s/cm": "1e2"},
    "acceleration": {"m/s^2": "1", "mm/s^2": "1e-3", "cm/s^2": "1e-2"},
    "force": {"N": "1", "mN": "1e-3", "kN": "1e3"},
    "stiffness": {"N/m": "1", "N/mm": "1e3", "kN/m": "1e3", "kN/mm": "1e6", "MN/m": "1e6", "N/cm": "1e2"},
    "damping": {"N s/m": "1", "N s/mm": "1e3", "kN s/m": "1e3", "kg/s": "1"},
    "inertia": {"kg m^2": "1", "g m^2": "1e-3", "kg cm^2": "1e-4", "g cm^2": "1e-7", "kg mm^2": "1e-6"},
    "torque": {"N m": "1", "mN m": "1e-3", "kN m": "1e3", "N cm": "1e-2", "N mm": "1e-3"},
    "angle": {"rad": "1"},
    "angular rate": {"rad/s": "1"},
    "number": {"": "1"},
}
FACTORS_IN_TURNS: dict[str, dict[str, str]] = {
    "angle": {"deg": "1/360", "turn": "1"},
    "angular rate": {"Hz": "1", "rpm": "1/60", "rev/s": "1", "deg/s": "1/360"},
}
SPELLINGS = {
    "Nm": "N m", "mNm": "mN m", "kNm": "kN m", "Ncm": "N cm", "Nmm": "N mm",
    "Ns/m": "N s/m", "Ns/mm": "N s/mm", "kNs/m": "kN s/m", "m/s/s": "m/s^2",
    "sec": "s", "hour": "h", "hr": "h", "degree": "deg", "degrees": "deg", "rev": "turn", "turns": "turn",
    "rev/min": "rpm", "1/min": "rpm", "turn/s": "rev/s", "turns/s": "rev/s", "cycles/s": "Hz",
}  # fmt: skip


def _table() -> dict[str, Unit]:
    units = {}
    for table, per_turn in ((FACTORS, False), (FACTORS_IN_TURNS, True)):
        for dimension, factors in table.items():
            for name, factor in factors.items():
                units[name] = Unit(name, dimension, Fraction(factor), per_turn)
    return units


UNITS = _table()


def si_unit(dimension: str) -> Unit:
    """The SI unit of a dimension: what a bare number is in."""
    return UNITS[next(iter(FACTORS[dimension]))]


def unit_names(dimension: str) -> list[str]:
    """Names of the units of a dimension; for angular rate the cycles come first, as people mean them."""
    turns, radians = FACTORS_IN_TURNS.get(dimension, {}), FACTORS[dimension]
    ordered = [*turns, *radians] if dimension == "angular rate" else [*radians, *turns]
    return [name for name in ordered if name]


def canonical_spelling(text: str) -> str:
    """One spelling for all: "N*s/m", "N.s/m" and "N·s/m" are "N s/m", "kg m²" is "kg m^2", "µm" is "um"."""
    name = text.replace("\u00b2", "^2").replace("**", "^").replace("\u00b5", "u").replace("\u03bc", "u")
    name = name.replace("\u00b0", "deg")
    name = re.sub(r"[*.\u00b7\u22c5\u00d7]", " ", name)
    name = re.sub(r"(?<=[A-Za-z])2$", "^2", name.strip())
    name = re.sub(r"\s*([/^])\s*", r"\1", name)
    name = re.sub(r"\s+", " ", name)
    if name.endswith("m^2") and name[:-3] in ("kg", "g"):
        name = f"{name[:-3]} m^2"
    return SPELLINGS.get(name, name)


@lru_cache(maxsize=256)
def find_unit(text: str) -> Unit | None:
    """The unit that `text` names in any accepted spelling, or None."""
    name = text if text in UNITS else canonical_spelling(text)
    return UNITS.get(name) if name else None
