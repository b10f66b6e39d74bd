"""Write a trajectory and its digits to an HDF5 file while they are being computed."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.files.digits_stream import DigitsStream
from vibsim.physics.arithmetic.exact_decimals import text_width
from vibsim.results.columns import Tables
from vibsim.results.stored.trajectory_structure import digit_columns
from vibsim.results.stored.trajectory_writer import EVENT_CHUNK, FOR_COLUMN, SAMPLE_CHUNK, TrajectoryWriter


class TruthWriter(TrajectoryWriter):
    """A trajectory writer that also takes texts of `digits` digits: groups /digits and /digits/events."""

    def __init__(
        self,
        path: str | Path,
        tables: Tables,
        attrs: Mapping[str, Any],
        digits: int,
        force: bool = False,
    ):
        super().__init__(path, tables, attrs, force)
        states, happened = digit_columns(tables)
        width = text_width(digits)
        group = self._file.create_group("digits")
        time = self._file["time"]
        self.sample_digits = DigitsStream(group, states, width, SAMPLE_CHUNK, time)
        self.event_digits = DigitsStream(group.create_group("events"), happened, width, EVENT_CHUNK)
        self.streams += [self.sample_digits, self.event_digits]
        self._besides += FOR_COLUMN * (2 * len(states) + 2)
        self._file.flush()

    def append_digits(self, samples: Mapping[str, np.ndarray], events: Mapping[str, np.ndarray]) -> None:
        """Take the digits of one block, before its samples and events."""
        self._digits = samples, events

    def _take(self, samples: Mapping[str, np.ndarray], events: Mapping[str, np.ndarray]) -> None:
        super()._take(samples, events)
        self.sample_digits.append(self._digits[0])
        self.event_digits.append(self._digits[1])
