"""Contents of an HDF5 file as data: columns, datasets and attributes. Files are written and checked by it."""

import math
import platform
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime, timezone
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibsim import __version__

if TYPE_CHECKING:
    from vibsim.cases import Case


@dataclass(frozen=True)
class Column:
    """Meaning of the numbers or texts of a column.

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


# Where a file comes from: the root attributes that every kind of file has.


FORMAT = 1  # raised when an older reader would misread a newer file
CASE = ("case_name", "case_yaml", "case_resolved_json", "case_sha256")
MACHINE = ("date_created", "platform", "python_version", "numpy_version")
PROVENANCE = [Attribute(name, TEXT) for name in ("title", "vibsim_version", *CASE, *MACHINE)]
ENGINE_NAME = "c"  # the engine that makes files; one in Python, equal in every bit, made some of old
ENGINE = Attribute("engine", TEXT, allowed=(ENGINE_NAME, "python"))


def provenance(kind: str, case: "Case", title: str = "") -> dict[str, Any]:
    """Format, kind, case, versions and platform of a file that is made now.

    title : that of the case unless given
    """
    return {
        "Conventions": "CF-1.8",
        "title": title or case.title or case.name,
        "vibsim_format": FORMAT,
        "vibsim_kind": kind,
        "vibsim_version": __version__,
        "case_name": case.name,
        "case_yaml": case.text,
        "case_resolved_json": case.resolved_json(),
        "case_sha256": case.sha256,
        "date_created": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "platform": f"{platform.system()} {platform.release()} {platform.machine()}",
        "python_version": platform.python_version(),
        "numpy_version": np.__version__,
    }


# Where a trajectory comes from and what came of it: the root attributes of a file.
#
# What is not known is left out; an attribute is never a made-up number.


LEDGER = (
    "energy_start",
    "energy_end",
    "work_source",
    "work_base",
    "work_belt",
    "loss_viscous",
    "loss_friction",
    "loss_stops",
    "energy_residual",
    "energy_residual_relative",
)
RIGID_TOTALS = ("transmitted", "chatters", "rests", "chatter_time", "chatter_speed", "chatter_distance")
TOTALS = (
    "impacts",
    "sticks",
    "reversals",
    "events",
    "steps",
    "evaluations",
    "uncertified",
    "first_uncertified_time",
    "grazing_margin",
    "grazing_time",
    "violations",
    "first_violation_time",
    *RIGID_TOTALS,
    *LEDGER,
)
OF_A_PART = "."  # in the name of a total: loss.stops.anvil


def origin(case: "Case", scene: Any, method: str) -> dict[str, Any]:
    """Attributes known before the first step: format, case, method, versions, platform."""
    attrs: dict[str, Any] = {
        **provenance("trajectory", case),
        "method": method,
        "engine": ENGINE_NAME,
        "t_end_s": float(scene.t_end),
        "complete": 0,
    }
    if method != "closed_form":
        attrs |= {"taylor_order": scene.order, "taylor_tolerance": float(scene.tol)}
    return attrs


def outcome(
    totals: dict[str, Any],
    t_reached: float,
    distances: dict[str, Any],
    wall_time: float,
    complete: bool,
) -> dict[str, Any]:
    """Attributes known at the end of a run; `certified` is 1 where every event is proved.

    Times in s, `grazing_margin` and the `distances` needed in m.
    """
    certified = {"certified": int(totals["uncertified"] == 0)} if "uncertified" in totals else {}
    names = [name for name in totals if name in TOTALS or OF_A_PART in name]
    known = {name: totals[name] for name in names if math.isfinite(totals[name])}
    if not complete and not _ledger_has_begun(known):
        known = {name: value for name, value in known.items() if not _of_ledger(name)}
    return {
        **known,
        **certified,
        **distances,
        "t_reached_s": t_reached,
        "wall_time_s": wall_time,
        "complete": int(complete),
    }


def _of_ledger(name: str) -> bool:
    return name in LEDGER or name.startswith(("work.", "loss."))


def _ledger_has_begun(known: dict[str, Any]) -> bool:
    """Whether the energy ledger has a stretch of motion: it gets one when all of it is done, and before the
    first its residual is zero without meaning anything.
    """
    entries = [name for name in known if name.startswith(("work", "loss"))]
    return any(known.get(name) for name in entries) or known.get("energy_end") != known.get("energy_start")
