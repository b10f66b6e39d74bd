"""Ramps: a number of a case that goes evenly from one value to another while a run goes on.

A ramp of Omega0 from 3 Hz to 7 Hz over 400 s is the formula

    Omega0_from + (Omega0_to - Omega0_from)*min(t/Omega0_over, 1)

with the three numbers beside it; with a way back, another 400 s follow. What stands in place of a number that
formulas name, such as a voltage in the rate of a current, replaces its name in them.

A number of a built-in law has a ramp in the formula that says the same: k d + c v of a link, or
A sin(omega t + phase) of a force, where the integral of omega takes the place of omega t.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise
from math import pi
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibsim.cases.any_unit import any_quantity
from vibsim.cases.problems import did_you_mean, shown
from vibsim.cases.quantities import Quantity, QuantityError, decimal_text, exact_number
from vibsim.cases.schema_keys import UnknownKeyError, all_keys, form_of, keys_of
from vibsim.cases.schema_kinds import FORMULA_KEYS, ONE_PART, SIDES, Formula, Measured

if TYPE_CHECKING:
    from vibsim.cases.case import Case
    from vibsim.cases.formula_places import FormulaPlace

FEWEST, MOST = 2, 3  # values of a ramp: from, to, and the one that it goes back to


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
    ramps, done = [*ramps], set[str]()
    for ramp in ramps:
        key = _full_key(case, ramp)
        if key in done:
            raise ValueError(f"{key} is given two ramps; choose one")
        done.add(key)
    for ramp in sorted(ramps, key=lambda one: not one.key.endswith(FREQUENCY)):
        case = _ramped(case, _full_key(case, ramp), ramp, over)
    return case


def _full_key(case: Case, ramp: Ramp) -> str:
    try:
        return case.full_key(ramp.key)
    except UnknownKeyError as error:
        raise ValueError(f"{ramp.key}: {error}") from None


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


def _ramped(case: Case, key: str, ramp: Ramp, over: str) -> Case:
    """The case with one ramp."""
    _check_values(case, key, ramp)
    count = len(ramp.values)
    if not _takes_formula(case._nested, key) and not _places_naming(case, key):
        of_law = _with_law_written(case, key)
        if of_law is None:
            raise ValueError(f"{key} takes no formula{_instead(case, ramp.key)}")
        case, key = of_law
    part, _, name = key.rpartition(".")
    changes: dict[str, object] = {}
    if _takes_formula(case._nested, key):
        changes[key] = Formula(_course(name, count))
    for place in _places_naming(case, key):
        text = place.text.replace(PHASE, f"{_angle(count)} + phase") if name == FREQUENCY else place.text
        changes[place.path] = Formula(_replaced(text, name, count))
    return case.with_values({**changes, **_numbers(part, name, ramp, over)})


# Built-in laws as formulas.


FREQUENCY = "omega"
PHASE = "omega*t + phase"
# parts of the short form in the long one
LONG_KEYS = {
    "coupling.k1": "links.coupling.k",
    "coupling.c": "links.coupling.c",
    "stop.k2": "stops.stop.k",
    "friction.mu": "friction.friction.mu",
    **{f"excitation.{name}": f"forces.excitation.{name}" for name in ("A", FREQUENCY, "F0")},
}


def _with_law_written(case: Case, key: str) -> tuple[Case, str] | None:
    """The case in the long form with the law of a part as a formula that names the number at `key`, and the
    key there; None where no formula says the same.
    """
    from vibsim.cases.case import load_case_text

    if not case.is_long:
        key = LONG_KEYS.get(key, "")
        case = load_case_text(case.long_text(), name=case.source)
    part, _, name = key.rpartition(".")
    if not isinstance(case.values.get(key), Quantity):
        return None
    if _takes_formula(case._nested, key):
        return case, key
    formula = _formula_of_law(case, part, name)
    return None if formula is None else (case.with_values(formula), key)


def _formula_of_law(case: Case, part: str, name: str) -> dict[str, object] | None:
    """The formula of a part whose law has the number `name`, and the numbers that are new beside it."""
    section = part.partition(".")[0]
    values = case.values
    if section == "links" and name in ("k", "c"):
        return {f"{part}.force": Formula("k*d + c*v")}
    if section == "stops" and name in ("k", "c"):
        return {f"{part}.force": Formula("k*p + c*pv")}
    if section not in ("forces", "base") or f"{part}.omega" not in values or name == "phase":
        return None
    size = "a" if section == "base" else "A"
    wave = f"{size}*sin({PHASE})"
    if section == "base":
        return {f"{part}.x": Formula(wave)}
    rule = {
        f"{part}.{one}": str(values[f"{part}.A.{one}"]) for one in ("m3", "e") if f"{part}.A.{one}" in values
    }
    return {f"{part}.force": Formula(f"F0 + {f'm3*e*omega**2*sin({PHASE})' if rule else wave}"), **rule}


def _angle(count: int) -> str:
    """The integral of the course of omega over the time."""
    start, end, back, over = (f"{FREQUENCY}_{word}" for word in ("from", "to", "back", "over"))
    there = f"{start}*t + ({end} - {start})*(min(t, {over})**2/(2*{over}) + max(t - {over}, 0))"
    if count == FEWEST:
        return there
    late = f"max(t - {over}, 0)"
    return f"{there} + ({back} - {end})*(min({late}, {over})**2/(2*{over}) + max(t - 2*{over}, 0))"


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
    """Keys of a case that can have a ramp."""
    values = case._nested
    every = keys_of(form_of(values), values)
    taking = [one for one in every if one in case.values and _takes_formula(values, one)]
    named = [one for one in case.numeric_keys() if one not in taking and _can_be_named(case, one)]
    listed = [*taking, *named]
    if not listed:
        return ", nor does any number of this case"
    return f"{did_you_mean(key, listed)}; here these can have a ramp: {', '.join(listed)}"


def _can_be_named(case: Case, key: str) -> bool:
    """Whether formulas name a number, or one that says the same as its law would."""
    return bool(_places_naming(case, key)) or _with_law_written(case, key) is not None


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


def drive_frequency(case: Case, times: np.ndarray) -> np.ndarray | None:
    """Frequency [Hz] of the force or base that a ramp of omega drives, at times [s]; None without one."""
    course = _course_of_drive(case)
    if course is None:
        return None
    values, over = course
    shares = [np.clip(times / over - i, 0, 1) for i in range(len(values) - 1)]
    steps = [(b - a) * share for (a, b), share in zip(pairwise(values), shares, strict=True)]
    return np.asarray(sum(steps, np.full(np.shape(times), values[0])) / (2 * pi))


def drive_turns(case: Case, times: np.ndarray) -> np.ndarray | None:
    """Periods that such a drive has made at times [s]: the integral of its frequency."""
    course = _course_of_drive(case)
    if course is None:
        return None
    values, over = course
    angle = values[0] * times
    for i, (a, b) in enumerate(pairwise(values)):
        since = np.maximum(times - i * over, 0)
        angle = angle + (b - a) * (np.minimum(since, over) ** 2 / (2 * over) + np.maximum(since - over, 0))
    return np.asarray(angle / (2 * pi))


def _course_of_drive(case: Case) -> tuple[list[float], float] | None:
    """The angular rates of a ramp of omega [rad/s], and the time that each way takes [s]."""
    parts = [*case._nested.get("forces", {}).values(), case._nested.get("base", {})]
    for part in parts:
        if f"{FREQUENCY}_over" in part:
            names = [f"{FREQUENCY}_{word}" for word in ("from", "to", "back")]
            return [part[name].number() for name in names if name in part], part[f"{FREQUENCY}_over"].number()
    return None


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
