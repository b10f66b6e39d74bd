"""Rules that concern several keys at once; each yields the key to blame and what is wrong there."""

from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any

from vibsim.cases.keys import all_keys
from vibsim.cases.quantities import LARGEST, SMALLEST, Quantity, QuantityError

MOST_SAMPLES = 10**10
LARGEST_WHOLE = 2**53  # above it a double does not hold every whole number

Flat = dict[str, Any]
Contradiction = tuple[str, str]


def contradictions(values: dict[str, Any]) -> list[Contradiction]:
    """All (key, message) of a tree of texts or quantities; values that cannot be read are passed over."""
    flat = dict(_readable(values, ""))
    return [found for rule in RULES for found in rule(flat)]


def _readable(values: dict[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    for name, value in values.items():
        key = f"{prefix}{name}"
        if isinstance(value, dict):
            yield from _readable(value, f"{key}.")
            continue
        measured = all_keys().get(key)
        try:
            yield key, measured.read(value) if measured else value
        except QuantityError:
            continue


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
    t_end, every = flat.get("run.t_end", Fraction(300)), flat.get("run.every", Fraction(1, 200))
    t_end, every = (getattr(time, "value", time) for time in (t_end, every))
    if max(every.numerator, every.denominator) >= LARGEST_WHOLE:
        yield "run.every", "has too many digits; a fraction of whole numbers below 2^53 is needed"
    elif t_end / every > MOST_SAMPLES:
        count = float(t_end / every)
        yield "run.every", f"gives {count:.3g} samples up to run.t_end; at most 1e10 are allowed"


def _derived_numbers_fit(flat: Flat) -> Iterator[Contradiction]:
    """mu m2 g and m3 e omega^2 must fit doubles as their factors do."""
    mu, m2 = flat.get("friction.mu"), flat.get("blocks.m2")
    g = flat.get("friction.g", Fraction("9.81"))
    if isinstance(mu, Quantity) and isinstance(m2, Quantity):
        yield from _fits("friction.mu", "mu m2 g", mu.value * m2.value * getattr(g, "value", g))
    m3, e, omega = (flat.get(f"excitation.{key}") for key in ("A.m3", "A.e", "omega"))
    if isinstance(m3, Quantity) and isinstance(e, Quantity) and isinstance(omega, Quantity):
        yield from _fits("excitation.A", "m3 e omega^2", m3.value * e.value * omega.value**2 * 40)
    m3, e, J = (flat.get(f"excitation.{key}") for key in ("m3", "e", "J"))
    if isinstance(m3, Quantity) and isinstance(e, Quantity) and isinstance(J, Quantity):
        yield from _fits("excitation.e", "J + m3 e^2", J.value + m3.value * e.value**2)


def _fits(key: str, name: str, number: Fraction) -> Iterator[Contradiction]:
    if number and not SMALLEST <= abs(number) <= LARGEST:
        yield key, f"{name} does not fit double precision (2.3e-308 to 2.2e307)"


RULES: tuple[Callable[[Flat], Iterator[Contradiction]], ...] = (
    _friction_needs_block_2,
    _states_that_exist,
    _closed_form_needs_linear,
    _output_interval,
    _derived_numbers_fit,
)
