"""What an HDF5 file holds, as data: columns, datasets and attributes. Files are written and checked by it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from typing import Any, NamedTuple

import numpy as np


@dataclass(frozen=True)
class Column:
    """What the numbers or texts of a column are.

    Attributes
    ----------
    units : UDUNITS unit; None: a flag or a text
    long_name : what it is
    dimension : of a table of points, what further dimension it has, such as "section"; empty: none
    dtype : "f8", "i1", "i2", "i4", "i8"; "S" for texts of one length, "text" for texts of any
    flags : what each value means, where it is a code
    missing : the value that stands for none
    besides : further attributes
    """

    units: str | None
    long_name: str
    dimension: str = ""
    dtype: str = field(default="f8", kw_only=True)
    flags: Mapping[str, int] = field(default_factory=dict, kw_only=True)
    missing: int | None = field(default=None, kw_only=True)
    besides: Mapping[str, str] = field(default_factory=dict, kw_only=True)

    def attributes(self) -> dict[str, Any]:
        """Its attributes on file, as the CF conventions have them; None where there is none."""
        described: dict[str, Any] = {"long_name": self.long_name, "units": self.units}
        if self.flags:
            described["flag_values"] = np.array(list(self.flags.values()), self.dtype)
            described["flag_meanings"] = " ".join(flag.replace(" ", "_") for flag in self.flags)
        if self.missing is not None:
            described["missing_value"] = np.array(self.missing, self.dtype)
        return described | dict(self.besides)


class Dataset(NamedTuple):
    """A dataset.

    Attributes
    ----------
    name : path in the file, such as "events/t"
    column : what stands in it
    dims : names of its dimensions; datasets that share one have the same length along it. The one that has
        the name of its only dimension is the scale of it
    codes : whole numbers that may stand in it, where they are not the flags of its column; empty: any
    gaps : whether NaN and infinity may stand in it
    ascending : whether no value may be smaller than the one before
    span : least and greatest value
    """

    name: str
    column: Column
    dims: tuple[str, ...]
    codes: frozenset[int] = frozenset()
    gaps: bool = False
    ascending: bool = False
    span: tuple[float, float] = (-inf, inf)

    @property
    def allowed(self) -> frozenset[int]:
        """Whole numbers that may stand in it; empty: any."""
        return self.codes or frozenset(self.column.flags.values())

    @property
    def is_scale(self) -> bool:
        """Whether it is the scale of its dimension."""
        return self.dims == (self.name.rpartition("/")[2],)


class Attribute(NamedTuple):
    """A root attribute.

    Attributes
    ----------
    kind : TEXT, WHOLE, NUMBER (finite), EXTENDED (a number that may be infinite), or LIST and ROWS of these
    optional : whether a file may do without it
    where : attribute beside which it must be, if that is there and not 0, although it is optional
    allowed : values, where only some are
    """

    name: str
    kind: str
    optional: bool = False
    where: str = ""
    allowed: tuple[int | str, ...] = ()


TEXT, WHOLE, NUMBER, EXTENDED = "a text", "a whole number", "a finite number", "a number"
LIST, ROWS = "a list of numbers", "a table of numbers"
