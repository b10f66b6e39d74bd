"""Numbers, symbols and units as they are written beside axes and curves."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from vibsim.cases.number import number

# Prefix per power of 1000; what is smaller or larger keeps the last one.
_PREFIXES = {3: "G", 2: "M", 1: "k", 0: "", -1: "m", -2: "µ", -3: "n"}
LARGEST_POWER = {"m": 1}  # nobody measures displacements in megametres
SIGNIFICANT = range(3, 17)  # digits of a rounded number: as few as tell the numbers apart
POSITIONAL = (1e-4, 1e6)  # magnitudes written without a power of ten


@dataclass(frozen=True)
class Scale:
    """A unit that suits the values: value in SI x factor = value in `unit`."""

    factor: float
    unit: str

    def __call__(self, values: ArrayLike) -> np.ndarray:
        return np.asarray(values) * self.factor

    def label(self, words: str) -> str:
        """An axis label, such as `Displacement (mm)`."""
        return f"{words} ({self.unit})"


def scale_for(unit: str, *values: Iterable[float]) -> Scale:
    """The prefix under which the largest magnitude among `values` (arrays in SI `unit`) lies in [1, 1000).

    All zero, or empty: no prefix.
    """
    arrays = [np.asarray(array, dtype=float) for array in values]
    largest = max(
        (float(np.nanmax(np.abs(a))) for a in arrays if a.size and not np.isnan(a).all()), default=0.0
    )
    if largest == 0.0 or not math.isfinite(largest):
        return Scale(1.0, unit)
    most = LARGEST_POWER.get(unit, max(_PREFIXES))
    power = min(max(math.floor(math.log10(largest) / 3 + 1e-12), min(_PREFIXES)), most)
    return Scale(1000.0 ** (-power), _PREFIXES[power] + unit)


def amount(value: float, unit: str) -> str:
    """A quantity in words, four digits and a prefix: 12600 N/m is `12.6 kN/m`."""
    scale = scale_for(unit, [value])
    return f"{_positional(float(f'{float(scale(value)):.4g}'))} {scale.unit}"


def rounded(values: Sequence[float]) -> list[str]:
    """Numbers as decimals, rounded to as few digits (three at least) as tell different ones apart."""
    texts: list[str] = []
    distinct = len(set(values))
    for digits in SIGNIFICANT:
        texts = [_positional(float(f"{value:.{digits}g}")) for value in values]
        if len(set(texts)) == distinct:
            break
    return texts


def _positional(value: float) -> str:
    if value == 0 or POSITIONAL[0] <= abs(value) < POSITIONAL[1]:
        return np.format_float_positional(value, trim="-")
    return number(value, 6)


def symbol(column: str) -> str:
    """Mathtext of a column's name: x1 becomes $x_1$, a block's name an upright index."""
    index = column[1:].lstrip("_")
    if index.isdigit():
        return f"${column[0]}_{{{index}}}$"
    return rf"${column[0]}_\mathrm{{{index.replace('_', chr(92) + '_')}}}$"


def seconds(span: tuple[float, float]) -> str:
    """A span of time in words, such as `290–300 s`."""
    return f"{span[0]:.6g}–{span[1]:.6g} s"
