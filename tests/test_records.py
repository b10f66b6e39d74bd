"""Data classes of vibsim against those of `dataclasses`: the same class written with both."""

import ast
import copy
import dataclasses
import inspect
import pickle
from pathlib import Path

import pytest

import vibsim
from vibsim.records import dataclass

NAN = float("nan")


def point(decorator):
    @decorator(frozen=True)
    class Point:
        """A point."""

        x: float
        y: float = 2.0
        names: list[str] = dataclasses.field(default_factory=list)
        hidden: int = dataclasses.field(default=0, repr=False, compare=False)
        mark: str = dataclasses.field(default="o", kw_only=True)

    return Point


def counter(decorator):
    @decorator
    class Counter:
        """A counter."""

        count: int = 0
        total: int = dataclasses.field(default=0, kw_only=True)

        def __post_init__(self):
            self.total += self.count

    return Counter


def empty(decorator):
    @decorator(frozen=True, slots=True)
    class Empty:
        """Nothing."""

    return Empty


@dataclass(frozen=True, slots=True)
class Slotted:
    """A class with slots, of a module so that it can be pickled."""

    x: float
    y: tuple = ()


@dataclass(frozen=True, repr=False)
class Own:
    """A class with an equality, a representation and a subclass of its own."""

    x: float

    def __eq__(self, other):
        return isinstance(other, Own)

    def __repr__(self):
        return "own"


class Wider(Own):
    """Not a data class itself."""

    def __init__(self, x):
        super().__init__(x)
        self.more = 2 * x


def told(action):
    """What comes of an action: its value, or the sort of error and its text."""
    try:
        return action()
    except Exception as error:
        return type(error).__name__, str(error)


ACTIONS = [
    lambda P: repr(P(1.0)),
    lambda P: repr(P(1.0, names=["a"], mark="x", hidden=5)),
    lambda P: P(1.0) == P(1.0, 2.0, [], 7),
    lambda P: P(NAN) == P(NAN),
    lambda P: P(1.0) == P(1.5) or P(1.0) != P(1.0) or P(1.0) == 1.0,
    lambda P: hash(P(1.0, 2.0, ())) == hash(P(1.0, 2.0, (), 3)),
    lambda P: hash(P(1.0)),
    lambda P: repr(P()),
    lambda P: repr(P(1, 2, [], 0, "x")),
    lambda P: repr(P(1, z=3)),
    lambda P: setattr(P(1.0), "x", 2.0),
    lambda P: setattr(P(1.0), "z", 2.0),
    lambda P: delattr(P(1.0), "x"),
    lambda P: P(1.0).names is P(1.0).names,
    lambda P: dataclasses.asdict(dataclasses.replace(P(1.0), x=3.0, mark="y")),
    lambda P: dataclasses.asdict(copy.deepcopy(P(1.0, names=["a"]))),
    lambda P: [(field.name, field.type) for field in dataclasses.fields(P)],
    lambda P: str(inspect.signature(P)),
    lambda P: (P(1.0), str(inspect.signature(P)))[1],
    lambda P: (P.__doc__, P.__match_args__, P.y, hasattr(P, "names")),
]


@pytest.mark.parametrize("make", [point, counter, empty], ids=["frozen", "changing", "empty"])
@pytest.mark.parametrize("number", range(len(ACTIONS)))
def test_both_do_the_same(make, number):
    action = ACTIONS[number]
    assert told(lambda: action(make(dataclass))) == told(lambda: action(make(dataclasses.dataclass)))


def test_classes_with_slots_are_pickled_and_have_no_dictionary():
    one = Slotted(1.0, (2, 3))
    for other in (pickle.loads(pickle.dumps(one)), copy.copy(one)):
        assert other == one and hash(other) == hash(one) and not hasattr(other, "__dict__")


def test_what_a_class_says_itself_is_kept():
    assert Own(1.0) == Own(2.0) and repr(Own(1.0)) == "own"
    assert hash(Own(1.0)) == hash((1.0,))
    wide = Wider(1.0)
    assert (wide.x, wide.more) == (1.0, 2.0)
    with pytest.raises(dataclasses.FrozenInstanceError):
        wide.x = 2.0


def test_the_initializer_is_written_when_it_is_needed():
    Point = point(dataclass)
    assert not inspect.isfunction(Point.__init__)
    Point(1.0)
    assert inspect.isfunction(Point.__init__)


def test_all_data_classes_are_of_this_kind():
    folder = Path(vibsim.__file__).parent
    others = [
        str(path.relative_to(folder))
        for path in folder.rglob("*.py")
        if path.name != "records.py" and "dataclass" in _imported(path)
    ]
    assert others == []


def _imported(path):
    """Names that a module takes from `dataclasses`."""
    if "dataclasses" not in (text := path.read_text(encoding="utf-8")):
        return set()
    nodes = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ImportFrom)]
    return {name.name for node in nodes if node.module == "dataclasses" for name in node.names}
