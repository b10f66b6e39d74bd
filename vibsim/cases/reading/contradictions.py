"""Rules that concern several keys at once.

Each yields the keys that contradict one another and what is wrong; the first key is to blame where all stand
in one file.
"""

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from math import prod
from typing import Any

from vibsim.cases.values.quantities import LARGEST, SMALLEST, Quantity

MOST_SAMPLES = 10**10
LARGEST_WHOLE = 2**53  # above it a double does not hold every whole number

Flat = Mapping[str, Any]  # dotted key -> Quantity, word or whole number; what cannot be read is absent
Contradiction = tuple[tuple[str, ...], str]


def contradictions(flat: Flat) -> list[Contradiction]:
    """All (keys, message) that the rules find in a case's values."""
    return [problem for rule in RULES for problem in rule(flat)]


def _extends_is_followed(flat: Flat) -> Iterator[Contradiction]:
    if "extends" in flat:
        yield ("extends",), "works in a case file only"


def _present(flat: Flat, section: str) -> bool:
    return any(key.startswith(f"{section}.") for key in flat)


def _friction_needs_block_2(flat: Flat) -> Iterator[Contradiction]:
    if flat.get("blocks.m2") == "fixed" and _present(flat, "friction"):
        yield (
            ("friction", "blocks.m2"),
            "block 2 is fixed and cannot slide; leave friction out, or write none",
        )


def _states_that_exist(flat: Flat) -> Iterator[Contradiction]:
    if flat.get("blocks.m2") == "fixed":
        yield from _without(flat, ("x2", "v2"), "blocks.m2", "block 2 is fixed")
    if flat.get("excitation.kind", "none") != "motor":
        yield from _without(flat, ("phi", "phidot"), "excitation.kind", "there is no motor")


def _without(flat: Flat, states: tuple[str, ...], cause: str, why: str) -> Iterator[Contradiction]:
    """States that are given and do not exist; an exact 0 says nothing and is let through."""
    for name in states:
        state = flat.get(f"initial.{name}")
        if isinstance(state, Quantity) and state.value != 0:
            yield (f"initial.{name}", cause), f"{why}, so initial.{name} must be left out, got {state}"


def _closed_form_needs_linear(flat: Flat) -> Iterator[Contradiction]:
    if flat.get("run.method") == "closed_form" and flat.get("excitation.kind") == "motor":
        what = "a motor has no closed form; with one, run.method must be auto or taylor, got closed_form"
        yield ("run.method", "excitation.kind"), what


def _output_interval(flat: Flat) -> Iterator[Contradiction]:
    """Sample i is at i p/q, and both products are whole numbers that a double holds."""
    every, t_end = _exact(flat, "run.every"), _exact(flat, "run.t_end")
    if every is None:
        return
    span = every + (t_end or 0)
    held = max(Fraction(every.numerator), span * every.denominator) < LARGEST_WHOLE
    if not held and span / every <= MOST_SAMPLES:
        every_text = f"as p/q seconds, {flat['run.every']} has too many digits"
        what = f"{every_text}: p, and q times run.t_end, must be below 2^53; a fraction such as 1/60 s may do"
        yield ("run.every", "run.t_end"), what
    elif span / every > MOST_SAMPLES:
        count = f"{float(span / every):.3g}"
        what = (
            f"{flat['run.t_end']} every {flat['run.every']} makes {count} samples; at most 1e10 are allowed"
        )
        yield ("run.every", "run.t_end"), what


def _exact(flat: Flat, key: str) -> Fraction | None:
    value = flat.get(key)
    return value.value if isinstance(value, Quantity) else None


def _derived_numbers_fit(flat: Flat) -> Iterator[Contradiction]:
    """What is computed from several values must fit a double as they do; in doubles an overflow is inf."""
    for name, factors in PRODUCTS.items():
        values = [flat.get(factor) for factor in factors]
        numbers = [factor.number() for factor in values if isinstance(factor, Quantity)]
        if len(numbers) == len(factors) and all(numbers):
            product = abs(prod(numbers))
            if not SMALLEST <= product <= LARGEST:
                yield factors, f"{name} does not fit double precision (2.3e-308 to 2.2e307)"


PRODUCTS = {
    "mu m2 g": ("friction.mu", "blocks.m2", "friction.g"),
    "m3 e omega^2": ("excitation.A.m3", "excitation.A.e", "excitation.omega", "excitation.omega"),
    "m3 e^2": ("excitation.m3", "excitation.e", "excitation.e"),
}
RULES: tuple[Callable[[Flat], Iterator[Contradiction]], ...] = (
    _extends_is_followed,
    _friction_needs_block_2,
    _states_that_exist,
    _closed_form_needs_linear,
    _output_interval,
    _derived_numbers_fit,
)
