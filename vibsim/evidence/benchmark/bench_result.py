"""A bench as users meet it: rows, truth, and columns by name."""

import json
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.cases import Case
from vibsim.evidence.benchmark.bench_file import read_rows, read_truth
from vibsim.evidence.benchmark.bench_structure import ATTRIBUTES, datasets_of, lengths_of
from vibsim.evidence.benchmark.row import Row
from vibsim.evidence.benchmark.scoring import faithful_error
from vibsim.evidence.benchmark.truth import Truth
from vibsim.files.checking import damaged
from vibsim.files.reading import opened, read_attributes, read_datasets
from vibsim.files.stored_case import stored_case

TRUSTED = 1e-6  # m: an error beyond this is the chaos of the case rather than the work of the method


class BenchResult:
    """A bench, in memory or from a file.

    `bench.rows` are its rows, `bench["wall_time"]` one number of them all (n), `bench["error"]` their errors
    at the instants `bench["time"]` (n, instants). `bench.attrs` says where it comes from.
    """

    def __init__(self, attrs: dict[str, Any], truth: Truth, rows: list[Row]):
        self.attrs, self.truth, self.rows = attrs, truth, rows

    def __getitem__(self, name: str) -> np.ndarray:
        if name == "time":
            return self.truth.samples["time"]
        if name not in Row.__dataclass_fields__ or name == "events":
            raise KeyError(f"no {name}; a bench has time, {', '.join(self.keys())}")
        return np.array([getattr(row, name) for row in self.rows])

    def keys(self) -> list[str]:
        """Names of what is known per row."""
        return [name for name in Row.__dataclass_fields__ if name != "events"]

    @cached_property
    def case(self) -> Case:
        """The case that was run, its run settings those of the bench."""
        case = Case.from_resolved_json(self.attrs["case_resolved_json"])
        return replace(case, text=self.attrs["case_yaml"])

    @property
    def complete(self) -> bool:
        """Whether every row was run."""
        return bool(self.attrs["complete"])

    @property
    def check_times(self) -> list[float]:
        """The instants at which errors are told [s]."""
        return [float(t) for t in np.atleast_1d(self.attrs["check_times_s"])]

    @cached_property
    def faithful_error(self) -> float:
        """The largest error of a faithful run [m]."""
        return faithful_error(self.truth, self.case.scene())

    @cached_property
    def telling_time(self) -> float:
        """The latest instant [s] to compare errors at: where some row is still right to 1e-6 m, else the
        first.
        """
        right = [
            t
            for t in self.check_times
            if any(row.error_until(self["time"], t) <= TRUSTED for row in self.rows)
        ]
        return max(right, default=self.check_times[0])

    def __repr__(self) -> str:
        span = f"{self['time'][-1]:g} s"
        return f"<BenchResult {self.case.name}: {len(self.rows)} rows, {span}; {', '.join(self.keys())}>"


def open_bench(path: str | Path) -> BenchResult:
    """The BenchResult in an HDF5 file. Raises ResultFileError where it holds none."""
    path = Path(path)
    with opened(path, "bench") as file:
        attrs = read_attributes(path, file, ATTRIBUTES)
        check_lists(path, attrs)
        scene = stored_case(path, attrs).scene()
        values = read_datasets(path, file, datasets_of(scene), lengths_of(scene))
    return BenchResult(attrs, read_truth(values, attrs), read_rows(values, scene))


def check_lists(path: Path, attrs: dict[str, Any]) -> None:
    """Raise ResultFileError unless lists of names are such, and there is an instant to compare at."""
    for name in ("methods", "not_installed"):
        try:
            names = json.loads(attrs[name])
        except (ValueError, RecursionError):
            names = None
        if not isinstance(names, list) or not all(isinstance(each, str) for each in names):
            raise damaged(path, f"the attribute {name} is not a list of names")
    if not len(attrs["check_times_s"]):
        raise damaged(path, "the attribute check_times_s is empty")
