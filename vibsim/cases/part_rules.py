"""All rules of the long form that concern several keys at once."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from vibsim.cases.part_laws import (
    COULOMB,
    coefficients_fit_the_law,
    friction_falls,
    starts_are_outside,
    stops_have_their_law,
)
from vibsim.cases.problems import did_you_mean, shown
from vibsim.cases.quantities import Quantity, product_fits, si_unit
from vibsim.cases.schema_keys import MIXED, Form, all_keys
from vibsim.cases.schema_kinds import has_formula, of_part, sides_of
from vibsim.cases.short_form import BASE, CALLED, NO_BODIES, PARTS, Draft, Ends, FoundDefault
from vibsim.physics.parts import columns_of

# Rules for what parts are tied to: bodies that exist, ground, and base where there is one.


def ends_exist(draft: Draft) -> Iterator[FoundDefault]:
    """Each end is a body, ground or base."""
    allowed = [*(name for name in draft.bodies if name not in NO_BODIES), *NO_BODIES]
    for key, ends in draft.ends() if draft.bodies else ():
        for position, end in enumerate((ends.P, ends.Q), start=1):
            if end not in allowed:
                message = f"no body {shown(end)}{did_you_mean(end, allowed)}; allowed: {', '.join(allowed)}"
                yield FoundDefault(f"{key}.between", message, at=f"{key}.between.{position}")


def ends_differ(draft: Draft) -> Iterator[FoundDefault]:
    """A part joins two different ends, and one of them is a body."""
    for key, ends in draft.ends():
        if ends.P == ends.Q:
            message = f"joins {ends.P} to itself; a part needs two different ends"
            yield FoundDefault(f"{key}.between", message)
        elif {ends.P, ends.Q} == set(NO_BODIES):
            message = f"joins {ends.P} to {ends.Q}; at least one end must be a body"
            yield FoundDefault(f"{key}.between", message)


def base_is_there(draft: Draft) -> Iterator[FoundDefault]:
    """Parts end at base where base moves, and only then."""
    tied = [key for key, ends in draft.ends() if BASE in (ends.P, ends.Q)]
    if "base" not in draft.values:
        for key in tied:
            message = "ends at base, and the case has none; give base: {a: ..., omega: ...}, or write ground"
            yield FoundDefault(f"{key}.between", message)
    elif not tied:
        yield FoundDefault("base", "no part ends at base; tie one to it, or leave base out", of_the_name=True)


def loads_act_on_bodies(draft: Draft) -> Iterator[FoundDefault]:
    """Forces and the motor act on a body."""
    for key, part in [*draft.parts("forces", "rotors"), ("motor", draft.section("motor"))]:
        on = part.get("on")
        if isinstance(on, str) and draft.bodies and on not in draft.bodies:
            allowed = ", ".join(draft.bodies)
            message = f"must be a body, got {shown(on)}{did_you_mean(on, draft.bodies)}; allowed: {allowed}"
            yield FoundDefault(f"{key}.on", message)


def states_exist(draft: Draft) -> Iterator[FoundDefault]:
    """States at t = 0 are those of bodies and rotors, and of the rotor of the motor under the name motor."""
    rotors = draft.section("rotors")
    for key, part in draft.parts("initial"):
        name = key.partition(".")[2]
        if name == "motor":
            yield from _states_of_rotor(draft, part)
        elif name in rotors:
            yield from _foreign(key, part, ("x", "v", "phidot"), "a rotor has phi and w")
        elif name in draft.section("states"):
            yield FoundDefault(key, f"a state begins at states.{name}.start", of_the_name=True)
        elif draft.bodies and name not in draft.bodies:
            allowed = [*draft.bodies, *rotors, *(["motor"] if "motor" in draft.values else [])]
            message = f"no body {shown(name)}{did_you_mean(name, allowed)}; allowed: {', '.join(allowed)}"
            yield FoundDefault(key, message, of_the_name=True)
        else:
            yield from _foreign(key, part, ("phi", "phidot"), "belongs to initial.motor; a body has x and v")
            yield from _foreign(key, part, ("w",), "belongs to a rotor; a body has x and v")


def _foreign(
    key: str, part: dict[str, object], states: Iterable[str], message: str
) -> Iterator[FoundDefault]:
    for state in states:
        if state in part:
            yield FoundDefault(f"{key}.{state}", message, of_the_name=True)


def _states_of_rotor(draft: Draft, part: dict[str, object]) -> Iterator[FoundDefault]:
    """The rotor has phi and phidot; without a motor an exact 0 says nothing and is let through."""
    for state in part:
        key = f"initial.motor.{state}"
        quantity = draft.quantity(key)
        if state in ("x", "v"):
            message = "the rotor has phi and phidot; x and v are those of the body under it"
            yield FoundDefault(key, message, of_the_name=True)
        elif state == "w":
            yield FoundDefault(key, "the rotor of the motor has phi and phidot", of_the_name=True)
        elif "motor" not in draft.values and quantity is not None and quantity.value != 0:
            yield FoundDefault(key, f"there is no motor, so it must be left out, got {quantity}")


def rotors_have_inertia(draft: Draft) -> Iterator[FoundDefault]:
    """J + m e^2 > 0; and M0 and Omega0 come together, in place of a torque."""
    for key, part in draft.parts("rotors"):
        inertia = draft.quantity(f"{key}.J")
        unbalance = [draft.quantity(f"{key}.{name}") for name in ("m", "e")]
        readable = all(name not in part or draft.quantity(f"{key}.{name}") for name in ("J", "m", "e"))
        if readable and not (inertia and inertia.value) and not all(one and one.value for one in unbalance):
            message = "has no inertia: give J, or m and e that are not 0"
            yield FoundDefault(key, message, of_the_name=True)
        pair = [name for name in ("M0", "Omega0") if name in part]
        if len(pair) == 1 and not has_formula("rotors", part, "torque"):
            other = "Omega0" if pair == ["M0"] else "M0"
            yield FoundDefault(f"{key}.{pair[0]}", f"{other} is missing", of_the_name=True)
        M0, Omega0 = (draft.quantity(f"{key}.{name}") if name in pair else None for name in ("M0", "Omega0"))
        if Omega0 and not Omega0.value:
            yield FoundDefault(
                f"{key}.Omega0", "must not be 0; leave it and M0 out of a rotor without a motor"
            )
        elif M0 and Omega0 and M0.value * Omega0.value < 0:
            message = (
                f"M0 and Omega0 must have one sign, got {M0} and {Omega0}: the motor drives up to Omega0"
            )
            yield FoundDefault(f"{key}.M0", message)


def bodies_turn_alike(draft: Draft) -> Iterator[FoundDefault]:
    """A torsional scene has no rotors and no weight: what turns in it are its bodies."""
    if not draft.torsional:
        return
    for section in ("rotors", "motor"):
        if section in draft.values:
            message = (
                "an unbalanced rotor sits on a body that moves along a line, and the bodies of this scene "
                "turn; write its torque as a force on a body"
            )
            yield FoundDefault(section, message, of_the_name=True)
    for key, part in draft.parts("friction"):
        if "N" not in part and not has_formula("friction", part, "mu"):
            message = "needs N, the torque that mu is multiplied with, in a scene of bodies that turn"
            yield FoundDefault(key, message, of_the_name=True)
        elif "N" not in part:
            yield FoundDefault(key, "needs N in a scene of bodies that turn", of_the_name=True)


def parts_join_alike(draft: Draft) -> Iterator[FoundDefault]:
    """Where some bodies turn and others move along a line: no part joins one to the other, the numbers of a
    part are those of its bodies, rotors sit on bodies that move along the line.
    """
    if not draft.mixed:
        return
    for key, ends in draft.ends():
        joined = [end for end in (ends.P, ends.Q) if end in draft.bodies]
        turning = [end for end in joined if draft.turns(end)]
        still = [end for end in (ends.P, ends.Q) if end not in turning and (end in joined or end == BASE)]
        if turning and still:
            message = (
                f"{turning[0]} turns and {still[0]} moves along a line; what they do to each other are "
                f"forces with formulas, one on each"
            )
            yield FoundDefault(f"{key}.between", message)
        else:
            yield from _of_one_kind(draft, key, bool(turning))
            if key.startswith("friction.") and turning and "N" not in draft.section(*key.split(".")):
                yield FoundDefault(key, "needs N, the torque that mu is multiplied with", of_the_name=True)
    for key, part in draft.parts("forces"):
        yield from _of_one_kind(draft, key, draft.turns(str(part.get("on"))))
    for body in draft.bodies:
        yield from _of_one_kind(draft, f"initial.{body}", draft.turns(body))
    for key, part in [*draft.parts("rotors"), ("motor", draft.section("motor"))]:
        if draft.turns(str(part.get("on"))):
            message = "an unbalanced rotor sits on a body that moves along a line, and this one turns"
            yield FoundDefault(f"{key}.on", message)


def _of_one_kind(draft: Draft, key: str, turns: bool) -> Iterator[FoundDefault]:
    """The numbers of a part that are of turning bodies where its own do not turn, or the other way round."""
    from vibsim.cases.any_unit import dimension_of, dimension_of_name

    section = key.partition(".")[0]
    free = {name for one in of_part(section, draft.section(*key.split("."))) for name in one.numbers}
    known = all_keys(MIXED)
    for path, value in draft.flat.items():
        measured = known.get(MIXED.pattern(path)) if path.startswith(f"{key}.") else None
        if measured is None or not measured.also or path.rpartition(".")[2] in free:
            continue
        name = measured.also if turns else measured.dimension
        if isinstance(value, Quantity) and value.value and dimension_of(value) != dimension_of_name(name):
            kind = "turning bodies" if turns else "bodies on a line"
            message = f"must be {_article(name)} in {si_unit(name).name}, of a part of {kind}, got {value}"
            yield FoundDefault(path, message)


def _article(name: str) -> str:
    return f"{'an' if name[0] in 'aeiou' else 'a'} {name}"


# Rules for what a part needs, and for keys that stand in place of one another.


MOST_COLUMNS = 4000  # notes of 16 bytes each on the scale of a table, in an attribute of 64 kB


def there_is_a_body(draft: Draft) -> Iterator[FoundDefault]:
    if draft.values.get("bodies") == {}:
        yield FoundDefault("bodies", "a scene needs at least one body, such as {ram: 2 kg}", of_the_name=True)


def a_file_has_room(draft: Draft) -> Iterator[FoundDefault]:
    """A result file holds MOST_COLUMNS of a table: what HDF5 can note at one scale."""
    bodies, parts = len(draft.bodies), sum(1 for _ in draft.parts("stops", "friction", "clearances"))
    rigid = any(part.get("law") == "rigid" for _, part in draft.parts("stops"))
    moving = bodies + len(draft.section("rotors"))
    columns = (3 if rigid else 2) * moving + parts + len(draft.section("states"))
    if columns > MOST_COLUMNS:
        message = (
            f"{bodies} bodies and their stops, frictions and clearances make {columns} columns; "
            f"a result file has room for {MOST_COLUMNS}"
        )
        yield FoundDefault("bodies", message, of_the_name=True)


def links_do_something(draft: Draft) -> Iterator[FoundDefault]:
    for key, part in draft.parts("links"):
        if not {"k", "c", "force"} & set(part):
            yield FoundDefault(key, "a link needs k, c or both", of_the_name=True)


def friction_has_a_load(draft: Draft) -> Iterator[FoundDefault]:
    """N, or the weight m g of the first end."""
    for key, part in draft.parts("friction"):
        ends = Ends.read(part.get("between"))
        if has_formula("friction", part, "N"):
            continue
        if "N" in part and "g" in part:
            yield FoundDefault(f"{key}.g", "the load is N, so g must be left out", of_the_name=True)
        elif "N" not in part and ends is not None and ends.P in NO_BODIES and ends.Q not in NO_BODIES:
            message = (
                f"the load m g is that of the first end, and {ends.P} is no body; give N, or write "
                f"{ends.Q} first"
            )
            yield FoundDefault(f"{key}.between", message)


def sources_are_harmonic(draft: Draft) -> Iterator[FoundDefault]:
    """A and omega (a and omega of base), or terms; a force may be F0 alone."""
    for key, part in draft.parts("forces"):
        if "force" not in part:
            yield from _harmonic(key, part, "A", bool("F0" in part))
    if isinstance(draft.values.get("base"), dict) and "x" not in draft.section("base"):
        yield from _harmonic("base", draft.section("base"), "a", False)


def _harmonic(key: str, part: dict[str, Any], amplitude: str, constant: bool) -> Iterator[FoundDefault]:
    single = [name for name in (amplitude, "omega", "phase") if name in part]
    if "terms" in part:
        if single:
            message = f"terms has the harmonics, so {' and '.join(single)} must be left out"
            yield FoundDefault(f"{key}.{single[0]}", message, of_the_name=True)
        if isinstance(part["terms"], dict) and list(part["terms"]) != _numbers(part["terms"]):
            example = f"[{{{amplitude}: ..., omega: ...}}]"
            message = f"must be a list of harmonics, such as {example}"
            yield FoundDefault(f"{key}.terms", message, of_the_name=True)
    elif not single and not constant:
        required = f"{amplitude} and omega, or terms" + (", or F0" if amplitude == "A" else "")
        yield FoundDefault(key, f"needs {required}", of_the_name=True)
    elif single:
        for name in (amplitude, "omega"):
            if name not in part:
                yield FoundDefault(key, f"{single[0]} is given and {name} is missing", of_the_name=True)


def _numbers(terms: dict[str, Any]) -> list[str]:
    return [str(i + 1) for i in range(max(1, len(terms)))]


def closed_form_is_there(draft: Draft) -> Iterator[FoundDefault]:
    laws = {key: part.get("law", COULOMB) for key, part in draft.parts("friction")}
    falling = [key for key, law in laws.items() if law != COULOMB]
    if draft.flat.get("run.method") != "closed_form":
        return
    allowed = "run.method must be auto or taylor, got closed_form"
    if "motor" in draft.values:
        yield FoundDefault("run.method", f"a motor has no closed form; with one, {allowed}")
    elif formula := next(_formulas(draft), None):
        yield FoundDefault("run.method", f"{formula} is a formula and has no closed form; {allowed}")
    elif falling:
        yield FoundDefault("run.method", f"{falling[0]} falls with speed and has no closed form; {allowed}")


def _formulas(draft: Draft) -> Iterator[str]:
    """Dotted keys of the parts with formulas, and of what always has some."""
    for section in ("links", "stops", "friction", "forces", "states", "rotors"):
        for key, part in draft.parts(section):
            if section in ("states", "rotors") or of_part(section, part) or sides_of(section, part):
                yield key
    if of_part("base", draft.section("base")):
        yield "base"


def products_fit(draft: Draft) -> Iterator[FoundDefault]:
    """Problems of values computed from several others: they must fit a double too."""
    for key, name, factors in _products(draft):
        known = [factor for factor in factors if factor is not None]
        if len(known) == len(factors) and not product_fits(known):
            yield FoundDefault(
                key, f"{name} does not fit double precision (2.3e-308 to 2.2e307)", of_the_name=True
            )


def _products(draft: Draft) -> Iterator[tuple[str, str, list[Quantity | None]]]:
    for key, part in draft.parts("friction"):
        if has_formula("friction", part, "mu"):
            continue
        ends = Ends.read(part.get("between"))
        load = [draft.quantity(f"{key}.N")]
        if "N" not in part:
            mass = draft.quantity(f"bodies.{ends.P}") if ends else None
            load = [mass, *([draft.quantity(f"{key}.g")] if "g" in part else [])]
        for side in (key, f"{key}.plus", f"{key}.minus"):
            mu, ratio = draft.quantity(f"{side}.mu"), draft.quantity(f"{side}.static")
            yield key, "the limit force mu N", [mu, *load]
            yield key, "the limit force static mu N", [mu, ratio, *load]
            for name in ("mu_s", "mu_d"):
                yield key, f"the force {name} N", [draft.quantity(f"{side}.{name}"), *load]
    for key, part in draft.parts("forces"):
        if "force" in part:
            continue
        for term in [key, *(f"{key}.terms.{number}" for number in _dict(part.get("terms")))]:
            omega = draft.quantity(f"{term}.omega")
            rule = [draft.quantity(f"{term}.A.{name}") for name in ("m3", "e")]
            yield f"{term}.A", "m3 e omega^2", [*rule, omega, omega]
    motor = [draft.quantity(f"motor.{name}") for name in ("m3", "e", "e")]
    yield "motor", "m3 e^2", motor


def _dict(value: object) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


# Rules for the names of bodies and parts: they become columns of a file and words of a command.


LONGEST = 24  # characters: x_NAME stays a variable name in MATLAB
WORDS = (*NO_BODIES, "motor", "none")  # with a meaning of their own
# columns and groups of files, whether a file has them or not
COLUMNS = (
    "time",
    "t",
    "kind",
    "part",
    "phi",
    "phidot",
    "phase",
    "before_phidot",
    "contact",
    "error_estimate",
)
GROUPS = ("events", "digits", "orbit")
_BODY = re.compile(r"[A-Za-z0-9][A-Za-z0-9_]*", re.ASCII)
_PART = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)


def names_are_names(draft: Draft) -> Iterator[FoundDefault]:
    """Letters, digits and _; a body may be called by a number."""
    for section in CALLED:
        pattern, first = (_BODY, "letter or digit") if section == "bodies" else (_PART, "letter")
        for name in draft.section(section):
            key = f"{section}.{name}"
            if not pattern.fullmatch(name) or len(name) > LONGEST:
                message = (
                    f"the name of a {CALLED[section]} may hold letters, digits and _, begins with a {first} "
                    f"and has at most {LONGEST} characters; got {shown(name)}"
                )
                yield FoundDefault(key, message, of_the_name=True)
            elif name in WORDS:
                message = (
                    f"the name is taken by an end or a part; so are {_others(name, WORDS)}; choose another"
                )
                yield FoundDefault(key, message, of_the_name=True)
            elif section == "states" and _is_in_formulas(name):
                what = "the number pi" if name == "pi" else "a function"
                message = f"the name is taken in formulas: {name} is {what}; choose another"
                yield FoundDefault(key, message, of_the_name=True)
            elif section != "bodies" and name in COLUMNS + GROUPS:
                others = _others(name, COLUMNS + GROUPS)
                message = f"the name is taken by a column or group of files; so are {others}; choose another"
                yield FoundDefault(key, message, of_the_name=True)


def _is_in_formulas(name: str) -> bool:
    from vibsim.cases.formula_text import FUNCTIONS

    return name == "pi" or name in FUNCTIONS


def _others(name: str, names: Iterable[str]) -> str:
    return ", ".join(other for other in names if other != name)


def names_are_different(draft: Draft) -> Iterator[FoundDefault]:
    """A part is found by its name alone, so no two bodies or parts share one."""
    first: dict[str, str] = {}
    for section in CALLED:
        for name in draft.section(section):
            if name in first:
                owner = CALLED[first[name]]
                message = (
                    f"{shown(name)} is the name of a {owner} already ({first[name]}.{name}); choose another"
                )
                yield FoundDefault(f"{section}.{name}", message, of_the_name=True)
            first.setdefault(name, section)


def names_are_no_columns(draft: Draft) -> Iterator[FoundDefault]:
    """A part named x_ram would share its column with the displacement of the body ram."""
    columns = {column: body for body in draft.bodies for column in columns_of(body)}
    for rotor in draft.section("rotors"):
        columns |= dict.fromkeys((f"phi_{rotor}", f"w_{rotor}"), rotor)
    columns |= {f"before_{columns_of(body)[1]}": body for body in draft.bodies}
    for section in PARTS:
        for name in draft.section(section):
            if name in columns:
                kind = "rotor" if columns[name] in draft.section("rotors") else "body"
                message = f"{name} is a column of {kind} {columns[name]}; choose another name"
                yield FoundDefault(f"{section}.{name}", message, of_the_name=True)


RULES: tuple[Callable[[Draft], Iterator[FoundDefault]], ...] = (
    there_is_a_body,
    a_file_has_room,
    names_are_names,
    names_are_different,
    names_are_no_columns,
    ends_exist,
    ends_differ,
    base_is_there,
    loads_act_on_bodies,
    states_exist,
    rotors_have_inertia,
    bodies_turn_alike,
    parts_join_alike,
    links_do_something,
    coefficients_fit_the_law,
    friction_falls,
    stops_have_their_law,
    starts_are_outside,
    friction_has_a_load,
    sources_are_harmonic,
    closed_form_is_there,
    products_fit,
)


def findings(flat: Mapping[str, Any], values: Mapping[str, Any], form: Form) -> list[FoundDefault]:
    """Problems found by the rules.

    flat : dotted key -> value that can be read; values : the nested texts of the case
    """
    draft = Draft(flat, values, form.torsional, form.mixed)
    return [finding for rule in RULES for finding in rule(draft)]
