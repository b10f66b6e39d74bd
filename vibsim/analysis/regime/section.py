"""The stroboscopic section of a run: its exact state at the end of every cycle, made comparable.

The drift of the blocks is left out: a point is (y, u, v2, w) with y = x1 - x2 and u = v1 - v2, as far as the
scene has them. Lengths are divided by the amplitude of y in the span, speeds of blocks by that of u, the
speed of the rotor by its mean; so a distance of 1e-3 between points is a thousandth of the vibration.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vibsim.analysis.cycles import ROWS, TURN, cycle_ends
from vibsim.analysis.event_rows import events_within
from vibsim.analysis.span import Span
from vibsim.physics.sums import mean
from vibsim.results.restart import states_at
from vibsim.results.result import Result
from vibsim.results.windows import pieces, rows_within

MOST = 5000  # points, the last ones of the span
NEWTON_STEPS = 2  # from an error of 1e-4 rad, which the line between two samples leaves


@dataclass(frozen=True)
class Section:
    """Points (n, d) at ascending `times` [s], without unit."""

    times: np.ndarray
    points: np.ndarray

    def __len__(self) -> int:
        return len(self.times)


def section_of(result: Result, span: Span) -> Section:
    """The section of a run within the span; empty without a source."""
    times = cycle_ends(result, span.window)[-MOST:]
    if not len(times):
        return Section(times, np.empty((0, 0)))
    times, states = _turned(result, span, times)
    return Section(times, scaled(states, *amplitudes(result, span)))


def scaled(states: Mapping[str, np.ndarray], length: float, speed: float) -> np.ndarray:
    """Points (n, d) of the states by name, each (n), at the amplitudes of y [m] and u [m/s]."""
    columns = [relative(states, "x") / (length or 1.0), relative(states, "v") / (speed or 1.0)]
    columns += [states["v2"] / (speed or 1.0)] if "v2" in states else []
    columns += [states["phidot"] / (mean(states["phidot"]) or 1.0)] if "phidot" in states else []
    return np.stack(columns, axis=1)


def amplitudes(result: Result, span: Span) -> tuple[float, float]:
    """Half the peak-to-peak of x1 - x2 [m] and of v1 - v2 [m/s] among the samples of the span."""
    rows = rows_within(result.column("time"), span.window)
    names = [name for name in ("x1", "v1", "x2", "v2") if name in result]
    extremes = []
    for piece in pieces(rows, ROWS):
        samples = {name: np.asarray(result.column(name)[piece]) for name in names}
        y, u = relative(samples, "x"), relative(samples, "v")
        extremes.append((y.min(), y.max(), u.min(), u.max()))
    if not extremes:
        return 0.0, 0.0
    low_y, high_y, low_u, high_u = np.array(extremes).T
    return float(high_y.max() - low_y.min()) / 2, float(high_u.max() - low_u.min()) / 2


def relative(columns: Mapping[str, np.ndarray], kind: str) -> np.ndarray:
    """y ("x") or u ("v"); a fixed block 2 stands still."""
    first, second = columns[f"{kind}1"], columns.get(f"{kind}2")
    return first if second is None else first - second


def _turned(result: Result, span: Span, times: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Exact ends of the cycles and the states there."""
    scene = result.case.scene()
    window = float(times[0]) - 1.0, float(times[-1]) + 1.0
    events = events_within(result, window, before=1)
    states = states_at(scene, events, times, result.t_reached)
    for _ in range(NEWTON_STEPS if scene.has_motor else 0):
        apart = states["phi"] - TURN * np.round(states["phi"] / TURN)
        step = np.divide(apart, states["phidot"], out=np.zeros_like(apart), where=states["phidot"] > 0)
        times = np.clip(times - step, span.begin, span.end)
        states = states_at(scene, events, times, result.t_reached)
    return times, states
