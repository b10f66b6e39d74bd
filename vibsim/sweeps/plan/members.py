"""The axis of an ensemble: members that begin differently, each drawn from the seed and its own number."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.sweeps.plan.axis import Axis
from vibsim.sweeps.plan.spread import Spread, SpreadError, read_spread

if TYPE_CHECKING:
    from vibsim.cases import Case

NAME = "member"
FULL_TURN = "0:1 turn"
ROTOR_ANGLES = ("initial.phi", "initial.motor.phi")  # in the short form of a case, and in the long


@dataclass(frozen=True)
class Members:
    """An axis of `count` members that takes the place of a key's values; see `Axis`.

    Attributes
    ----------
    seed : of all draws
    spreads : what varies, and how
    first : number of the first member: an ensemble may be shared among several files
    """

    count: int
    seed: int
    spreads: tuple[Spread, ...]
    first: int = 0

    key = name = NAME
    unit = ""

    def __len__(self) -> int:
        return self.count

    @property
    def way(self) -> int:
        """Members are numbered upwards."""
        return 1

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys of the case that the axis sets."""
        return tuple(spread.key for spread in self.spreads)

    @cached_property
    def drawn(self) -> dict[str, np.ndarray]:
        """Values of every member (n) by key, in the unit of the spread."""
        return {spread.key: spread.draw(self.seed, self.first, self.count) for spread in self.spreads}

    def numbers(self) -> np.ndarray:
        """Numbers of the members (n)."""
        return np.arange(self.first, self.first + self.count)

    def text(self, position: int) -> str:
        """Number of one member."""
        return str(self.first + position)

    def changes(self, position: int) -> dict[str, str]:
        """What a member replaces in the case: key -> shortest text that reads back to the number drawn."""
        return {
            spread.key: f"{float(self.drawn[spread.key][position])!r} {spread.unit}".strip()
            for spread in self.spreads
        }

    def plain(self) -> dict[str, Any]:
        """The axis as plain data for JSON; `from_plain` reads it back."""
        spreads = [spread.plain() for spread in self.spreads]
        return {"key": NAME, "count": self.count, "first": self.first, "seed": self.seed, "spread": spreads}

    @staticmethod
    def from_plain(data: Mapping[str, Any]) -> "Members":
        """The axis that `plain` wrote down."""
        spreads = tuple(map(Spread.from_plain, data["spread"]))
        return Members(data["count"], data["seed"], spreads, data["first"])

    def part(self, begin: int, end: int) -> "Members":
        """The members at positions `begin` to `end - 1`, each as it was."""
        return Members(end - begin, self.seed, self.spreads, self.first + begin)

    def __str__(self) -> str:
        count = f"{self.count} member{'' if self.count == 1 else 's'}"
        return f"{count}, seed {self.seed}: {'; '.join(map(str, self.spreads))}"


def axis_from_plain(data: Mapping[str, Any]) -> Axis | Members:
    """The axis or ensemble that its `plain` wrote down."""
    return Members.from_plain(data) if "seed" in data else Axis.from_plain(data)


def read_members(case: "Case", count: int, seed: int, spreads: Mapping[str, str]) -> Members:
    """An ensemble of a case; of a motor, unless told otherwise, over all rotor angles at the start.

    spreads : key -> spread, see `vibsim.sweeps.plan.spread`

    Raises SpreadError and what `read_spread` raises.
    """
    if count < 1:
        raise SpreadError(f"an ensemble needs at least 1 member, got {count}")
    if seed < 0:
        raise SpreadError(f"the seed must not be negative, got {seed}")
    angle = next((key for key in ROTOR_ANGLES if key in case.values), None)
    if not spreads and angle is not None:
        spreads = {angle: FULL_TURN}
    if not spreads:
        raise SpreadError('say what varies over the ensemble, such as spread={"x1": "1 mm"}')
    read = tuple(read_spread(case, key, text) for key, text in spreads.items())
    keys = [spread.key for spread in read]
    if len(set(keys)) < len(keys):
        raise SpreadError(f"{next(key for key in keys if keys.count(key) > 1)} is spread twice")
    return Members(count, seed, read)
