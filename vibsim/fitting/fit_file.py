"""A fit as an HDF5 file: what was measured over candidates, statements and starts, and what came of it."""

from __future__ import annotations

import json
import platform
from collections.abc import Sequence
from datetime import datetime, timezone
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from vibsim import __version__
from vibsim.engine.choice import engine_name
from vibsim.fitting.free_parameter import FreeParameter
from vibsim.fitting.plan import FitPlan
from vibsim.fitting.reading import Candidate
from vibsim.results.hdf5_image import write_hdf5
from vibsim.results.provenance import FORMAT
from vibsim.sweeps.statistics.columns import MISSING, STATUS_FLAGS
from vibsim.sweeps.store.sweep_file import COMPRESSED

if TYPE_CHECKING:
    from vibsim.fitting.fit_result import FitResult

TEXT = h5py.string_dtype()
DEFINITIONS = (
    "A shortfall is 0 where a value lies in the range that a statement asks for and grows in proportion to "
    "the distance from it, up to 1 at one width of the range (of an open range: the magnitude of its end); a "
    "verdict has 0 or 1. The price is the mean shortfall over statements (by weight) and starts, and what "
    "leaving the printed values costs. Start 0 is that of the case, the last n_fresh are not seen by "
    "the search."
)


def origin(plan: FitPlan, engine: str) -> dict[str, Any]:
    """Attributes that are known before the first run."""
    case = plan.cases[0]
    names = " and ".join(each.name for each in plan.cases)
    return {
        "Conventions": "CF-1.8",
        "title": f"Fit of {names}",
        "vibsim_format": FORMAT,
        "vibsim_kind": "fit",
        "vibsim_version": __version__,
        "case_name": case.name,
        "case_yaml": case.text,
        "case_resolved_json": case.resolved_json(),
        "case_sha256": case.sha256,
        "cases_resolved_json": json.dumps([each.resolved_json() for each in plan.cases]),
        "fit_settings_json": json.dumps(plan.settings),
        "fit_sha256": plan.fingerprint,
        "n_fresh": len(plan.fresh_starts),
        "definitions": DEFINITIONS,
        "engine": engine_name(engine),
        "date_created": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "platform": f"{platform.system()} {platform.release()} {platform.machine()}",
        "python_version": platform.python_version(),
        "numpy_version": np.__version__,
    }


def write_fit(path: Path, fit: FitResult) -> None:
    """Write a fit to `path`, replacing what is there in one instant. Raises ResultFileError."""

    def fill(file: h5py.File) -> None:
        for name, value in fit.attrs.items():
            file.attrs[name] = value
        _Writer(file, fit).write()

    write_hdf5(path, fill)


class _Writer:
    """Writes the datasets of a fit into an open file."""

    def __init__(self, file: h5py.File, fit: FitResult):
        self.file, self.fit, self.plan = file, fit, fit.plan
        counts = {
            "candidate": len(fit.candidates),
            "case": len(fit.plan.cases),
            "statement": len(fit.statements),
            "start": fit.plan.all_starts,
        }
        self.scales = {name: self._scale(name, count) for name, count in counts.items()}

    def write(self) -> None:
        """All datasets."""
        fit, made = self.fit, self.fit.candidates
        self._put("case_name", [case.name for case in self.plan.cases], ("case",), "name of the case")
        self._put("statement_text", [each.text for each in fit.statements], ("statement",), "as given")
        self._put(
            "statement_case", [each.case for each in fit.statements], ("statement",), "position of its case"
        )
        self._put(
            "changes", [json.dumps(one.changes) for one in made], ("candidate",), "values changed, as JSON"
        )
        self._put("origin", [one.origin for one in made], ("candidate",), "where the candidate comes from")
        self._put(
            "leaving", [one.leaving for one in made], ("candidate",), "price of leaving the printed values"
        )
        for free in self.plan.free:
            numbers = [number_of(one, free) for one in made]
            self._put(
                f"value_{free.name}", numbers, ("candidate",), f"{free.key}, as printed where NaN", free.unit
            )
        self._write_runs()
        self._write_judged()

    def _write_runs(self) -> None:
        fit, plan = self.fit, self.plan
        index = [
            [
                [(one.number, case, start) for start in range(plan.all_starts)]
                for case in range(len(plan.cases))
            ]
            for one in fit.candidates
        ]
        runs = [[[fit.runs.get(each) for each in row] for row in block] for block in index]
        dims = ("candidate", "case", "start")
        status = [[[MISSING if p is None else p.status for p in row] for row in block] for block in runs]
        self._put("status", np.array(status, "i1").reshape(self._shape(dims)), dims, "whether it was run")
        self.file["status"].attrs["flag_values"] = np.array(list(STATUS_FLAGS.values()), "i1")
        self.file["status"].attrs["flag_meanings"] = " ".join(STATUS_FLAGS)
        for name, meaning in (("sha256", "SHA-256 of the case of a run"), ("error", "why a run failed")):
            texts = [
                [["" if p is None else getattr(p, name) for p in row] for row in block] for block in runs
            ]
            self._put(name, np.array(texts, object).reshape(self._shape(dims)), dims, meaning)
        values = [[fit.values(each, one) for each in fit.statements] for one in fit.candidates]
        self._put(
            "value", values, ("candidate", "statement", "start"), "what was measured, in SI units and Hz"
        )
        horizons = [[fit.horizon(one, case) for case in range(len(plan.cases))] for one in fit.candidates]
        self._put(
            "trust_horizon", horizons, ("candidate", "case"), "of the run from the case's own start", "s"
        )

    def _write_judged(self) -> None:
        fit = self.fit
        judged = {each.candidate.number: each for each in fit.ranking}
        rows = [judged.get(one.number) for one in fit.candidates]
        price = [np.nan if row is None else row.price for row in rows]
        self._put("price", price, ("candidate",), "see the attribute `definitions`")
        self._put(
            "rank", _ranks(fit), ("candidate",), "place in the ranking, from 1; 0: not judged from all starts"
        )
        for name, meaning in (("share", "share of the starts from which it holds"), ("shortfall", "mean")):
            table = [
                [np.nan] * len(fit.statements) if row is None else [getattr(each, name) for each in row.found]
                for row in rows
            ]
            self._put(name, table, ("candidate", "statement"), meaning)

    def _shape(self, dims: Sequence[str]) -> tuple[int, ...]:
        return tuple(len(self.scales[name]) for name in dims)

    def _scale(self, name: str, count: int) -> h5py.Dataset:
        scale = self.file.create_dataset(name, data=np.arange(count, dtype="i4"))
        scale.attrs["long_name"] = f"number of the {name}"
        scale.attrs["units"] = "1"
        scale.make_scale(name)
        return scale

    def _put(self, name: str, data: Any, dims: Sequence[str], long_name: str, unit: str = "1") -> None:
        array = np.asarray(data)
        texts = array.dtype.kind in "UO"
        shaped = (array.astype(object) if texts else array).reshape(self._shape(dims))
        options = {"dtype": TEXT} if texts else COMPRESSED if shaped.size else {}
        dataset = self.file.create_dataset(name, data=shaped, **options)
        dataset.attrs["long_name"] = long_name
        if not texts:
            dataset.attrs["units"] = unit or "1"
        for dimension, dim in zip(dataset.dims, dims, strict=True):
            dimension.attach_scale(self.scales[dim])


def _ranks(fit: FitResult) -> list[int]:
    ranks = {each.candidate.number: rank for rank, each in enumerate(fit.ranking, start=1)}
    return [ranks.get(one.number, 0) for one in fit.candidates]


def number_of(candidate: Candidate, free: FreeParameter) -> float:
    """The value of a free parameter in its unit; NaN where the candidate leaves it as printed."""
    from vibsim.cases.quantities import parse_quantity
    from vibsim.cases.units import UNITS

    text = candidate.changes.get(free.key)
    if text is None:
        return np.nan
    found = parse_quantity(text, UNITS[free.unit].dimension)
    return float(found.value / UNITS[free.unit].factor)
