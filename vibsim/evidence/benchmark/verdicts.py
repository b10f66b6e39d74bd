"""What a bench says: who is fastest, who most accurate, and what the peers take beside vibsim."""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from vibsim.evidence.benchmark.bench_result import BenchResult
from vibsim.evidence.benchmark.families import family_of
from vibsim.evidence.benchmark.row import DONE, Row
from vibsim.physics.modes import EVENT_KINDS, IMPACTS

FLOOR = 2.0**-60  # m: smaller errors are rounding of the truth, 1e-18 m beside displacements of centimetres


@dataclass(frozen=True)
class Beside:
    """A row beside that of vibsim: ratios of processor times and of errors, theirs to vibsim's."""

    row: Row
    times: float
    errors: float


def error_at(bench: BenchResult, row: Row) -> float:
    """Error of a row [m] until the telling time, at least FLOOR; NaN where it did not come so far."""
    error = row.error_until(bench["time"], bench.telling_time)
    return max(error, FLOOR) if isfinite(error) else error


def fastest(bench: BenchResult) -> Row | None:
    """The row that took the least time of those that are faithful until the telling time."""
    done = [row for row in bench.rows if row.status == DONE and error_at(bench, row) <= bench.faithful_error]
    return min(done, key=lambda row: row.time_per_second, default=None)


def most_accurate(bench: BenchResult, method: str | None = None) -> Row | None:
    """The row with the least error until the telling time, of one family or of all."""
    judged = [row for row in bench.rows if method in (None, row.method) and isfinite(error_at(bench, row))]
    return min(judged, key=lambda row: error_at(bench, row), default=None)


def reference(bench: BenchResult) -> Row | None:
    """The row of vibsim as it runs by default: the last of its first family, in C or else in Python."""
    own = [row for row in bench.rows if family_of(row.method).own and row.status == DONE]
    first = [row for row in own if row.method == own[0].method]
    return first[-1] if first else None


def beside_reference(bench: BenchResult) -> list[Beside]:
    """The most accurate row of every peer beside vibsim's own."""
    ours = reference(bench)
    peers = [name for name in dict.fromkeys(row.method for row in bench.rows) if not family_of(name).own]
    best = [most_accurate(bench, name) for name in peers]
    if ours is None:
        return []
    return [
        Beside(row, row.time_per_second / ours.time_per_second, error_at(bench, row) / error_at(bench, ours))
        for row in best
        if row is not None
    ]


def impacts_per_second(bench: BenchResult, row: Row) -> float | None:
    """True impacts until the time that a row reached, per second of processor time; None without any."""
    codes = [EVENT_KINDS[name] for name in IMPACTS]
    impacts = np.isin(bench.truth.events["kind"], codes) & (bench.truth.events["t"] <= row.t_reached)
    count = np.count_nonzero(impacts)
    return count / row.cpu_time if count and row.cpu_time > 0 else None


def faster(bench: BenchResult, row: Row) -> float | None:
    """How many times as long as vibsim a row takes, at an error that vibsim does not exceed.

    Beside it stands the fastest row of vibsim's own that is at least as accurate; None where there is none.
    """
    own = [each for each in bench.rows if family_of(each.method).own and each.status == DONE]
    accurate = [each.time_per_second for each in own if error_at(bench, each) <= error_at(bench, row)]
    return row.time_per_second / min(accurate) if accurate else None
