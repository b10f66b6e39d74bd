"""Rules that concern several keys at once; each yields the key to blame and what is wrong there."""

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from math import prod
from typing import Any

from vibsim.cases.quantities import LARGEST, SMALLEST, Quantity

MOST_SAMPLES = 10**10
LARGEST_WHOLE = 2**53  # above it a double does not hold every whole number

Flat = Mapping[str, Any]  # dotted key -> Quantity, word or whole number; what cannot be read is absent
Contradiction = tuple[str, str]


def contradictions(flat: Flat) -> list[Contradiction]:
    """All (key, message) that the rules find in a case's values."""
    return [found for rule in RULES for found in rule(flat)]


def _extends_is_followed(flat: Flat) -> Iterator[Contradiction]:
    if "extends" in flat:
        yield "extends", "works in a case file only"


def _given(flat: Flat, section: str) -> bool:
    return any(key.startswith(f"{section}.") for key in flat)


def _friction_needs_block_2(flat: Flat) -> Iterator[Contradiction]:
    if flat.get("blocks.m2") == "fixed" and _given(flat, "friction"):
        yield "friction", "block 2 is fixed, so nothing slides; leave friction out or write none"


def _states_that_exist(flat: Flat) -> Iterator[Contradiction]:
    absent = []
    if flat.get("blocks.m2") == "fixed":
        absent += [("x2", "block 2 is fixed"), ("v2", "block 2 is fixed")]
    if flat.get("excitation.kind", "none") != "motor":
        absent += [("phi", "there is no motor"), ("phidot", "there is no motor")]
    for name, why in absent:
        state = flat.get(f"initial.{name}")
        if isinstance(state, Quantity) and state.value != 0:
            yield f"initial.{name}", f"{why}, so {name} does not exist; leave it out, got {state}"


def _closed_form_needs_linear(flat: Flat) -> Iterator[Contradiction]:
    if flat.get("run.method") == "closed_form" and flat.get("excitation.kind") == "motor":
        yield "run.method", "a motor has no closed form; allowed with a motor: auto, taylor; got closed_form"


def _output_interval(flat: Flat) -> Iterator[Contradiction]:
    every, t_end = _exact(flat, "run.every"), _exact(flat, "run.t_end")
    if every is None:
        return
    if max(every.numerator, every.denominator) >= LARGEST_WHOLE:
        yield "run.every", "has too many digits; in seconds it must be a fraction of whole numbers below 2^53"
    elif t_end is not None and t_end / every > MOST_SAMPLES:
        yield (
            "run.every",
            f"gives {float(t_end / every):.3g} samples up to run.t_end; at most 1e10 are allowed",
        )


def _exact(flat: Flat, key: str) -> Fraction | None:
    found = flat.get(key)
    return found.value if isinstance(found, Quantity) else None


def _derived_numbers_fit(flat: Flat) -> Iterator[Contradiction]:
    """What is computed from several values must fit a double as they do; in doubles an overflow is inf."""
    for key, name, factors in PRODUCTS:
        found = [flat.get(factor) for factor in factors]
        numbers = [factor.number() for factor in found if isinstance(factor, Quantity)]
        if len(numbers) == len(factors) and all(numbers):
            product = abs(prod(numbers))
            if not SMALLEST <= product <= LARGEST:
                yield key, f"{name} does not fit double precision (2.3e-308 to 2.2e307)"


PRODUCTS = (
    ("friction.mu", "mu m2 g", ("friction.mu", "blocks.m2", "friction.g")),
    (
        "excitation.A",
        "m3 e omega^2",
        ("excitation.A.m3", "excitation.A.e", "excitation.omega", "excitation.omega"),
    ),
    ("excitation.e", "m3 e^2", ("excitation.m3", "excitation.e", "excitation.e")),
)
RULES: tuple[Callable[[Flat], Iterator[Contradiction]], ...] = (
    _extends_is_followed,
    _friction_needs_block_2,
    _states_that_exist,
    _closed_form_needs_linear,
    _output_interval,
    _derived_numbers_fit,
)
