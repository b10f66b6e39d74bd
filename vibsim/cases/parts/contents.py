"""Rules for what a part needs, and for keys that stand in place of one another."""

from collections.abc import Iterator
from math import prod
from typing import Any

from vibsim.cases.parts.draft import Draft, Finding
from vibsim.cases.parts.ends import NO_BODIES, Ends
from vibsim.cases.parts.friction_laws import COULOMB
from vibsim.cases.values.quantities import LARGEST, SMALLEST, Quantity

MOST_COLUMNS = 4000  # notes of 16 bytes each on the scale of a table, in an attribute of 64 kB


def there_is_a_body(draft: Draft) -> Iterator[Finding]:
    if draft.values.get("bodies") == {}:
        yield Finding("bodies", "a scene needs at least one body, such as {ram: 2 kg}", of_the_name=True)


def a_file_has_room(draft: Draft) -> Iterator[Finding]:
    """A result file holds MOST_COLUMNS of a table: what HDF5 can note at one scale."""
    bodies, parts = len(draft.bodies), sum(1 for _ in draft.parts("stops", "friction", "clearances"))
    rigid = any(part.get("law") == "rigid" for _, part in draft.parts("stops"))
    columns = (3 if rigid else 2) * bodies + parts
    if columns > MOST_COLUMNS:
        message = (
            f"{bodies} bodies and their stops, frictions and clearances make {columns} columns; "
            f"a result file has room for {MOST_COLUMNS}"
        )
        yield Finding("bodies", message, of_the_name=True)


def links_do_something(draft: Draft) -> Iterator[Finding]:
    for key, part in draft.parts("links"):
        if "k" not in part and "c" not in part:
            yield Finding(key, "a link needs k, c or both", of_the_name=True)


def friction_has_a_load(draft: Draft) -> Iterator[Finding]:
    """N, or the weight m g of the first end."""
    for key, part in draft.parts("friction"):
        ends = Ends.read(part.get("between"))
        if "N" in part and "g" in part:
            yield Finding(f"{key}.g", "the load is N, so g must be left out", of_the_name=True)
        elif "N" not in part and ends is not None and ends.P in NO_BODIES and ends.Q not in NO_BODIES:
            message = (
                f"the load m g is that of the first end, and {ends.P} is no body; give N, or write "
                f"{ends.Q} first"
            )
            yield Finding(f"{key}.between", message)


def sources_are_harmonic(draft: Draft) -> Iterator[Finding]:
    """A and omega (a and omega of base), or terms; a force may be F0 alone."""
    for key, part in draft.parts("forces"):
        yield from _harmonic(key, part, "A", bool("F0" in part))
    if isinstance(draft.values.get("base"), dict):
        yield from _harmonic("base", draft.section("base"), "a", False)


def _harmonic(key: str, part: dict[str, Any], amplitude: str, constant: bool) -> Iterator[Finding]:
    single = [name for name in (amplitude, "omega", "phase") if name in part]
    if "terms" in part:
        if single:
            message = f"terms has the harmonics, so {' and '.join(single)} must be left out"
            yield Finding(f"{key}.{single[0]}", message, of_the_name=True)
        if isinstance(part["terms"], dict) and list(part["terms"]) != _numbers(part["terms"]):
            example = f"[{{{amplitude}: ..., omega: ...}}]"
            message = f"must be a list of harmonics, such as {example}"
            yield Finding(f"{key}.terms", message, of_the_name=True)
    elif not single and not constant:
        required = f"{amplitude} and omega, or terms" + (", or F0" if amplitude == "A" else "")
        yield Finding(key, f"needs {required}", of_the_name=True)
    elif single:
        for name in (amplitude, "omega"):
            if name not in part:
                yield Finding(key, f"{single[0]} is given and {name} is missing", of_the_name=True)


def _numbers(terms: dict[str, Any]) -> list[str]:
    return [str(i + 1) for i in range(max(1, len(terms)))]


def closed_form_is_there(draft: Draft) -> Iterator[Finding]:
    laws = {key: part.get("law", COULOMB) for key, part in draft.parts("friction")}
    falling = [key for key, law in laws.items() if law != COULOMB]
    if draft.flat.get("run.method") != "closed_form":
        return
    allowed = "run.method must be auto or taylor, got closed_form"
    if "motor" in draft.values:
        yield Finding("run.method", f"a motor has no closed form; with one, {allowed}")
    elif falling:
        yield Finding("run.method", f"{falling[0]} falls with speed and has no closed form; {allowed}")


def products_fit(draft: Draft) -> Iterator[Finding]:
    """What is computed from several values must fit a double as they do."""
    for key, name, factors in _products(draft):
        numbers = [factor.number() for factor in factors if factor is not None]
        if len(numbers) == len(factors) and all(numbers) and not SMALLEST <= abs(prod(numbers)) <= LARGEST:
            yield Finding(
                key, f"{name} does not fit double precision (2.3e-308 to 2.2e307)", of_the_name=True
            )


def _products(draft: Draft) -> Iterator[tuple[str, str, list[Quantity | None]]]:
    for key, part in draft.parts("friction"):
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
        for term in [key, *(f"{key}.terms.{number}" for number in _dict(part.get("terms")))]:
            omega = draft.quantity(f"{term}.omega")
            rule = [draft.quantity(f"{term}.A.{name}") for name in ("m3", "e")]
            yield f"{term}.A", "m3 e omega^2", [*rule, omega, omega]
    motor = [draft.quantity(f"motor.{name}") for name in ("m3", "e", "e")]
    yield "motor", "m3 e^2", motor


def _dict(value: object) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}
