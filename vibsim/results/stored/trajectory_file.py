"""A trajectory file opened for reading: checked once, its columns read when they are asked for."""

from collections.abc import Iterable, Iterator, Mapping
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from vibsim.files.attributes import read_attrs
from vibsim.files.checking import check_datasets, check_values, checked_attributes
from vibsim.files.declarations import Dataset
from vibsim.files.reading import damage_named, open_hdf5
from vibsim.physics.parts import Scene
from vibsim.results.columns import Tables, tables_of
from vibsim.results.digits import Digits
from vibsim.results.stored.older_files import CompletedEvents, older_tables
from vibsim.results.stored.orbit_structure import GROUP, orbit_datasets
from vibsim.results.stored.trajectory_structure import (
    ATTRIBUTES,
    digit_datasets,
    event_datasets,
    sample_datasets,
)
from vibsim.results.trust.trust import COLUMN as ERROR_ESTIMATE

if TYPE_CHECKING:
    from vibsim.cases import Case


class TrajectoryFile:
    """An HDF5 file of one trajectory.

    tables : the columns of a file that this process has just written, which is not checked again; None:
    everything is checked, and `attrs` and `case` are read. Raises ResultFileError for a file that is no
    trajectory, or damaged.
    """

    def __init__(self, path: str | Path, tables: Tables | None = None):
        self.path = Path(path)
        self.attrs: dict[str, Any] = {}
        self.case: Case | None = None
        self._file = open_hdf5(self.path)
        try:
            with damage_named(self.path):
                self._open_tables(tables)
        except BaseException:
            self.close()
            raise

    def _open_tables(self, tables: Tables | None) -> None:
        t_end = inf
        if tables is None:
            tables, t_end = self._promised()
        older = self._scene_of_an_older_file()
        if older is not None:
            tables = older_tables(tables, older)
        samples, events = sample_datasets(tables, t_end), event_datasets(tables, t_end)
        digits = digit_datasets(tables) if "digits" in self._file else []
        orbit = orbit_datasets(self._file[GROUP]) if GROUP in self._file else []
        if self.case is not None:
            check_datasets(self.path, self._file, [*samples, *events, *digits, *orbit])
        self.orbit = FileColumns(self.path, self._file, orbit) if orbit else None
        self.samples = FileColumns(self.path, self._file, samples)
        self.events: Mapping[str, np.ndarray] = FileColumns(self.path, self._file, events)
        if older is not None:
            self.events = CompletedEvents(self.events, older)
        self.digits = self._digits(digits)

    def _promised(self) -> tuple[Tables, float]:
        """Columns and end [s] that the case and the attributes promise, both checked."""
        from vibsim.files.stored_case import stored_case

        self.attrs = checked_attributes(self.path, read_attrs(self._file), ATTRIBUTES)
        self.case = stored_case(self.path, self.attrs)
        scene = self.case.scene()
        known = ERROR_ESTIMATE in self._file or "trust_horizon_s" in self.attrs
        tables = tables_of(scene)
        return (tables.judged() if known else tables), scene.t_end

    def _scene_of_an_older_file(self) -> Scene | None:
        """The scene, where the file is from before events named their part."""
        if self.case is None or self.case.is_long or "part" in self._file.get("events", ("part",)):
            return None
        return self.case.scene()

    def _digits(self, datasets: list[Dataset]) -> Digits | None:
        if not datasets:
            return None
        samples, events = (
            FileColumns(self.path, self._file, [each for each in datasets if of_events(each) == after])
            for after in (False, True)
        )
        return Digits(samples, events)

    def close(self) -> None:
        """Let go of the file; columns not read so far can then not be read."""
        self._file.close()


def of_events(dataset: Dataset) -> bool:
    """Whether a dataset of digits belongs to the table of events."""
    return "/events/" in dataset.name


class FileColumns(Mapping[str, np.ndarray]):
    """Columns of one table on file, read whole on first access and kept; `column` reads slices instead."""

    def __init__(self, path: Path, file: h5py.File, datasets: Iterable[Dataset]):
        self._path, self._file = path, file
        self._datasets = {dataset.name.rpartition("/")[2]: dataset for dataset in datasets}
        self._kept: dict[str, np.ndarray] = {}

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._kept:
            self._kept[name] = self.column(name)[:]
        return self._kept[name]

    def column(self, name: str) -> "FileColumn":
        """One column, not read yet; KeyError when there is none of this name."""
        return FileColumn(self._path, self._file, self._datasets[name])

    def __contains__(self, name: object) -> bool:
        return name in self._datasets

    def __iter__(self) -> Iterator[str]:
        return iter(self._datasets)

    def __len__(self) -> int:
        return len(self._datasets)


class FileColumn:
    """One column on file: `column[a:b]` and `column[i]` read that much, `len` reads nothing.

    Raises ResultFileError for numbers that cannot be right.
    """

    def __init__(self, path: Path, file: h5py.File, declared: Dataset):
        self._path, self._declared = path, declared
        with damage_named(path):
            item = file[declared.name]
        self.dtype = item.dtype
        self._dataset = item.asstr() if declared.column.dtype == "text" else item

    def __len__(self) -> int:
        return int(self._dataset.shape[0])

    def __getitem__(self, rows: Any) -> Any:
        with damage_named(self._path):
            values = self._dataset[rows]
        check_values(self._path, self._declared, values)
        return values
