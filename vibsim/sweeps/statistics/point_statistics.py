"""The statistics of one point, taken block by block from its run; no trajectory is kept.

Everything is taken from the time `begin` on. A period is one of the excitation, from one stroboscopic point
to the next; only whole periods count. Where there is none (no source, a motor that stands), what is meant
per period is NaN, and amplitudes are half the peak-to-peak of the whole time.
"""

import math
from typing import Any

import numpy as np

from vibsim.engine.trajectory import Block
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.sums import dot, mean
from vibsim.physics.two_blocks import TwoBlocks
from vibsim.sweeps.statistics.extremes import displacement_extremes, displacements, rates, speed_extremes
from vibsim.sweeps.statistics.periods import PeriodExtremes
from vibsim.sweeps.statistics.rows import Merger, Rows

TURN = 2 * math.pi


class Statistics:
    """Running statistics of one run. Memory grows with its periods and impacts, not with its samples."""

    def __init__(self, scene: TwoBlocks, begin: float):
        self.scene, self.begin = scene, begin
        self._merger = Merger(scene)
        self._rows: Rows | None = None  # the last row so far
        self._first: dict[str, float] | None = None  # the first row's states
        self._extremes = PeriodExtremes(3 if scene.has_block2 else 1)
        self._speed = (math.inf, -math.inf)
        self._points: list[dict[str, np.ndarray]] = []
        self._begun: dict[str, list[np.ndarray]] = {"contact_begin": [], "stick_begin": []}

    def update(self, block: Block) -> None:
        """Take the next block of the run, computed with `section=True`."""
        rows = self._merger.merge(block).since(self.begin)
        if not len(rows):
            return
        self._points.append({name: column[rows.section] for name, column in rows.states.items()})
        for kind, times in self._begun.items():
            times.append(block.events["t"][block.events["kind"] == EVENT_KINDS[kind]])
        if self._rows is not None:
            rows = self._rows.followed_by(rows)
        else:
            self._first = {name: float(column[0]) for name, column in rows.states.items()}
        self._gather_extremes(rows)
        self._rows = rows.last()

    def _gather_extremes(self, rows: Rows) -> None:
        self._extremes.add(*displacement_extremes(self.scene, rows), rows.section)
        if self.scene.has_motor:
            low, high = speed_extremes(self.scene, rows)
            self._speed = min(low, self._speed[0]), max(high, self._speed[1])

    def values(self) -> dict[str, float]:
        """The statistics by name, see `columns`; empty where the run ended before `begin`."""
        if self._rows is None or self._first is None:
            return {}
        points, last = self.points(), {name: column[0] for name, column in self._rows.states.items()}
        if len(points["time"]) < 2:
            points = {name: np.array([self._first[name], last[name]]) for name in last}
            periods = 0
        else:
            periods = len(points["time"]) - 1
        return {
            **self._amplitudes(),
            **self._per_period(points["time"], periods),
            **self._drift(points),
            **self._speeds(points),
        }

    @property
    def window(self) -> tuple[float, float]:
        """Begin and end of the whole periods [s]; of everything that was taken where there is none."""
        times = self.points()["time"]
        if len(times) < 2 and self._rows is not None and self._first is not None:
            return self._first["time"], float(self._rows.states["time"][0])
        return (float(times[0]), float(times[-1])) if len(times) else (math.nan, math.nan)

    def points(self) -> dict[str, np.ndarray]:
        """The stroboscopic points: time and states by name, each (n)."""
        return {
            name: np.concatenate([[], *(part[name] for part in self._points)]) for name in self._merger.names
        }

    def section(self, count: int) -> dict[str, np.ndarray]:
        """The last `count` stroboscopic points, NaN in front where there are fewer.

        Relative displacement [m] and velocity [m/s], motor speed [Hz].
        """
        points = {name: column[max(len(column) - count, 0) :] for name, column in self.points().items()}
        found = {
            "displacement": displacements(self.scene, points)[-1],
            "velocity": rates(self.scene, points)[-1],
        }
        if self.scene.has_motor:
            found["speed"] = points["phidot"] / TURN
        return {
            name: np.concatenate([np.full(count - len(column), np.nan), column])
            for name, column in found.items()
        }

    def _amplitudes(self) -> dict[str, float]:
        names = ("x1", "x2", "relative") if self.scene.has_block2 else ("x1",)
        half = self._extremes.peak_to_peak() / 2
        found = {f"amplitude_{name}": float(row) for name, row in zip(names, mean(half), strict=True)}
        found |= {f"amplitude_{name}_max": float(row.max()) for name, row in zip(names, half, strict=True)}
        return found | {
            "relative_min": float(self._extremes.low[-1]),
            "relative_max": float(self._extremes.high[-1]),
        }

    def _per_period(self, times: np.ndarray, periods: int) -> dict[str, float]:
        """Events in the whole periods, divided by their number."""
        found: dict[str, Any] = {"periods": float(periods)}
        for kind, name in (("contact_begin", "impacts_per_period"), ("stick_begin", "sticks_per_period")):
            happened = np.concatenate([[], *self._begun[kind]])
            count = np.count_nonzero((happened >= times[0]) & (happened < times[-1]))
            found[name] = count / periods if periods else math.nan
        return found

    def _drift(self, points: dict[str, np.ndarray]) -> dict[str, float]:
        """Slope of the line of least squares through x2 at the stroboscopic points [m/s]."""
        if not self.scene.has_block2:
            return {}
        t = points["time"] - mean(points["time"])
        square = float(dot(t, t))
        x = points["x2"] - points["x2"][0]
        return {"drift_rate": float(dot(t, x - mean(x))) / square if square else math.nan}

    def _speeds(self, points: dict[str, np.ndarray]) -> dict[str, float]:
        """Mean speed over the whole periods, extremes over everything [Hz]."""
        if not self.scene.has_motor:
            return {}
        span = points["time"][-1] - points["time"][0]
        mean = (points["phi"][-1] - points["phi"][0]) / TURN / span if span else math.nan
        return {
            "mean_speed": float(mean),
            "min_speed": self._speed[0] / TURN,
            "max_speed": self._speed[1] / TURN,
        }
