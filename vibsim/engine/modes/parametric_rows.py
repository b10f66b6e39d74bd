"""Packed numbers of a mode as they follow from some numbers of its scene: recorded once, repeated.

A branch over a damping or a gap changes numbers of the same few modes from value to value. Making their rows
takes some 0.1 ms each; what of them depends on the parameter is a handful of operations.

Two scenes may differ in nothing but such numbers. Rows hold numbers of the parts, but none of a motor and no
frequency or phase of a force. Where every other number has the same sign in both scenes, and frictions that
drop as they begin to slip do so in both, rows and rules of a mode have the same form.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from fractions import Fraction
from functools import cache
from itertools import chain
from math import copysign
from typing import Any, NamedTuple

from vibsim.engine.flows.closed.modal import pitches
from vibsim.engine.flows.closed.modal_maker import modal_of
from vibsim.engine.modes.packing import EventNumbers, Packed, Packer, packed_mode
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import ModeRows
from vibsim.engine.modes.status import Status
from vibsim.physics.parts import Body, Clearance, Friction, Harmonic, RigidStop, Scene, Stop
from vibsim.physics.traced_numbers import NotRecorded, Record, Recorded, RecordedNumbers


class ParametricRows(NamedTuple):
    """The packed numbers of a mode at first, and how those that change follow from the numbers of the scene.

    changing : by place among the doubles, the place in the record
    """

    ints: bytes
    doubles: array[float]
    changing: tuple[tuple[int, int], ...]
    record: Record

    def packed(self, numbers: Sequence[Number]) -> Packed | None:
        """The mode as bytes of ints and of doubles for other numbers; None where it takes another form."""
        values = self.record.repeated(numbers)
        if values is None:
            return None
        doubles = self.doubles[:]
        for place, number in self.changing:
            doubles[place] = values[number]
        return self.ints, doubles.tobytes()


def recipe_of(
    scene: Scene,
    places: Sequence[Place],
    status: Status,
    keys: EventNumbers,
    packer: Callable[[Any, ModeRows[Any]], Packer] | None = None,
) -> ParametricRows | None:
    """The recipe of a mode for the numbers of a scene in `places`; None where it cannot be recorded.

    keys : numbers of event keys in C, which grow; packer : packs something else than the rows, on a kit
    """
    kit: Any = RecordedNumbers
    record = Record([_number(scene, place) for place in places])
    recorded: Any = with_recorded(scene, dict(zip(places, record.inputs, strict=True)), record)
    try:
        rows = RowMaker(recorded, kit).rows(status)
        if packer:
            pack = packer(kit, rows)
        else:
            pack = packed_mode(rows, keys, modal=modal_of(recorded, kit, rows, pitches(recorded)))
    except NotRecorded:
        return None
    numbers: list[Any] = [*pack.doubles]
    changing = tuple((i, one.place) for i, one in enumerate(numbers) if isinstance(one, Recorded))
    record.for_results(place for _, place in changing)
    changing = tuple((i, place) for i, place in changing if record.depends[place])
    doubles = array("d", (n.value if isinstance(n, Recorded) else n for n in numbers))
    return ParametricRows(array("i", pack.ints).tobytes(), doubles, changing, record)


def with_recorded(scene: Any, inputs: Mapping[Place, Recorded], record: Record) -> Any:
    """The scene with other numbers in some places; the other ones within formulas are constants of the
    record.
    """
    for place, number in inputs.items():
        if not is_in_formula(place):
            scene = with_number(scene, place, number)
    parts: dict[str, Any] = {}
    for name in PARTS:
        made = []
        for k, part in enumerate(vars(scene)[name]):
            formulas = {one: node for one in FORMULAS if (node := getattr(part, one, None))}
            for one, node in formulas.items():
                formulas[one] = _recorded_formula(node, (name, k, one), inputs, record)
            made.append(replace(part, **formulas) if formulas else part)
        parts[name] = tuple(made)
    base = scene.base_formula
    if base is not None:
        parts["base_formula"] = _recorded_formula(base, ("base_formula",), inputs, record)
    return scene.but(**parts)


def _recorded_formula(node: Any, place: Place, inputs: Mapping[Place, Recorded], record: Record) -> Any:
    """A formula, or several, with its numbers recorded."""
    if not isinstance(node, tuple):
        return node
    if node[:1] == ("num",):
        number = inputs.get((*place, 1))
        return "num", record.constant(node[1]) if number is None else number
    if node[:1] == ("table",):  # whose numbers stay what they are, and may be equal to others
        for knot in chain(node[2], *node[3]):
            record.keys |= dict.fromkeys(record.constant(one).place for one in (knot, float(knot)))
    return tuple(_recorded_formula(part, (*place, i), inputs, record) for i, part in enumerate(node))


def is_in_formula(place: Place) -> bool:
    """Whether a number stands within a formula."""
    return len(place) > 3 and place[2] in FORMULAS


def _number(scene: Any, place: Place) -> Number:
    """The number of a scene in a place."""
    for step in place:
        scene = scene[step] if isinstance(step, int) else getattr(scene, step)
    number: Number = scene if isinstance(scene, Fraction) else float(scene)
    return number


# Whether the modes of two scenes differ in nothing but their numbers, and which numbers those are.


Place = tuple[str | int, ...]  # names of fields and numbers of parts, from the scene to the number
Number = float | Fraction  # the latter in formulas
Numbers = dict[Place, Number]

PARTS = ("bodies", "links", "stops", "frictions", "forces", "base", "clearances")
FREE = {  # what no row holds
    Body: ("x", "v"),
    Stop: ("at_start",),
    RigidStop: ("at_start",),
    Clearance: ("at_start",),
    Harmonic: ("omega", "cycles", "cycles_lo", "phase"),
}
PLAIN = (str, int, type(None))
FORMULAS = ("force", "formula", "slips", "holds", "course")  # fields of formulas
WHOLE = ("rotors", "base_formula", "base_is_rate")  # parts of a scene that have to be equal
STEADY = ("belt",)  # what decides with which others a friction stands, where there are several


def differences(one: Scene, other: Scene) -> Numbers | None:
    """The numbers in the rows of `other` that are not those of `one`, by place; None where their modes have
    not the same form.
    """
    if settings(one) != settings(other) or one.stop_on_violation != other.stop_on_violation:
        return None
    numbers: Numbers = {}
    mine, theirs = vars(one), vars(other)
    if any(mine[name] != theirs[name] for name in WHOLE):
        return None
    for name in PARTS:
        here, there = mine[name], theirs[name]
        if here is not there and not _alike(here, there, (name,), numbers):
            return None
    if any(map(is_in_formula, numbers)) and not _equal_alike(one, other):
        return None
    if len(one.frictions) > 1 and any(place[-1] in STEADY for place in numbers):
        return None
    return numbers


def settings(scene: Scene) -> tuple[int | None, str, int, float]:
    """Dependence of rows on other things than parts: on which body a motor is, and how the scene is run."""
    return scene.motor.on if scene.motor else None, scene.method, scene.order, scene.tol


def _alike(one: Any, other: Any, place: Place, numbers: Numbers) -> bool:
    """Whether two parts are of one form; adds to the numbers that differ."""
    if one is other:
        return True
    if type(one) is not type(other):
        return False
    if isinstance(one, float):
        if same_bits(one, other):
            return True
        numbers[place] = other
        return bool((one > 0) == (other > 0) and (one < 0) == (other < 0))
    if isinstance(one, tuple):
        if len(one) != len(other):
            return False
        return all(_alike(part, other[i], (*place, i), numbers) for i, part in enumerate(one))
    if isinstance(one, PLAIN):
        return bool(one == other)
    if isinstance(one, Friction) and any(one.drops(sense) != other.drops(sense) for sense in (1, -1)):
        return False
    if place[0] == "base" and any(
        not same_bits(getattr(one, name), getattr(other, name)) for name in FREE[Harmonic]
    ):
        return False
    mine, theirs = vars(one), vars(other)
    for name in _names(one.__class__):
        here, there = mine[name], theirs[name]
        if here is there or (isinstance(here, float) and same_bits(here, there)):
            continue
        if name in FORMULAS:
            if not _same_form(here, there, (*place, name), numbers):
                return False
        elif not _alike(here, there, (*place, name), numbers):
            return False
    return True


def _same_form(one: Any, other: Any, place: Place, numbers: Numbers) -> bool:
    """Whether two formulas, or several, differ in nothing but numbers of the same sign; adds to these."""
    if one is other:
        return True
    if not (isinstance(one, tuple) and isinstance(other, tuple)):
        return bool(one == other)
    if len(one) != len(other):
        return False
    if one[:1] == ("num",) == other[:1]:
        a, b, here = one[1], other[1], (*place, 1)
        if a != b:
            numbers[here] = b
        return bool((a > 0) == (b > 0) and (a < 0) == (b < 0))
    return all(_same_form(part, other[i], (*place, i), numbers) for i, part in enumerate(one))


def _equal_alike(one: Scene, other: Scene) -> bool:
    """Whether numbers in formulas of two scenes, of one form, are equal but for signs where those of the
    other one are: so that equal parts of formulas are.
    """
    theirs: dict[Fraction, Fraction] = {}
    pairs = zip(_formulas(one), _formulas(other), strict=True)
    for a, b in chain.from_iterable(map(_paired_numbers, *zip(*pairs, strict=True))):
        if theirs.setdefault(abs(a), abs(b)) != abs(b):
            return False
    return len(set(theirs.values())) == len(theirs)


def _formulas(scene: Scene) -> Iterator[Any]:
    """The formulas of all parts, in their order."""
    for name in PARTS:
        for part in vars(scene)[name]:
            yield from (one for field in FORMULAS if (one := getattr(part, field, None)))


def _paired_numbers(one: Any, other: Any) -> Iterator[tuple[Fraction, Fraction]]:
    """The numbers in two formulas of one form."""
    if not isinstance(one, tuple):
        return
    if one[:1] == ("num",):
        yield one[1], other[1]
        return
    for part, there in zip(one, other, strict=True):
        yield from _paired_numbers(part, there)


def same_bits(one: float, other: float) -> bool:
    """Whether two doubles are the same: 0.0 is not -0.0 here."""
    return one == other and (one != 0 or copysign(1.0, one) == copysign(1.0, other))


@cache
def _names(kind: Any) -> tuple[str, ...]:
    """The fields of a part that rows are made of."""
    return tuple(each.name for each in fields(kind) if each.name not in FREE.get(kind, ()))


def with_number(part: Any, place: Sequence[str | int], number: Any) -> Any:
    """A scene, or a part of one, with another number in a place."""
    here, *inner = place
    if isinstance(part, tuple):
        assert isinstance(here, int)
        return (*part[:here], with_number(part[here], inner, number), *part[here + 1 :])
    assert isinstance(here, str)
    return replace(part, **{here: with_number(getattr(part, here), inner, number) if inner else number})
