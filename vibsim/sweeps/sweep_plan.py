"""Plan of a sweep: its case, its axes, the order of its points, and what is kept of each.

`fingerprint` covers everything that the numbers depend on.
"""

import hashlib
import json
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.analysis.cycles import HALF, Discard, parse_discard
from vibsim.cases.problems import CaseError, counted
from vibsim.cases.quantities import Quantity, parse_quantity
from vibsim.physics.connections import reads_time
from vibsim.physics.rates import common_period
from vibsim.results.file_contents import Column
from vibsim.results.store import BESIDE, plain_data, stored
from vibsim.sweeps.axes import Axis, Members, axes_from_plain
from vibsim.sweeps.computations import COMPUTATIONS, length_of
from vibsim.sweeps.quantities import INITIAL, NAME, Quantities, always, distinct, quantities_of

if TYPE_CHECKING:
    from vibsim.cases import Case


# What all points of a sweep have in common: all that a worker needs besides what sets a point apart.
#
# It is small plain data, sent along with every batch of points; the axes, which may be long, stay behind.


SMALLEST = 2.0**-1022  # below it a case does not take a number
Start = Mapping[str, str]  # initial values that replace those of the case, such as {"initial.x1": "0.1 m"}


KEPT = 64  # cases of points that differ in their starts alone


@dataclass(frozen=True)
class PointSettings:
    """Settings by which every point is computed; the attributes are those of `SweepPlan`."""

    case: "Case"
    carry: bool
    discard: Discard
    section: int
    every: Fraction | None
    compute: tuple[str, ...] = ()
    probes: tuple[Start, ...] = ()

    @cached_property
    def of(self) -> Quantities:
        """Quantities that are measured at every point."""
        return quantities_of(self.case)

    @cached_property
    def for_probes(self) -> tuple[Any, ...]:
        """All that decides, beside the parameters of a point, where the probes end."""
        probes = tuple(tuple(sorted(probe.items())) for probe in self.probes)
        return self.case.sha256, probes, str(self.discard), self.every

    def start_after(self, values: Mapping[str, float]) -> Start:
        """Start values of the point that goes on where the one with these `values` ended."""
        starts = self.of.starts.items()
        ends = [(key, unit, values.get(f"end_{name}")) for name, (key, unit) in starts]
        return {
            key: f"{_storable(value)!r} {unit}".rstrip() for key, unit, value in ends if value is not None
        }

    def point_case(self, changes: Mapping[str, str], start: Start | None = None) -> "Case":
        """The case of a point, begun from `start` where a state is carried. Raises CaseError."""
        every = {**changes, **(start or {})}
        starts = {key: value for key, value in every.items() if key.startswith(INITIAL)}
        others = tuple((key, value) for key, value in every.items() if key not in starts)
        try:
            case = self._cases[others]
        except KeyError:
            if len(self._cases) >= KEPT:
                self._cases.clear()
            try:
                case = self._cases[others] = self.case.with_values(dict(others)) if others else self.case
            except CaseError:  # which may name starts too
                return self.case.with_values(every)
        return case.with_values(starts) if starts else case

    @cached_property
    def _cases(self) -> dict[tuple[tuple[str, str], ...], "Case"]:
        """Cases of points by what else than their starts changes."""
        return {}


def _storable(value: float) -> float:
    return value if math.isfinite(value) and abs(value) >= SMALLEST else 0.0


STATISTICS = 3  # raised when a statistic is computed differently: points of two versions do not mix
UP, DOWN = 1, -1
DIRECTIONS = ("up", "down", "both")
DIRECTION_FLAGS = {"up": UP, "down": DOWN}
DIRECTION_NAMES = {code: name for name, code in DIRECTION_FLAGS.items()}

Index = tuple[int, ...]  # position on every axis, then the position of the direction


class PlanError(ValueError):
    """Settings of a sweep that cannot be used, alone or together; the message says which.

    >>> import vibsim
    >>> try:
    ...     vibsim.sweep("II-B", {"Omega0": "3:7:1 Hz"}, compute="speed")
    ... except vibsim.PlanError as error:
    ...     print(str(error).partition(";")[0])
    nothing to compute is called 'speed'
    """


@dataclass(frozen=True)
class SweepPlan:
    """A sweep.

    Attributes
    ----------
    case : the case that the axes vary
    compute : names of what is computed besides, in the order of `vibsim.sweeps.computations`
    axes : one or more; the first is the one along which a state is carried, an ensemble's members the last
    directions : of the first axis, in the order computed: UP (ascending), DOWN, or both; of a list that is
        neither, UP is its own order
    carry : start each point from the end of the one before, `both` going there and back; otherwise every
        point starts as its case says, and the direction makes no difference
    discard : transient left out of the statistics
    section : number of stroboscopic points kept per point, the last ones
    every : interval of the samples that verdicts on the regime are scaled with [s]; None: what suits each
        point's motion
    probes : starts that are followed before any other, so that points stop early where they are sure to end
        on the same orbits, see `vibsim.sweeps.attractor_labels`
    """

    case: "Case" = field(metadata=BESIDE)
    compute: tuple[str, ...] = field(default=(), kw_only=True)
    axes: tuple[Axis | Members, ...] = field(metadata=stored("axes", None, axes_from_plain))
    directions: tuple[int, ...] = field(
        default=(UP,),
        metadata=stored(
            "direction",
            lambda codes: [DIRECTION_NAMES[code] for code in codes],
            lambda names: tuple(DIRECTION_FLAGS[name] for name in names),
        ),
    )
    carry: bool = field(default=False, metadata=stored("carry_state"))
    discard: Discard = field(default=HALF, metadata=stored("discard", str, parse_discard))
    section: int = 100
    every: Fraction | None = field(
        default=None,
        metadata=stored(
            "every",
            lambda every: "auto" if every is None else f"{every} s",
            lambda text: None if text == "auto" else parse_quantity(text, "time").value,
        ),
    )
    probes: tuple[Start, ...] = field(
        default=(),
        kw_only=True,
        metadata=stored("probes", list, lambda starts: tuple(map(dict, starts))),
    )

    def __post_init__(self) -> None:
        names = [axis.name for axis in self.axes]
        if not names:
            raise PlanError("a sweep needs something to vary")
        if len(set(names)) < len(names):
            raise PlanError(f"{next(name for name in names if names.count(name) > 1)} is given twice")
        self._check_keys()
        self._check_columns()
        self._check_carry()
        for name in self.compute:
            kind = COMPUTATIONS[name]
            if not kind.columns(self.point_settings.of):
                raise PlanError(f"{name} is for cases {kind.suits}; {self.case.name} is another kind of case")
        if not self.discard.relative and self.discard.value >= self.case.quantity("run.t_end").value:
            raise PlanError(
                f"a transient of {self.discard} leaves nothing of a run of {self.case.quantity('run.t_end')}"
            )

    def _check_keys(self) -> None:
        keys = [key for axis in self.axes for key in axis.keys]
        if len(set(keys)) < len(keys):
            twice = next(key for key in keys if keys.count(key) > 1)
            if sum(twice in axis.keys for axis in self.axes) == 1:
                raise PlanError(f"{twice} is named twice in one axis")
            raise PlanError(f"{twice} is both swept and spread over the ensemble; choose one")

    def _check_columns(self) -> None:
        """No two names in a file are the same."""
        for axis in self.axes:
            if axis.name in self.columns:
                raise PlanError(f"{axis.name}, which is swept, and a column of the sweep have the same name")

    def _check_carry(self) -> None:
        first = self.axes[0]
        if self.carry and isinstance(first, Members):
            raise PlanError("a state is carried along a range; an ensemble alone has none")
        if self.carry and first.key.startswith("initial."):
            raise PlanError(f"a carried state replaces the initial one, so {first.key} cannot be swept first")
        scene = self.case.scene()
        if self.carry and scene.has_motor and scene.harmonics:
            what = "a motor beside forces or a base that vibrate has no state to carry: where its turns end"
            raise PlanError(f"{what}, these are not where a run begins them")
        if self.carry and reads_time(scene) and common_period(scene) is None:
            what = "a formula that reads the time and has no period in it leaves no state to carry"
            raise PlanError(f"{what}: the next run begins it anew")

    @property
    def shape(self) -> Index:
        """Points per axis, and the number of directions."""
        return (*map(len, self.axes), len(self.directions))

    @property
    def count(self) -> int:
        """Number of points."""
        total = 1
        for length in self.shape:
            total *= length
        return total

    def chains(self) -> Iterator[list[Index]]:
        """The points in chains to be computed one by one; single points unless a state is carried."""
        if not self.carry:
            yield from ([index] for index in product(*map(range, self.shape)))
            return
        for others in product(*map(range, self.shape[1:-1])):
            yield [
                (position, *others, d)
                for d, direction in enumerate(self.directions)
                for position in self._along_first(direction)
            ]

    def _along_first(self, direction: int) -> range:
        count = len(self.axes[0])
        return range(count) if direction == own_way(self.axes[0]) else range(count - 1, -1, -1)

    def changes(self, index: Index) -> dict[str, str]:
        """The values of the case that the point at `index` replaces: dotted key -> text."""
        settings: dict[str, str] = {}
        for axis, i in zip(self.axes, index, strict=False):
            settings |= axis.changes(i)
        return settings

    def point_case(self, index: Index, start: Start | None = None) -> "Case":
        """The case of one point, begun from `start` where a state is carried. Raises CaseError."""
        return self.point_settings.point_case(self.changes(index), start)

    @cached_property
    def point_settings(self) -> PointSettings:
        """Data common to all points; with a point's `changes` all that computing it takes."""
        return PointSettings(
            self.case, self.carry, self.discard, self.section, self.every, self.compute, self.probes
        )

    @cached_property
    def columns(self) -> dict[str, Column]:
        """Columns stored of each point, by name."""
        of = self.point_settings.of
        computed = (COMPUTATIONS[name].columns(of) for name in self.compute)
        return distinct(always(of).items(), *(columns.items() for columns in computed))

    def shape_of(self, name: str) -> Index:
        """Shape of a column: that of the sweep, and its further dimension where it has one."""
        dimension = self.columns[name].dimension
        return (*self.shape, self.length_of(dimension)) if dimension else self.shape

    def length_of(self, dimension: str) -> int:
        """Length of a further dimension."""
        return length_of(dimension, self.case.scene(), self.section)

    @cached_property
    def settings(self) -> dict[str, Any]:
        """Everything but the case, as plain data for JSON."""
        settings = {**plain_data(self), "statistics": STATISTICS}
        if not self.compute:
            del settings["compute"]  # files without it stay valid
        if not self.probes:
            del settings["probes"]
        return settings

    @cached_property
    def fixed_values(self) -> dict[str, str]:
        """The values of the case that no axis varies: dotted key -> text in exact SI units."""
        swept = {key for axis in self.axes for key in axis.keys} | {"name", "title"}
        return {key: _exact(value) for key, value in self.case.values.items() if key not in swept}

    @cached_property
    def fingerprint(self) -> str:
        """SHA-256 of what the numbers depend on: two sweeps of one fingerprint have the same points."""
        text = json.dumps({"case": self.fixed_values, **self.settings}, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()


def own_way(axis: Axis | Members) -> int:
    """The direction in which the values of an axis are written: UP or DOWN; UP for a list that is neither."""
    return DOWN if axis.way < 0 else UP


def read_directions(word: str | None, axis: Axis | Members, carry: bool) -> tuple[int, ...]:
    """The directions that `word` ("up", "down", "both", None: as it is written) means along an axis.

    carry : whether a state is carried along it; otherwise points have no order
    Raises PlanError for another word, and where a list that runs neither up nor down is to run so.
    """
    own = own_way(axis)
    if word is None:
        return (own if carry else UP,)
    if word not in DIRECTIONS:
        raise PlanError(f"direction must be up, down or both, got {word}")
    if word == "both":
        return own, -own
    if not axis.way:
        raise PlanError(
            f"a direction needs values that rise or fall: sort those of {axis.name}, or leave the direction "
            "out"
        )
    return (DIRECTION_FLAGS[word],)


def _exact(value: Any) -> str:
    if isinstance(value, Quantity):
        return f"{value.value} turns" if value.per_turn else str(value.value)
    return str(value)


# How much memory a sweep takes: all its points are held at one time.


TEXTS = 150  # bytes per point: fingerprint, status, references
SHARE = 0.7  # of the memory of this machine


def bytes_per_point(plan: SweepPlan) -> int:
    """Memory of one point [bytes]."""
    lengths = [plan.shape_of(name)[len(plan.shape) :] for name in plan.columns]
    return 8 * sum(int(np.prod(length)) for length in lengths) + TEXTS


def check_memory(plan: SweepPlan) -> None:
    """Raise PlanError where the points of a plan do not fit into memory."""
    each, there = bytes_per_point(plan), _memory()
    needed = plan.count * each
    if there and needed > SHARE * there:
        raise PlanError(
            f"{plan.count:,} points of {each} bytes take {needed / 1e9:.3g} GB of memory, and this machine"
            f" has {there / 1e9:.3g} GB; share them out among files (--shard K/N), or keep fewer"
            " stroboscopic points (--section)"
        )


def _memory() -> int:
    """Memory of this machine [bytes]; 0 where that is not known."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return 0


# A large sweep shared out among several files: each part is a sweep of its own, along a part of one axis.


def read_shard(text: str) -> tuple[int, int]:
    """Number of a part and of all parts from K/N. Raises PlanError."""
    first, _, last = text.partition("/")
    try:
        number, parts = int(first), int(last)
    except ValueError:
        number, parts = 0, 0
    if not 1 <= number <= parts:
        raise PlanError(f"a shard is written as K/N with K from 1 to N, such as 3/10, got {text}")
    return number, parts


def shard(plan: SweepPlan, number: int, parts: int) -> SweepPlan:
    """Part `number` of `parts` of a plan, counted from 1; its points are those of the whole, bit for bit.

    Its longest axis is cut; not the first one where a state is carried along it. Raises PlanError where that
    has not so many values.
    """
    free = range(1 if plan.carry else 0, len(plan.axes))
    if not free:
        raise PlanError("a state is carried from point to point along the only axis, so it cannot be cut")
    cut = max(free, key=lambda i: len(plan.axes[i]))
    axis = plan.axes[cut]
    if parts > len(axis):
        raise PlanError(
            f"the longest axis that can be cut, {axis.name}, has {counted(len(axis), 'value')}, not {parts}"
        )
    begin, end = (len(axis) * i // parts for i in (number - 1, number))
    axes = [axis.part(begin, end) if i == cut else other for i, other in enumerate(plan.axes)]
    return replace(plan, axes=tuple(axes))


# Starts that are followed first: what they end on is known to all points of their scene.


FEWEST_STARTS = 32  # of one scene, below which it does not pay
STARTS_PER_PROBE = 8
MOST_PROBES = 24
PLASTIC = 1.32471795724474602596  # x^3 = x + 1: points of two axes spread as evenly as those of one by gold


def probe_starts(axes: Sequence[Axis | Members], compute: Sequence[str], carry: bool) -> tuple[Any, ...]:
    """Changes of the initial values for each probe of a sweep; none where they do not pay.

    Positions k = 1, 2, ... along the i-th axis of starts are the fractions of k / a^i, a the plastic number
    (M. Roberts, The unreasonable effectiveness of quasirandom sequences, 2018).
    """
    starts = [axis for axis in axes if is_of_starts(axis)]
    count = prod(map(len, starts))
    if NAME not in compute or carry or not starts or count < FEWEST_STARTS:
        return ()
    probes = []
    for k in range(1, min(MOST_PROBES, count // STARTS_PER_PROBE) + 1):
        changes: dict[str, str] = {}
        for i, axis in enumerate(starts, 1):
            share = (0.5 + k * PLASTIC**-i) % 1.0
            changes |= axis.changes(int(share * len(axis)))
        probes.append(changes)
    return tuple(probes)


def is_of_starts(axis: Axis | Members) -> bool:
    """Whether an axis varies initial values alone."""
    return all(key.startswith(INITIAL) for key in axis.keys)
