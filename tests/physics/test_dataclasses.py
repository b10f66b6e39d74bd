"""Dataclasses of `vibsim.lazy` beside those of the standard library."""

import copy
import dataclasses
import inspect
import pickle
from collections.abc import Callable
from typing import Any

import pytest

from vibsim.lazy import dataclass
from vibsim.physics.parts import Body

WAYS = [{}, {"frozen": True}, {"eq": False}, {"frozen": True, "eq": False}, {"frozen": True, "repr": False}]
WAYS += [{"slots": False}]


def outcome(call: Callable[[], Any]) -> tuple[str, Any]:
    """What a call gives, or the error that it raises; addresses of objects are left out."""
    try:
        return "value", str(call()).partition(" at 0x")[0]
    except Exception as error:
        return type(error).__name__, str(error)


def shown(decorate: Callable[..., Any], way: dict[str, bool]) -> list[tuple[str, Any]]:
    """All that can be seen of classes that are decorated so."""

    @decorate(**way)
    class Pair:
        """Two numbers."""

        first: int
        second: float = dataclasses.field(default=2.0, compare=False)
        list: list = dataclasses.field(default_factory=list, hash=False, repr=False)
        own: int = dataclasses.field(default=3, init=False)
        named: int = dataclasses.field(default=5, kw_only=True)

        def __post_init__(self) -> None:
            object.__setattr__(self, "sum", self.first + self.second)

    @decorate(**way)
    class Triple(Pair):
        """Three numbers, whose representation is its own."""

        third: tuple = ()

        def __repr__(self) -> str:
            return f"<{self.first}>"

    one, other, three = Pair(1), Pair(1, 3.0), Triple(1, 2.0, [4], (3,), named=6)
    calls: list[Callable[[], Any]] = [
        lambda: (one, three, one.sum, one == other, one == Pair(2), one == three, three == copy.copy(three)),
        lambda: (hash(one) == hash(other), hash(three) == hash(Triple(1, 2.0, [5], (3,), named=6))),
        lambda: (dataclasses.replace(three, first=7).third, dataclasses.asdict(three), Triple.__match_args__),
        lambda: setattr(one, "first", 4),
        lambda: setattr(one, "new", 4),
        lambda: delattr(one, "second"),
        lambda: [one.first, one.second, vars(one)],
        lambda: Pair(),
        lambda: Pair(1, 2, [], 4),
        lambda: Triple(1, third=2, named=3).third,
        lambda: list(inspect.signature(Triple).parameters),
    ]
    return [outcome(call) for call in calls]


@pytest.mark.parametrize("way", WAYS, ids=str)
def test_they_are_as_those_of_the_standard_library(way):
    assert shown(dataclass, way) == shown(dataclasses.dataclass, way)


def test_they_go_through_pickle():
    body = Body("ram", 1.0, 0.5, -0.0)
    assert pickle.loads(pickle.dumps(body)) == body
