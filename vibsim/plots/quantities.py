"""Axis labels and SI prefixes."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

# Prefix per power of 1000; displacements beyond a kilometre and below a nanometre keep the last one.
_PREFIXES = {1: "k", 0: "", -1: "m", -2: "µ", -3: "n"}


@dataclass(frozen=True)
class Scale:
    """A unit that suits the values: value in SI x factor = value in `unit`."""

    factor: float
    unit: str

    def __call__(self, values):
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
    power = min(max(math.floor(math.log10(largest) / 3 + 1e-12), -3), 1)
    return Scale(1000.0 ** (-power), _PREFIXES[power] + unit)


def seconds(span: tuple[float, float]) -> str:
    """A span of time in words, such as `290–300 s`."""
    return f"{span[0]:.6g}–{span[1]:.6g} s"
