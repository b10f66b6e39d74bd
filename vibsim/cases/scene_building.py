"""The seam between case and engine: exact quantities become the numbers of a scene, each rounded once."""

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any, NamedTuple

from vibsim.cases.schema.schema import AmplitudeRule, CaseFile, Harmonic, Motor
from vibsim.cases.values.pi import times_two_pi, two_pi_fraction
from vibsim.cases.values.quantities import Quantity
from vibsim.physics.two_blocks import TwoBlocks

Number = Any
PI_DIGITS = 1100  # of the fraction that stands for pi where a number type brings none


class NumberType(NamedTuple):
    """How exact values become numbers.

    Attributes
    ----------
    convert : (value, power) -> value * (2 pi)**power
    cycles : angular rate -> (cycles, cycles_lo) in Hz
    """

    convert: Callable[[Fraction, int], Number]
    cycles: Callable[[Quantity], tuple[Number, Number]]

    def of(self, quantity: Quantity) -> Number:
        """The number in SI units, rad and rad/s."""
        return self.convert(quantity.value, _turns(quantity))


def _turns(quantity: Quantity) -> int:
    return 1 if quantity.per_turn else 0


DOUBLES = NumberType(times_two_pi, Quantity.cycles)


def exact_numbers(number: Callable[[Fraction], Number], pi: Number = None) -> NumberType:
    """Numbers of another type, such as flint.arb or mpmath.mpf, made by number(Fraction).

    `pi` is pi in that type; without it a fraction right to 1100 digits is converted.
    """
    two_pi = number(two_pi_fraction(PI_DIGITS)) if pi is None else 2 * pi

    def convert(value: Fraction, power: int) -> Number:
        return number(value) * two_pi**power if power else number(value)

    def cycles(rate: Quantity) -> tuple[Number, Number]:
        return (rate.value if rate.per_turn else number(rate.value) / two_pi), number(Fraction(0))

    return NumberType(convert, cycles)


def amplitude_value(source: Harmonic) -> tuple[Fraction, int]:
    """Amplitude A [N] of the ideal source as (value, power), value * (2 pi)**power; the rule: Eq. (2.11)."""
    if not isinstance(source.A, AmplitudeRule):
        return source.A.value, 0
    return rule_value(source.A.__dict__, source.omega)


def rule_value(rule: Mapping[str, Any], omega: Quantity) -> tuple[Fraction, int]:
    """m3 e omega^2 [N], Eq. (2.11), as (value, power), value * (2 pi)**power."""
    return rule["m3"].value * rule["e"].value * omega.value**2, 2 * _turns(omega)


def build_two_blocks(case: CaseFile, numbers: NumberType = DOUBLES) -> TwoBlocks:
    """The scene of a case [SI, rad/s]; parts missing from the case are None."""
    every = case.run.every.value
    return TwoBlocks(
        **_blocks(case, numbers),
        **_source(case, numbers),
        **_initial_state(case, numbers),
        rest_distance=numbers.of(case.rest_distance.value) if case.rest_distance else None,
        stop_on_violation=bool(case.rest_distance and case.rest_distance.on_violation == "stop"),
        t_end=numbers.of(case.run.t_end),
        every_num=every.numerator,
        every_den=every.denominator,
        method=case.run.method,
        order=case.run.order,
        tol=numbers.of(case.run.tol),
        **_exact_places(case),
    )


def _exact_places(case: CaseFile) -> dict[str, Any]:
    """Whether the blocks start exactly at the stop, and at the rest distance, by the numbers of the case."""
    behind = case.initial.x2.value if isinstance(case.blocks.m2, Quantity) else Fraction(0)
    compression = case.initial.x1.value - behind
    stop, rest = case.stop, case.rest_distance
    return {
        "at_stop": stop is not None
        and stop.G.value == (compression if stop.acts == "compression" else -compression),
        "at_rest_distance": rest is not None and rest.value.value == compression,
    }


def _blocks(case: CaseFile, numbers: NumberType) -> dict[str, Number]:
    blocks, stop = case.blocks, case.stop
    return {
        "m1": numbers.of(blocks.m1),
        "m2": numbers.of(blocks.m2) if isinstance(blocks.m2, Quantity) else None,
        "k1": numbers.of(case.coupling.k1),
        "c": numbers.of(case.coupling.c),
        "k2": numbers.of(stop.k2) if stop else None,
        "G": numbers.of(stop.G) if stop else None,
        "stop_sign": -1 if stop and stop.acts == "compression" else 1,
        "N": _limit_friction(case, numbers),
    }


def _limit_friction(case: CaseFile, numbers: NumberType) -> Number:
    """N = mu m2 g [N], Eq. (2.7), multiplied exactly and rounded once; None without friction."""
    friction, m2 = case.friction, case.blocks.m2
    if friction is None or not isinstance(m2, Quantity) or friction.mu.value == 0:
        return None
    return numbers.convert(friction.mu.value * m2.value * friction.g.value, 0)


def _source(case: CaseFile, numbers: NumberType) -> dict[str, Number]:
    source = case.excitation
    source_numbers: dict[str, Number] = dict.fromkeys(
        ("A", "F0", "omega", "cycles", "cycles_lo", "m3", "e", "J", "M0", "Omega0")
    )
    source_numbers["source"] = source.kind
    if isinstance(source, Harmonic):
        source_numbers["A"] = numbers.convert(*amplitude_value(source))
        source_numbers["F0"], source_numbers["omega"] = numbers.of(source.F0), numbers.of(source.omega)
        source_numbers["cycles"], source_numbers["cycles_lo"] = numbers.cycles(source.omega)
    elif isinstance(source, Motor):
        source_numbers |= {
            name: numbers.of(getattr(source, name)) for name in ("m3", "e", "J", "M0", "Omega0")
        }
    return source_numbers


def _initial_state(case: CaseFile, numbers: NumberType) -> dict[str, Number]:
    names = ["x1", "v1"]
    names += ["x2", "v2"] if isinstance(case.blocks.m2, Quantity) else []
    names += ["phi", "phidot"] if isinstance(case.excitation, Motor) else []
    state: dict[str, Number] = dict.fromkeys(("x1", "v1", "x2", "v2", "phi", "phidot"))
    return state | {name: numbers.of(getattr(case.initial, name)) for name in names}
