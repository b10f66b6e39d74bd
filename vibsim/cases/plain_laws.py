"""Formulas that say what a built-in law says, as that law: k d + c v, sums of harmonics, M0 (1 - w/Omega0).

What is linear, harmonic or constant has exact rows, closed forms and periods of its own in the engine, so a
case that writes it as a formula gets the motion, bit for bit, and the speed of the case that writes it by the
keys of the built-in law. Only what is equal for every number type is rewritten: coefficients are exact
fractions times a power of pi.
"""

import re
from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any, NamedTuple

from vibsim.cases.formula_building import FormulaParts, belt_carries, motor_body
from vibsim.cases.formula_places import MOTOR
from vibsim.cases.formula_text import WITH_CORNERS, names_in
from vibsim.cases.quantities import Quantity
from vibsim.cases.schema import USUAL_ORDER
from vibsim.cases.schema_kinds import Formula, sides_of
from vibsim.physics.formulas import ONE, TIME, Node

Values = dict[str, Any]
PLACE: Node = ("x", "own")  # d of a link, p of a stop
RATE: Node = ("v", "own")


class Coefficient(NamedTuple):
    """value pi**power, exact."""

    value: Fraction
    power: int = 0

    def times(self, other: "Coefficient", sign: int = 1) -> "Coefficient":
        """The product with another one, or with its reciprocal (sign -1)."""
        return Coefficient(self.value * other.value**sign, self.power + sign * other.power)

    def quantity(self) -> Quantity | None:
        """As a number of a case, in SI units or per turn; None where no unit has the power of pi."""
        if self.power not in (0, 1):
            return None
        return Quantity("", self.value / 2**self.power, self.power)


Linear = dict[Node, Coefficient]  # an input, or ONE for a constant -> its coefficient, none of them 0


def linear(node: Node) -> Linear | None:
    """A formula as a sum of inputs times constants; None where it is none."""
    kind = node[0]
    if kind == "num":
        return {ONE: Coefficient(node[1])} if node[1] else {}
    if kind == "pi":
        return {ONE: Coefficient(Fraction(1), 1)}
    if kind in ("x", "v", "t"):
        return {node: Coefficient(Fraction(1))}
    if kind not in ("add", "sub", "mul", "div"):
        return None
    one, other = linear(node[1]), linear(node[2])
    if one is None or other is None:
        return None
    return _sum(one, other, kind) if kind in ("add", "sub") else _product(one, other, kind)


def _sum(one: Linear, other: Linear, kind: str) -> Linear | None:
    result = dict(one)
    for key, (value, power) in other.items():
        before = result.get(key, Coefficient(Fraction(0), power))
        if before.power != power:
            return None
        result[key] = Coefficient(before.value + value if kind == "add" else before.value - value, power)
    return {key: c for key, c in result.items() if c.value}


def _product(one: Linear, other: Linear, kind: str) -> Linear | None:
    if kind == "mul" and other.keys() - {ONE}:
        one, other = other, one
    if other.keys() != {ONE}:
        return {} if kind == "mul" and not other else None
    sign = 1 if kind == "mul" else -1
    return {key: c.times(other[ONE], sign) for key, c in one.items()}


class HarmonicTerm(NamedTuple):
    """amplitude sin(omega t + phase)."""

    amplitude: Coefficient
    omega: Coefficient
    phase: Coefficient

    def values(self, key: str) -> Values | None:
        """The keys of a harmonic of a case with its amplitude under `key`; None where no keys say it."""
        amplitude, omega, phase = self
        rate, angle = omega.quantity(), phase.quantity()
        if rate is None or angle is None:
            return None
        size: Any = amplitude.quantity() if not amplitude.power else None
        if key == "A" and amplitude.power == 2 * omega.power:  # m e omega**2 of an unbalance
            size = {"m3": Quantity("", amplitude.value / omega.value**2), "e": Quantity("", Fraction(1))}
        return None if size is None else {key: size, "omega": rate, "phase": angle}


def harmonics(node: Node) -> tuple[Coefficient, list[HarmonicTerm]] | None:
    """A formula as a constant and harmonics in time; None where it is not such a sum."""
    constant, terms = Coefficient(Fraction(0)), []
    for factor, one in _addends(node, Coefficient(Fraction(1))):
        if one[0] not in ("sin", "cos"):
            plain = linear(one)
            if plain is None or plain.keys() - {ONE}:
                return None
            value = factor.times(plain.get(ONE, Coefficient(Fraction(0))))
            if not value.value:
                continue
            if constant.value and constant.power != value.power:
                return None
            constant = Coefficient(constant.value + value.value, value.power)
            continue
        term = _harmonic(factor, one)
        if term is None:
            return None
        terms.append(term)
    return constant, terms


def _addends(node: Node, factor: Coefficient) -> Iterator[tuple[Coefficient, Node]]:
    """The addends of a sum, each with the constant before it."""
    kind = node[0]
    if kind in ("add", "sub"):
        yield from _addends(node[1], factor)
        yield from _addends(node[2], factor if kind == "add" else Coefficient(-factor.value, factor.power))
        return
    if kind in ("mul", "div"):
        for inner, other in ((1, 2), (2, 1)) if kind == "mul" else ((1, 2),):
            constant = linear(node[other])
            if constant is not None and constant.keys() == {ONE}:
                yield from _addends(node[inner], factor.times(constant[ONE], 1 if kind == "mul" else -1))
                return
    yield factor, node


def _harmonic(amplitude: Coefficient, node: Node) -> HarmonicTerm | None:
    """amplitude sin(u) or amplitude cos(u), u linear in time."""
    u = linear(node[1])
    if u is None or TIME not in u or u.keys() - {TIME, ONE}:
        return None
    omega, phase = u[TIME], u.get(ONE, Coefficient(Fraction(0), 1))
    is_cos = node[0] == "cos"
    if omega.value < 0:  # sin(-u) = -sin(u), cos(-u) = cos(u)
        omega, phase = (Coefficient(-c.value, c.power) for c in (omega, phase))
        amplitude = amplitude if is_cos else Coefficient(-amplitude.value, amplitude.power)
    half_turns = Fraction(is_cos, 2) + (amplitude.value < 0)  # pi each
    if half_turns:
        if phase.power != 1:
            return None
        phase = Coefficient(phase.value + half_turns, 1)
        amplitude = Coefficient(abs(amplitude.value), amplitude.power)
    return HarmonicTerm(amplitude, omega, phase)


def with_plain_laws(values: Values) -> Values:
    """The nested values of a case in the long form, defaults filled in, with built-in laws in place of the
    formulas that say the same.
    """
    return _Rewriting(values).values()


class _Rewriting:
    """The formulas of a case, each looked at by itself."""

    def __init__(self, values: Values):
        self.before, self.formulas = values, FormulaParts(values)

    def values(self) -> Values:
        result = dict(self.before)
        for section in ("links", "stops", "friction", "forces"):
            if section in result:
                rewrite, parts = getattr(self, f"_{section}"), result[section].items()
                result[section] = {name: rewrite(name, part) or part for name, part in parts}
        if self.formulas.has("base", "", "x"):
            result["base"] = self._base(result["base"]) or result["base"]
        if self.formulas.scene.motor_is_rotor:
            result["motor"] = self._motor(result) or result["motor"]
        if "parameters" in result and not any(_formulas_in(result)):
            del result["parameters"]  # which no formula reads any more
        return result

    def _own(self, section: str, name: str, **instead: Node) -> Linear:
        """The force of a part, as a sum of its own names; empty where it is none."""
        found = linear(self.formulas.node(section, name, "force", "", **instead)) or {}
        if found.keys() - {PLACE, RATE} or any(c.value < 0 or c.power for c in found.values()):
            return {}
        return found

    @staticmethod
    def _constants(found: Linear) -> Values:
        """k and c."""
        none = Coefficient(Fraction(0))
        k, c = (Quantity("", found.get(key, none).value) for key in (PLACE, RATE))
        return {"k": k, "c": c}

    def _links(self, name: str, part: Values) -> Values | None:
        found = self._own("links", name, d=PLACE, v=RATE) if "force" in part else {}
        return {"between": part["between"], **self._constants(found)} if found else None

    def _stops(self, name: str, part: Values) -> Values | None:
        found = self._own("stops", name, p=PLACE, pv=RATE) if "force" in part else {}
        if PLACE not in found:
            return None
        kept = {key: part[key] for key in ("between", "gap", "acts", "release")}
        return kept | {"law": "elastic"} | self._constants(found)

    def _friction(self, name: str, part: Values) -> Values | None:
        """A load and a coefficient that are constants."""
        if sides_of("friction", part) or isinstance(part["belt"], Formula):
            return None
        result = dict(part)
        if self.formulas.has("friction", name, "N"):
            load = _constant(self.formulas.node("friction", name, "N"))
            if load is None:
                return None
            result["N"] = load
        if self.formulas.has("friction", name, "mu"):
            node = self.formulas.node("friction", name, "mu", "", s=RATE)
            mu = _constant(node)
            if mu is None:
                return None
            result["mu"] = mu
        return result

    def _forces(self, name: str, part: Values) -> Values | None:
        found = self._harmonics("A", self.formulas.node("forces", name, "force")) if "force" in part else None
        return None if found is None else {"on": part["on"]} | found

    def _base(self, part: Values) -> Values | None:
        found = self._harmonics("a", self.formulas.node("base", "", "x"))
        return None if found is None or found.pop("F0").value else found

    @staticmethod
    def _harmonics(key: str, node: Node) -> Values | None:
        """The keys of a sum of harmonics and a constant F0."""
        found = harmonics(node)
        constant = found[0].quantity() if found else None
        if found is None or constant is None or constant.per_turn:
            return None
        terms = [term.values(key) for term in found[1]]
        if not all(terms):
            return None
        return {"F0": constant, "terms": {str(i): term for i, term in enumerate(terms, 1)}}

    def _motor(self, values: Values) -> Values | None:
        """A torque that falls evenly with the speed, where nothing else reads the rotor."""
        torque = self.formulas.torque(MOTOR)
        speed: Node = ("v", self.formulas.scene.index[MOTOR])
        found = linear(torque) if torque is not None else None
        if found is None or found.keys() != {ONE, speed} or "rotors" in values or _reads_rotor(values):
            return None
        scene = self.formulas.scene
        if belt_carries(scene, motor_body(scene)) and not self.formulas.belts_are_base:
            return None  # a belt turns a rotor on what it carries, and no motor
        stall, drag = found[ONE], Coefficient(-found[speed].value, found[speed].power)
        M0, Omega0 = stall.quantity(), stall.times(drag, -1).quantity()
        if M0 is None or Omega0 is None or M0.per_turn or M0.value <= 0 or Omega0.value <= 0:
            return None
        kept = {key: part for key, part in values["motor"].items() if key in ("on", "m3", "e", "J")}
        return kept | {"M0": M0, "Omega0": Omega0}


def _constant(node: Node) -> Quantity | None:
    """The number not below 0 that a formula is."""
    found = linear(node)
    if found is None or found.keys() - {ONE}:
        return None
    value, power = found.get(ONE, Coefficient(Fraction(0)))
    return None if power or value < 0 else Quantity("", value)


def _reads_rotor(values: Mapping[str, Any]) -> bool:
    """Whether a formula beside those of the motor reads its angle or speed."""
    others = [part for name, part in values.items() if name != MOTOR]
    return any({"phi", "w"} & {*names_in(text)} for text in _formulas_in(others))


def _formulas_in(value: Any) -> Iterator[str]:
    if isinstance(value, Formula):
        yield value.text
    elif isinstance(value, Mapping):
        for one in value.values():
            yield from _formulas_in(one)
    elif isinstance(value, list):
        for one in value:
            yield from _formulas_in(one)


# The order of the Taylor series, which depends on the formulas that are left.


ORDER_OF_SMOOTH = 32
ENDING_STEPS = ("stops", "friction", "clearances", "states")  # sections of what ends or shortens steps
CORNER = re.compile(rf"\b(?:{'|'.join(WITH_CORNERS)})\s*\(")


def default_order(values: Values) -> int:
    """Order of the Taylor series of a case that does not say it, by its nested values; see docs/laws.md.

    With a higher order steps are longer and cost more. It wins where formulas and rotors are smooth and
    nothing else ends a step; not where events or corners of formulas do, or a stiff state keeps it short.
    """
    if any(values.get(section) for section in ENDING_STEPS):
        return USUAL_ORDER
    left = with_plain_laws(values)
    texts = list(_formulas_in(left))
    smooth = not any(CORNER.search(text) for text in texts)
    return ORDER_OF_SMOOTH if smooth and (texts or left.get("rotors")) else USUAL_ORDER
