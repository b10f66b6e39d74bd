"""Ramps: a number of a case that goes evenly from one value to another while a run goes on.

A ramp of Omega0 from 3 Hz to 7 Hz over 400 s is the formula

    Omega0_from + (Omega0_to - Omega0_from)*min(t/Omega0_over, 1)

with the three numbers beside it; with a way back, another 400 s follow. What stands in place of a number that
formulas name, such as a voltage in the rate of a current, replaces its name in them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise
from math import pi
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibsim.cases.any_unit import any_quantity
from vibsim.cases.formula_keys import FORMULA_KEYS, ONE_PART, SIDES, Formula
from vibsim.cases.problems import did_you_mean, shown
from vibsim.cases.quantities import Quantity, QuantityError, decimal_text, exact_number
from vibsim.cases.schema_keys import UnknownKeyError, all_keys, form_of, keys_of
from vibsim.cases.schema_kinds import Measured

if TYPE_CHECKING:
    from vibsim.cases.case import Case
    from vibsim.cases.formula_places import FormulaPlace

FEWEST, MOST = 2, 3  # values of a ramp: from, to, and the one that it goes back to
EXAMPLE = "KEY=FROM:TO or KEY=FROM:TO:BACK, such as Omega0=3:7Hz"


class Ramp(NamedTuple):
    """A ramp as the user gave it: key, and the texts of its values."""

    key: str
    values: tuple[str, ...]


def read_ramp(key: str, text: str) -> Ramp:
    """A ramp from its text: the last unit is that of all values without one. Raises ValueError."""
    values = [value.strip() for value in text.split(":")]
    if not FEWEST <= len(values) <= MOST or not all(values):
        raise ValueError(f"{shown(text)} is not FROM:TO or FROM:TO:BACK, such as 3:7Hz")
    try:
        units = [any_quantity(value)[0].text.partition(" ")[2] for value in values]
    except QuantityError as error:
        raise ValueError(f"{shown(text)}: {error}") from None
    whole = [
        value if unit else f"{value} {units[-1]}".strip() for value, unit in zip(values, units, strict=True)
    ]
    for before, after in pairwise(whole):
        if any_quantity(before)[0][1:] == any_quantity(after)[0][1:]:
            raise ValueError(
                f"{shown(text)} goes from a value to the same; give that value to the key itself"
            )
    return Ramp(key, tuple(whole))


def ramped(case: Case, ramps: Iterable[Ramp], over: str) -> Case:
    """The case with ramps, each way of which takes the time `over`.

    Raises ValueError for a time that is none, for keys that no ramp can have and for values that a key does
    not take, CaseError for what the case makes of them.
    """
    check_time(over)
    done: set[str] = set()
    for ramp in ramps:
        try:
            key = case.full_key(ramp.key)
        except UnknownKeyError as error:
            raise ValueError(f"{ramp.key}: {error}") from None
        if key in done:
            raise ValueError(f"{key} is given two ramps; choose one")
        done.add(key)
        case = case.with_values(_changes(case, key, ramp, over))
    return case


def end_of(ramps: Iterable[Ramp], over: str) -> str:
    """The time at which the last of some ramps is done, as a text."""
    time = check_time(over)
    ways = max(len(ramp.values) for ramp in ramps) - 1
    number, _, unit = time.text.partition(" ")
    return time.text if ways == 1 else f"{decimal_text(exact_number(number) * ways)} {unit}".strip()


def check_time(text: str) -> Quantity:
    """The time that a way of a ramp takes. Raises ValueError for what is no time above 0."""
    try:
        time = Measured("time", above="0").read(text)
    except QuantityError as error:
        raise ValueError(f"over {error}") from None
    assert isinstance(time, Quantity)
    return time


def _changes(case: Case, key: str, ramp: Ramp, over: str) -> dict[str, object]:
    """Changes as `--set` would take them: formulas and the numbers beside them."""
    if _takes_formula(case._nested, key):
        _check_values(case, key, ramp)
        part, _, name = key.rpartition(".")
        return {key: Formula(_course(name, len(ramp.values))), **_numbers(part, name, ramp, over)}
    places = _places_naming(case, key)
    if not places:
        raise ValueError(f"{key} takes no formula{_instead(case, ramp.key)}")
    _check_values(case, key, ramp)
    name = key.rpartition(".")[2]
    changed = {place.path: Formula(_replaced(place.text, name, len(ramp.values))) for place in places}
    return {**changed, **_numbers(key.rpartition(".")[0], name, ramp, over)}


def _takes_formula(values: Mapping[str, object], key: str) -> bool:
    section, *names = key.split(".")
    depth = len(names) - (section not in ONE_PART)
    one = depth == 1 or (depth == 2 and names[-2] in SIDES.get(section, ()))
    if not one or all(formula.key != names[-1] for formula in FORMULA_KEYS.get(section, ())):
        return False
    form = form_of(values)
    measured = all_keys(form).get(form.pattern(key))
    return measured is None or measured.formula


def _instead(case: Case, key: str) -> str:
    """Which keys of a case can have a ramp."""
    values = case._nested
    every = keys_of(form_of(values), values)
    taking = [one for one in every if one in case.values and _takes_formula(values, one)]
    named = [one for one in case.numeric_keys() if one not in taking and _places_naming(case, one)]
    listed = [*taking, *named]
    if not listed:
        return ", nor does any number of this case"
    return f"{did_you_mean(key, listed)}; here these can have a ramp: {', '.join(listed)}"


def _check_values(case: Case, key: str, ramp: Ramp) -> None:
    """Raises ValueError for a value of another unit, or one that the key does not take."""
    values = case._nested
    form = form_of(values)
    known = all_keys(form).get(form.pattern(key))
    for text in ramp.values:
        try:
            if key in case.values and isinstance(case.values[key], Quantity):
                measured = case.measured(key)
                assert measured is not None
                measured._replace(formula=False).read(text)
            elif known is not None:
                known._replace(formula=False).read(text)
        except QuantityError as error:
            raise ValueError(f"{key}: {error}") from None


def _course(name: str, count: int) -> str:
    """The formula of a ramp of so many values."""
    start, end, back, over = (f"{name}_{word}" for word in ("from", "to", "back", "over"))
    there = f"{start} + ({end} - {start})*min(t/{over}, 1)"
    return there if count == FEWEST else f"{there} + ({back} - {end})*min(max(t/{over} - 1, 0), 1)"


def _numbers(part: str, name: str, ramp: Ramp, over: str) -> dict[str, object]:
    words = ("from", "to", "back")
    given = {f"{part}.{name}_{word}": value for word, value in zip(words, ramp.values, strict=False)}
    return {**given, f"{part}.{name}_over": over}


# Numbers that formulas name.


def _places_naming(case: Case, key: str) -> list[FormulaPlace]:
    """The formulas that read the number at a key: beside it, or all that a parameter is not hidden from."""
    from vibsim.cases.formula_places import FormulaScene, places_of
    from vibsim.cases.formula_text import names_in

    part, _, name = key.rpartition(".")
    if not isinstance(case.values.get(key), Quantity):
        return []
    scene = FormulaScene(case._nested)
    found = []
    for place in places_of(case._nested):
        if name not in names_in(place.text):
            continue
        beside = name in scene.numbers_beside(place)
        if place.part == part or (part == "parameters" and not beside):
            found.append(place)
    return found


def _replaced(text: str, name: str, count: int) -> str:
    """A formula with the course of a ramp in place of a name."""
    from vibsim.cases.formula_text import parsed, walk

    names = [term for term in walk(parsed(text)) if term.kind == "name" and term.value == name]
    spots = sorted({(term.start, term.end) for term in names})
    for start, end in reversed(spots):
        text = f"{text[:start]}({_course(name, count)}){text[end:]}"
    return text


# What a ramp comes to.


def no_load_speed(case: Case, times: np.ndarray) -> np.ndarray | None:
    """No-load speed Omega0 of the motor [Hz] at times [s]; None without a motor that has one by numbers and
    the time alone.
    """
    values = case._nested
    section = "excitation" if "excitation" in values else "motor"
    content = values.get(section)
    source = content if isinstance(content, Mapping) else {}
    value = source.get("Omega0")
    if value is None or "torque" in source:
        return None
    if isinstance(value, Quantity):
        return np.full(np.shape(times), value.number() / (2 * pi))
    from vibsim.cases.formula_places import FormulaScene, places_of
    from vibsim.physics.formula_values import values_of
    from vibsim.physics.formulas import TIME, reads

    place = next(one for one in places_of(values) if one.path == f"{section}.Omega0")
    node = FormulaScene(values).node(place)
    if reads([node], ("x", "v", "phi", "w")):
        return None
    return np.broadcast_to(values_of(node, {TIME: times}), np.shape(times)) / (2 * pi)
