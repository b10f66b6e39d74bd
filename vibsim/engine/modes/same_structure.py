"""Whether the modes of two scenes differ in nothing but their numbers, and which numbers those are.

Rows hold numbers of the parts, but none of a motor and no frequency or phase of a force. Where every other
number has the same sign in both scenes, and frictions that drop as they begin to slip do so in both, rows and
rules of a mode have the same form.
"""

from collections.abc import Sequence
from dataclasses import fields, replace
from functools import cache
from math import copysign
from typing import Any

from vibsim.physics.parts import Body, Clearance, Friction, Harmonic, RigidStop, Scene, Stop

Place = tuple[str | int, ...]  # names of fields and numbers of parts, from the scene to the number
Numbers = dict[Place, float]

PARTS = ("bodies", "links", "stops", "frictions", "forces", "base", "clearances")
FREE = {  # what no row holds
    Body: ("x", "v"),
    Stop: ("at_start",),
    RigidStop: ("at_start",),
    Clearance: ("at_start",),
    Harmonic: ("omega", "cycles", "cycles_lo", "phase"),
}
PLAIN = (str, int, type(None))
FORMULAS = ("force", "formula", "slips", "holds")  # fields of formulas: of one form where they are equal
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
            if here != there:
                return False
        elif not _alike(here, there, (*place, name), numbers):
            return False
    return True


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
