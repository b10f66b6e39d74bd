"""Plans and records as plain data: through JSON and back, every type that there is, by names of files."""

import json
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import pytest

from vibsim.orbits.branches.correction import Pace
from vibsim.results.store import BESIDE, from_plain, plain_data, stored
from vibsim.sweeps.axes import Axis, Members, Spread, axis_from_plain


class Pair(NamedTuple):
    first: float
    second: int


@dataclass(frozen=True)
class Inner:
    case: str = field(metadata=BESIDE)
    word: tuple[tuple[str, int], ...]
    pairs: tuple[complex, ...] = ()


def _spelled(ways):
    return "".join(map(str, ways))


def _ways(text):
    return tuple(map(int, text))


@dataclass(frozen=True)
class Outer:
    number: int
    inner: "Inner"
    share: Fraction | None
    pace: Pair
    texts: dict[str, str] = field(default_factory=dict)
    arrays: dict[str, np.ndarray] = field(default_factory=dict)
    span: tuple[float, float] = field(default=(0.0, 1.0), metadata=stored("range"))
    ways: tuple[int, ...] = field(default=(1,), metadata=stored("directions", _spelled, _ways))


INNER = Inner("here", (("impact", 0), ("reversal", 1)), (1 + 2j, -0.5j))
ARRAYS = {"x": np.array([1.5, -0.0, np.inf])}
WHOLE = Outer(3, INNER, Fraction(1, 3), Pair(0.1, 2), {"a": "b"}, ARRAYS, (2.0, float("inf")), (1, 2))
PLAIN = {
    "number": 3,
    "inner": {"word": [["impact", 0], ["reversal", 1]], "pairs": [[1.0, 2.0], [-0.0, -0.5]]},
    "share": "1/3",
    "pace": [0.1, 2],
    "texts": {"a": "b"},
    "arrays": {"x": "000000000000f83f0000000000000080000000000000f07f"},
    "range": [2.0, float("inf")],
    "directions": "12",
}


def test_every_type_has_its_plain_form():
    assert plain_data(WHOLE) == PLAIN and list(plain_data(WHOLE)) == list(PLAIN)


def test_what_is_read_back_is_the_same_to_the_bit():
    read = from_plain(Outer, json.loads(json.dumps(plain_data(WHOLE))), case="here")
    assert read.arrays["x"].tobytes() == WHOLE.arrays["x"].tobytes()
    assert plain_data(read) == plain_data(WHOLE) and read.inner == WHOLE.inner and read.share == WHOLE.share
    assert isinstance(read.pace, Pair) and read.span == WHOLE.span and read.ways == WHOLE.ways


def test_a_field_without_data_has_its_default():
    read = from_plain(Outer, {name: PLAIN[name] for name in ("number", "inner", "share", "pace")}, case="")
    assert (read.texts, read.span, read.ways) == ({}, (0.0, 1.0), (1,))


@pytest.mark.parametrize(
    "change",
    [
        {"number": "three"},
        {"number": None},
        {"inner": {"word": [["impact"]]}},
        {"inner": {"word": [[0, 1]]}},
        {"inner": []},
        {"share": "1/0"},
        {"pace": [0.1]},
        {"pace": [0.1, 2, 3]},
        {"range": [2.0]},
        {"range": 2.0},
        {"arrays": {"x": "xyz"}},
    ],
)
def test_data_of_another_kind_are_refused(change):
    with pytest.raises((AttributeError, LookupError, TypeError, ValueError)):
        from_plain(Outer, PLAIN | change, case="here")


def test_axes_of_sweeps_are_told_apart():
    axis = Axis("excitation.Omega0", "Hz", (Fraction(3), Fraction(7, 2)), ("c",))
    spread = Spread("initial.x1", "mm", "uniform", Fraction(0), Fraction(1, 10))
    for each in (axis, Members(5, 2, (spread,), first=3)):
        data = each.plain() if isinstance(each, Axis) else plain_data(each)
        assert axis_from_plain(json.loads(json.dumps(data))) == each
    assert data == {
        "key": "member",
        "count": 5,
        "first": 3,
        "seed": 2,
        "spread": [
            {"key": "initial.x1", "unit": "mm", "shape": "uniform", "centre": "0", "width": "0.1"},
        ],
    }


def test_the_bounds_of_the_step_are_a_list():
    @dataclass(frozen=True)
    class Plan:
        pace: Pace

    assert plain_data(Plan(Pace(1e-2, 1e-9, 0.5))) == {"pace": [1e-2, 1e-9, 0.5]}
    assert from_plain(Plan, {"pace": [1e-2, 1e-9, 0.5]}).pace == Pace(1e-2, 1e-9, 0.5)
