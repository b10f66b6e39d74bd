"""A curve of periodic orbits, a branch or a locus: points along it, and arrays by name."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.orbits.branches.file_structure import POINT, columns_of, curve_origin, scale_values
from vibsim.orbits.branches.plan import CurvePlan
from vibsim.orbits.coordinates import Word, spelled
from vibsim.results.file_contents import Dataset
from vibsim.results.hdf5_writing import write_hdf5
from vibsim.results.labelled import Arrays, Labelled
from vibsim.results.output_files import check_result_output


class Curve(Labelled):
    """Points along a curve, those backwards from its start first; a class of it says what it is.

    plan : what was followed
    attrs : of its file
    """

    noun: str
    _record: type  # of a point
    _shown: tuple[str, ...]  # arrays that a table shows first
    plan: Any
    points: list[Any]

    def _place(self, plan: CurvePlan, points: Sequence[Any], attrs: Mapping[str, Any] | None) -> None:
        """Put points in their order along the curve; where it is stuck its last point comes again."""
        self.plan, self.attrs = plan, dict(attrs or {})
        last = {(point.way, point.number): point for point in points}
        back = sorted((p for p in last.values() if p.way < 0), key=lambda p: -p.number)
        self.points = [*back, *sorted((p for p in last.values() if p.way > 0), key=lambda p: p.number)]

    @property
    def _arrays(self) -> Mapping[str, np.ndarray]:
        raise NotImplementedError

    @property
    def _scene(self) -> Any:
        """By which events are spelled."""
        raise NotImplementedError

    def _declared(self) -> list[Dataset]:
        """The datasets of its file."""
        raise NotImplementedError

    def _counts(self) -> dict[str, int]:
        """Attributes of its file that count what there is."""
        return {"points": len(self.points)}

    def _file_attributes(self, complete: bool) -> dict[str, Any]:
        """Attributes of its file that are known at the end."""
        return {**self._counts(), "complete": int(complete)}

    @property
    def _followed(self) -> bool:
        """Whether it was followed to its ends."""
        raise NotImplementedError

    def __len__(self) -> int:
        return len(self.points)

    def keys(self) -> list[str]:
        """Names of the arrays along it."""
        return [*self._arrays]

    def __getitem__(self, name: str) -> np.ndarray:
        """An array along it, first axis the points. Raises KeyError with the names that there are."""
        if name not in self._arrays:
            raise KeyError(f"{name} is not in this {self.noun}; it has {', '.join(self._arrays)}")
        return self._arrays[name]

    @property
    def case(self) -> Any:
        return self.plan.case

    def spelled(self, word: Word) -> str:
        """A word in letters."""
        return spelled(self._scene, word)

    @cached_property
    def _orbit_arrays(self) -> dict[str, np.ndarray]:
        """What is known of the orbit of every point."""
        names = ["parameter", "period", "state", "multipliers", "fold", "doubling", "margin", "residual"]
        return {name: np.array([getattr(p.orbit, name) for p in self.points]) for name in (*names, "drift")}

    def _file_values(self) -> dict[str, Any]:
        """What stands in the datasets of its file, by name."""
        columns = columns_of(self._record, self.points, self.spelled)
        return {POINT: np.arange(len(self)), **scale_values(self.points[0]), **columns}

    def arrays(self) -> Arrays:
        """What its file holds, by point, special point and multiplier."""
        return Arrays.of_values(self._declared(), self._file_values(), (POINT,), self.attrs, self._shown)

    def save(self, path: str | PathLike[str], force: bool = False) -> Path:
        """Write it to an HDF5 file, which every command takes; its absolute path.

        force : replace what is there. Raises ResultFileError where it cannot be written.

        `continue_branch(..., out=path)` and `continue_locus` go on with it where it did not come to its ends.
        """
        target = check_result_output(Path(path), force)
        write_curve(target, self, self.attrs or curve_origin(self.plan), self._followed)
        return target


def write_curve(path: Path, curve: Curve, attrs: Mapping[str, Any], complete: bool) -> None:
    """Write a curve to `path`, replacing what is there in one instant. Raises ResultFileError."""
    known = {**attrs, **curve._file_attributes(complete)}
    write_hdf5(path, known, curve._declared(), curve._file_values())


def counts_of(curve: Curve) -> dict[str, int]:
    """Attributes of the file of a curve that count what there is."""
    return curve._counts()
