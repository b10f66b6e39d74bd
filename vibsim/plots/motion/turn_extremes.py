"""Least and greatest displacement in every turn of the motor, and its mean speed in that turn."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from vibsim.plots.motion.dense import dense, samples_are_sparse
from vibsim.plots.motion.samples import blocks
from vibsim.plots.motion.spans import PERIODS_AT_MOST
from vibsim.plots.motion.turns import turn_times
from vibsim.plots.view import Span

PER_TURN = 16  # instants evaluated in a turn where the samples are too few


@dataclass(frozen=True)
class TurnExtremes:
    """One value per turn of the motor (n).

    Attributes
    ----------
    t : middle of the turn [s]
    hertz : mean speed in it [Hz]
    least, greatest : of the displacement, among samples [m]
    """

    t: np.ndarray
    hertz: np.ndarray
    least: np.ndarray
    greatest: np.ndarray


def turn_extremes(result: Any, column: str, span: Span) -> TurnExtremes:
    """The extremes of `column` in each whole turn within the span that has samples."""
    times = turn_times(result, span)
    count = max(len(times) - 1, 0)
    least, greatest = np.full(count, np.inf), np.full(count, -np.inf)
    for block in _stretches(result, column, span, count):
        turn = np.searchsorted(times, block["time"], side="right") - 1
        inside = (turn >= 0) & (turn < count)
        np.minimum.at(least, turn[inside], block[column][inside])
        np.maximum.at(greatest, turn[inside], block[column][inside])
    turning = np.isfinite(least)
    middle, hertz = (times[:-1] + times[1:]) / 2, 1 / np.diff(times)
    return TurnExtremes(middle[turning], hertz[turning], least[turning], greatest[turning])


def _stretches(result: Any, column: str, span: Span, turns: int) -> Iterator[dict[str, np.ndarray]]:
    """The samples block by block; where they are sparse and the turns not too many, instants between."""
    if samples_are_sparse(result.case.scene()) and 0 < turns <= PERIODS_AT_MOST:
        yield dense(result, (column,), span, step=(span[1] - span[0]) / (turns * PER_TURN))
    else:
        yield from blocks(result, ("time", column), span)
