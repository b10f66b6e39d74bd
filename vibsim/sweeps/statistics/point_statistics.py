"""The statistics of one point, taken block by block from its run; no trajectory is kept.

Everything is taken from the time `begin` on. A period is one of the excitation, from one stroboscopic point
to the next; only whole periods count. Where there is none (no source, a motor that stands), what is meant
per period is NaN, and amplitudes are half the peak-to-peak of the whole time. Extremes are the engine's, see
`vibsim.engine.extremes`.
"""

import math

import numpy as np

from vibsim.engine.columns import part_columns, section_columns, stop_column
from vibsim.engine.trajectories.blocks import Block
from vibsim.physics.arithmetic.sums import dot, mean
from vibsim.physics.modes import EVENT_KINDS, IMPACTS
from vibsim.physics.parts import Scene
from vibsim.sweeps.statistics.measured_run import MeasuredRun
from vibsim.sweeps.statistics.motions import displacements, velocities
from vibsim.sweeps.statistics.quantities import Quantities

TURN = 2 * math.pi
COUNTED = {"impacts_per_period": IMPACTS, "sticks_per_period": ("stick_begin",)}  # by kinds of events


class Statistics:
    """Running statistics of one run. Memory grows with its periods and impacts, not with its length."""

    def __init__(self, scene: Scene, of: Quantities, begin: float):
        self.scene, self.of, self.begin = scene, of, begin
        self._points: list[dict[str, np.ndarray]] = []
        self._extremes: list[np.ndarray] = []
        self._begun: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {name: [] for name in COUNTED}

    def update(self, block: Block) -> None:
        """Take the next block of a `MeasuredRun`."""
        late = block.section["time"] >= self.begin
        self._points.append({name: column[late] for name, column in block.section.items()})
        self._extremes.append(block.extremes[:, late])
        for name, begun in self._begun.items():
            of_kind = np.isin(block.events["kind"], [EVENT_KINDS[kind] for kind in COUNTED[name]])
            begun.append((block.events["t"][of_kind], block.events["part"][of_kind]))

    def values(self, run: MeasuredRun) -> dict[str, float]:
        """The statistics by name, see `columns`; empty where the run ended before `begin`."""
        if not run.late:
            return {}
        points = self.points()
        periods = max(len(points["time"]) - 1, 0)
        if not periods:
            points = run.ends()
        return {
            **self._amplitudes(run, periods),
            **self._per_period(points["time"], periods),
            **self._drift(points),
            **self._speeds(points, run),
        }

    def window(self, run: MeasuredRun) -> tuple[float, float]:
        """Begin and end of the whole periods [s]; of everything that was taken where there is none."""
        times = self.points()["time"]
        return (float(times[0]), float(times[-1])) if len(times) > 1 else (self.begin, run.t_reached)

    def points(self) -> dict[str, np.ndarray]:
        """The stroboscopic points: time and states by name, each (n)."""
        return {
            name: np.concatenate([[], *(part[name] for part in self._points)])
            for name in section_columns(self.scene)
        }

    def section(self, count: int) -> dict[str, np.ndarray]:
        """The last `count` stroboscopic points, NaN in front where there are fewer.

        By column: displacements [m] and velocities [m/s], motor speed [Hz].
        """
        points = {name: column[max(len(column) - count, 0) :] for name, column in self.points().items()}
        values = {
            name: (velocities if is_rate else displacements)(self.scene, (motion,), points)[0]
            for name, (motion, is_rate) in self.of.sections.items()
        }
        if self.scene.has_motor:
            values["section_speed"] = points["phidot"] / TURN
        return {
            name: np.concatenate([np.full(count - len(column), np.nan), column])
            for name, column in values.items()
        }

    def _amplitudes(self, run: MeasuredRun, periods: int) -> dict[str, float]:
        least, greatest, _ = run.extremes
        rows = (
            np.concatenate(self._extremes, axis=1)[:, 1:]
            if periods
            else np.array([*least, *greatest])[:, None]
        )
        low, high = np.split(rows, 2)  # of every whole period; without one of everything
        amplitudes = {}
        for i, motion in enumerate(self.of.motions):
            half = (high[i] - low[i]) / 2
            amplitudes[f"amplitude_{motion.name}"] = float(mean(half))
            amplitudes[f"amplitude_{motion.name}_max"] = float(half.max())
        for name, motion in self.of.ranged.items():
            i = self.of.motions.index(motion)
            amplitudes[f"{name}_min"], amplitudes[f"{name}_max"] = float(least[i]), float(greatest[i])
        return amplitudes

    def _per_period(self, times: np.ndarray, periods: int) -> dict[str, float]:
        """Events in the whole periods, divided by their number."""
        per_period: dict[str, float] = {"periods": float(periods)}
        parts = {"impacts_per_period": self.of.stops, "sticks_per_period": self.of.frictions}
        for name, begun in self._begun.items():
            happened, part = (np.concatenate([[], *column]) for column in zip(*begun, strict=True))
            counted = (happened >= times[0]) & (happened < times[-1])
            per_period[name] = np.count_nonzero(counted) / periods if periods else math.nan
            for one in parts[name]:
                count = np.count_nonzero(counted & (part == self._number(one)))
                per_period[f"{name}_{one}"] = count / periods if periods else math.nan
        return per_period

    def _number(self, part: str) -> int | None:
        """Number of a part among those of the events table; None where it is not in the scene: mu = 0."""
        columns = part_columns(self.scene)
        name = stop_column(part) if part in self.of.stops else part
        return columns.index(name) if name in columns else None

    def _drift(self, points: dict[str, np.ndarray]) -> dict[str, float]:
        """Slopes of the lines of least squares through displacements at the stroboscopic points [m/s]."""
        t = points["time"] - mean(points["time"])
        square = float(dot(t, t))
        drifts = {}
        for name, motion in self.of.drifting.items():
            x = displacements(self.scene, (motion,), points)[0]
            x = x - x[0]
            drifts[name] = float(dot(t, x - mean(x))) / square if square else math.nan
        return drifts

    def _speeds(self, points: dict[str, np.ndarray], run: MeasuredRun) -> dict[str, float]:
        """Mean speed over the whole periods, extremes over everything [Hz]."""
        if not self.scene.has_motor:
            return {}
        span = points["time"][-1] - points["time"][0]
        mean = (points["phi"][-1] - points["phi"][0]) / TURN / span if span else math.nan
        least, greatest, _ = run.extremes
        return {
            "mean_speed": float(mean),
            "min_speed": least[-1] / TURN,
            "max_speed": greatest[-1] / TURN,
        }
