"""The seam between case and engine: exact quantities become the numbers of a scene, each rounded once."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple

from vibsim.cases.part_laws import directions, falls
from vibsim.cases.quantities import Quantity, is_inertia
from vibsim.cases.schema import AmplitudeRule, CaseFile, HarmonicKeys, MotorKeys
from vibsim.cases.schema_keys import form_of
from vibsim.cases.schema_kinds import Formula, has_formulas
from vibsim.cases.short_form import BASE as BASE_END
from vibsim.cases.short_form import GROUND as GROUND_END
from vibsim.physics.elementary import times_two_pi, two_pi_fraction
from vibsim.physics.parts import (
    BASE,
    BODY,
    COMPRESSION,
    EXTENSION,
    GROUND,
    MOTOR,
    ROTOR,
    STATE,
    Body,
    Clearance,
    Force,
    Friction,
    Harmonic,
    Link,
    Motor,
    RigidStop,
    Rotor,
    Scene,
    Stop,
)
from vibsim.physics.two_blocks import TwoBlocks

if TYPE_CHECKING:
    from vibsim.cases.formula_building import FormulaParts

Number = Any
PI_DIGITS = 1100  # of the fraction that stands for pi where a number type brings none


class NumberType(NamedTuple):
    """The number type that exact values are rounded to.

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
    return int(quantity.per_turn)


DOUBLES = NumberType(times_two_pi, Quantity.cycles)


def exact_numbers(number: Callable[[Fraction], Number], pi: Number = None) -> NumberType:
    """Numbers of another type, such as those of words, made by number(Fraction).

    `pi` is pi in that type; without it a fraction right to 1100 digits is converted.
    """
    two_pi = number(two_pi_fraction(PI_DIGITS)) if pi is None else 2 * pi

    def convert(value: Fraction, power: int) -> Number:
        return number(value) * two_pi**power if power else number(value)

    def cycles(rate: Quantity) -> tuple[Number, Number]:
        return (rate.value if rate.per_turn else number(rate.value) / two_pi), number(Fraction(0))

    return NumberType(convert, cycles)


def amplitude_value(source: HarmonicKeys) -> tuple[Fraction, int]:
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
    if isinstance(source, HarmonicKeys):
        source_numbers["A"] = numbers.convert(*amplitude_value(source))
        source_numbers["F0"], source_numbers["omega"] = numbers.of(source.F0), numbers.of(source.omega)
        source_numbers["cycles"], source_numbers["cycles_lo"] = numbers.cycles(source.omega)
    elif isinstance(source, MotorKeys):
        source_numbers |= {
            name: numbers.of(getattr(source, name)) for name in ("m3", "e", "J", "M0", "Omega0")
        }
    return source_numbers


def _initial_state(case: CaseFile, numbers: NumberType) -> dict[str, Number]:
    names = ["x1", "v1"]
    names += ["x2", "v2"] if isinstance(case.blocks.m2, Quantity) else []
    names += ["phi", "phidot"] if isinstance(case.excitation, MotorKeys) else []
    state: dict[str, Number] = dict.fromkeys(("x1", "v1", "x2", "v2", "phi", "phidot"))
    return state | {name: numbers.of(getattr(case.initial, name)) for name in names}


# From the values of the long form to a scene of parts: exact quantities to numbers, each rounded once.


Values = dict[str, Any]
# sections of a case that make a part of a scene each, and which
FIELDS = {
    "links": "links",
    "stops": "stops",
    "friction": "frictions",
    "forces": "forces",
    "base": "base",
    "motor": "motor",
    "clearances": "clearances",
}
SENSES = {"extension": EXTENSION, "compression": COMPRESSION}


def build_parts(values: Values, numbers: NumberType = DOUBLES) -> Scene:
    """The scene [SI, rad/s] of the nested values of a case in the long form, defaults filled in."""
    return SceneBuilder(values, numbers).scene()


class SceneBuilder:
    """The values of one case, the numbers they become and the bodies they speak of."""

    def __init__(self, values: Values, numbers: NumberType):
        self.numbers = numbers
        self.values = _with_plain_laws(values)
        self.formulas = _formulas_of(self.values)
        names = self.formulas.scene.index if self.formulas else values["bodies"]
        self.index = {name: i for i, name in enumerate(names)}
        self.index |= {GROUND_END: GROUND, BASE_END: BASE}

    def scene(self) -> Scene:
        run = self.values["run"]
        every = run["every"].value
        return Scene(
            bodies=self.bodies(),
            **self.of_formulas(),
            **{field: self.section(name) for name, field in FIELDS.items()},
            stop_on_violation=run["on_violation"] == "stop",
            t_end=self.numbers.of(run["t_end"]),
            every_num=every.numerator,
            every_den=every.denominator,
            method=run["method"],
            order=run["order"],
            tol=self.numbers.of(run["tol"]),
        )

    def rebuilt(self, scene: Scene, sections: Iterable[str]) -> Scene:
        """The scene, which has the parts of another one but for those of sections that differ from its own.
        Bodies have a say in other parts, and no section of their own here.
        """
        if not FIELDS.keys() >= set(sections) or ("motor" in sections and has_formulas(self.values)):
            return self.scene()
        return scene.but(**{FIELDS[name]: self.section(name) for name in sections})

    def of_numbers(self, values: Values) -> "SceneBuilder":
        """The builder of values that differ in numbers which no formula reads."""
        other = object.__new__(SceneBuilder)  # copy.copy takes as long as all the rest
        vars(other).update(vars(self), values=values)
        return other

    def from_start(self, scene: Scene, initial: Values) -> Scene:
        """The scene that these values make with other initial ones; what does not depend on these are the
        parts of `scene`, which the values themselves make.
        """
        other = self.of_numbers({**self.values, "initial": initial})
        motor = scene.motor
        if motor is not None:
            phi, phidot = other.several(initial["motor"], "phi", "phidot")
            motor = replace(motor, phi=phi, phidot=phidot)
        return scene.but(
            bodies=tuple(map(other.started, scene.bodies)),
            stops=other.limited("stops", scene.stops),
            clearances=other.limited("clearances", scene.clearances),
            motor=motor,
        )

    def started(self, body: Body) -> Body:
        """The body or rotor at its initial values."""
        if body.kind == STATE:
            return body
        keys = ("x", "v") if body.kind == BODY else ("phi", "phidot" if body.name == MOTOR else "w")
        x, v = self.several(self.values["initial"][body.name], *keys)
        return Body(body.name, body.m, x, v, body.kind, body.turns)

    def limited(self, section: str, parts: Any) -> Any:
        """Stops or clearances with what the start says of them; the same where it says the same."""
        at_start = [self.starts_at_limit(part) for part in self.values[section].values()] if parts else []
        if all(part.at_start == at for part, at in zip(parts, at_start, strict=True)):
            return parts
        return tuple(replace(part, at_start=at) for part, at in zip(parts, at_start, strict=True))

    def section(self, name: str) -> Any:
        """Part of the scene that a section of the case makes."""
        part = self.values.get(name, {})
        if name == "base":
            return () if "x" in part else self.harmonics(part, "a")
        if name == "motor":
            is_rotor = self.formulas is not None and self.formulas.scene.motor_is_rotor
            return self.motor(part) if part and not is_rotor else None
        make = {
            "links": self.link,
            "stops": self.stop,
            "friction": self.friction,
            "forces": self.force,
            "clearances": self.clearance,
        }[name]
        parts = [make(*each) for each in part.items()]
        if name == "forces" and self.formulas:
            parts += self.torques_and_rates(self.formulas)
        return tuple(one for one in parts if one is not None)

    def bodies(self) -> tuple[Body, ...]:
        """The bodies, then rotors and further states as bodies of their kind."""
        bodies = tuple(self.body(name, mass) for name, mass in self.values["bodies"].items())
        if self.formulas is None:
            return bodies
        return (*bodies, *self.rotating(self.formulas), *self.further())

    def of_formulas(self) -> dict[str, Any]:
        """The parts of a scene that only formulas make."""
        if self.formulas is None:
            return {"torsional": True} if form_of(self.values).torsional else {}
        base = self.formulas.node("base", "", "x") if self.formulas.has("base", "", "x") else None
        belts = self.formulas.belts() if self.formulas.belts_are_base else {}
        belt = next(iter(belts.values()), None)
        rotors = tuple(
            Rotor(self.index[name], self.index[part["on"]], self.exact(part["m"].value * part["e"].value))
            for name, part, _ in self.formulas.rotors()
        )
        return {
            "base_formula": base if belt is None else belt,
            "base_is_rate": belt is not None,
            "rotors": rotors,
            "torsional": self.formulas.scene.torsional,
            "state_units": tuple(self.state_units()),
        }

    def state_units(self) -> Iterator[tuple[str, str]]:
        """Name and SI unit of each further state."""
        from vibsim.cases.any_unit import dimension_of, si_name

        for name, part in self.values.get("states", {}).items():
            yield name, si_name(dimension_of(part["start"]))

    def exact(self, value: Fraction) -> Number:
        """A number from an exact one in SI units."""
        return self.numbers.convert(value, 0)

    def rotating(self, formulas: "FormulaParts") -> Iterator[Body]:
        """Rotors as bodies: inertia about the shaft J + m e^2 [kg m^2], angle [rad] and speed [rad/s]."""
        for name, part, start in formulas.rotors():
            inertia = part["J"].value + part["m"].value * part["e"].value ** 2
            phi, w = self.several(start, "phi", "w")
            yield Body(name, self.exact(inertia), phi, w, ROTOR)

    def further(self) -> Iterator[Body]:
        """Further states as bodies of mass 1, whose velocity is the state."""
        for name, part in self.values.get("states", {}).items():
            zero = self.exact(Fraction(0))
            yield Body(name, self.exact(Fraction(1)), zero, self.numbers.of(part["start"]), STATE)

    def torques_and_rates(self, formulas: "FormulaParts") -> list[Force]:
        """Torques on rotors [N m] and rates of further states."""
        torques = [(name, formulas.torque(name)) for name, _, _ in formulas.rotors()]
        rates = [(name, formulas.node("states", name, "rate")) for name in self.values.get("states", {})]
        zero = self.exact(Fraction(0))
        return [
            Force(name, self.index[name], zero, (), node)
            for name, node in (*torques, *rates)
            if node is not None
        ]

    def ends(self, part: Values) -> tuple[int, int]:
        return self.index[part["between"].P], self.index[part["between"].Q]

    def several(self, part: Values, *keys: str) -> list[Number]:
        return [self.numbers.of(part[key]) for key in keys]

    def body(self, name: str, mass: Quantity) -> Body:
        own = self.numbers.of(mass)
        if self.formulas is not None:
            own = self.exact(mass.value + self.formulas.rotor_mass(name))
        turns = is_inertia(mass.text) and not form_of(self.values).torsional
        x, v = self.several(self.values["initial"][name], "x", "v")
        return Body(name, own, x, v, turns=turns)

    def link(self, name: str, part: Values) -> Link:
        if "force" in part:
            assert self.formulas is not None
            zero = self.exact(Fraction(0))
            return Link(name, *self.ends(part), zero, zero, self.formulas.node("links", name, "force"))
        return Link(name, *self.ends(part), *self.several(part, "k", "c"))

    def stop(self, name: str, part: Values) -> Stop | RigidStop:
        sense, at_start = SENSES[part["acts"]], self.starts_at_limit(part)
        gap = self.numbers.of(part["gap"])
        if "force" in part:
            return self.stop_of_formula(name, part, gap, at_start)
        if part["law"] == "rigid":
            return RigidStop(name, *self.ends(part), gap, sense, self.numbers.of(part["e"]), at_start)
        k, c = self.several(part, "k", "c")
        return Stop(name, *self.ends(part), gap, sense, k, c, part["release"], at_start)

    def stop_of_formula(self, name: str, part: Values, gap: Number, at_start: bool) -> Stop:
        assert self.formulas is not None
        zero, node = self.exact(Fraction(0)), self.formulas.node("stops", name, "force")
        ends, sense = self.ends(part), SENSES[part["acts"]]
        return Stop(name, *ends, gap, sense, zero, zero, part["release"], at_start, node)

    def friction(self, name: str, part: Values) -> Friction | None:
        """Forces coefficient times N or m g, multiplied exactly and rounded once; None where all are 0."""
        P, Q = self.ends(part)
        sides = self.formulas.friction(name, part, self.weight) if self.formulas else None
        by_formula, course = isinstance(part["belt"], Formula), None
        if by_formula and self.formulas:
            if self.formulas.belts_are_base:
                P, Q = (BASE if end == GROUND else end for end in (P, Q))
            else:
                course = self.formulas.node("friction", name, "belt")
        zero = self.exact(Fraction(0))
        belt = zero if by_formula else self.numbers.of(part["belt"])
        slips = None if sides is None else (sides[0].slip, sides[1].slip)
        if sides is None:
            limits = self.limits(part)
            if not any(limits):
                return None
        else:
            nodes = [*(side.start for side in sides), *(side.hold for side in sides)]
            if course is not None or any(node[0] != "num" for node in nodes):
                by_side, rises = (sides[0].hold, sides[1].hold), (sides[0].rises, sides[1].rises)
                return Friction(name, P, Q, zero, zero, belt, None, None, slips, by_side, rises, course)
            limits = [node[1] for node in nodes]
        forward, backward, *holds = map(self.exact, limits)
        hold_forward = None if holds[0] == forward else holds[0]
        hold_backward = None if holds[1] == backward else holds[1]
        return Friction(name, P, Q, forward, backward, belt, hold_forward, hold_backward, slips)

    def limits(self, part: Values) -> list[Fraction]:
        """Forces with which slip begins forwards and backwards, and the most that a friction holds [N]."""
        load, sides = part["N"].value if "N" in part else self.weight(part), directions(part)
        return [*(side.start * load for side in sides), *(side.hold * load for side in sides)]

    def weight(self, part: Values) -> Any:
        """m g [N] of the first-named end, as an exact fraction."""
        return self.values["bodies"][part["between"].P].value * part["g"].value

    def force(self, name: str, part: Values) -> Force:
        on = self.index[part["on"]]
        if "force" in part:
            assert self.formulas is not None
            return Force(name, on, self.exact(Fraction(0)), (), self.formulas.node("forces", name, "force"))
        return Force(name, on, self.numbers.of(part["F0"]), self.harmonics(part, "A"))

    def harmonics(self, part: Values, amplitude: str) -> tuple[Harmonic, ...]:
        """The harmonics of a force (amplitude "A") or of the base ("a")."""
        terms = part["terms"].values() if "terms" in part else [part] if amplitude in part else []
        return tuple(self.harmonic(term, term[amplitude]) for term in terms)

    def harmonic(self, term: Values, amplitude: Any) -> Harmonic:
        omega = term["omega"]
        value = rule_value(amplitude, omega) if isinstance(amplitude, dict) else (amplitude.value, 0)
        cycles, cycles_lo = self.numbers.cycles(omega)
        size, phase = self.numbers.convert(*value), self.numbers.of(term["phase"])
        return Harmonic(size, self.numbers.of(omega), cycles, cycles_lo, phase)

    def motor(self, part: Values) -> Motor:
        constants = self.several(part, "m3", "e", "J", "M0", "Omega0")
        start = self.several(self.values["initial"]["motor"], "phi", "phidot")
        return Motor(self.index[part["on"]], *constants, *start)

    def clearance(self, name: str, part: Values) -> Clearance:
        distance = self.numbers.of(part["distance"])
        return Clearance(name, *self.ends(part), distance, self.starts_at_limit(part))

    def starts_at_limit(self, part: Values) -> bool:
        """Whether a stop or a clearance is at its limit at t = 0, exactly."""
        ahead = self.distance(part)
        if ahead is None:
            return False
        return (
            ahead.equals(part["distance"], 1)
            if "distance" in part
            else ahead.equals(part["gap"], -SENSES[part["acts"]])
        )

    def distance(self, part: Values) -> "ExactPlace | None":
        """x_P - x_Q [m] at t = 0, exact; None where the base, whose place is none, is one."""
        ends = [part["between"].P, part["between"].Q]
        if BASE_END in ends:
            return None
        P, Q = (
            ExactPlace.at(None if end == GROUND_END else self.values["initial"][end]["x"]) for end in ends
        )
        return ExactPlace(P.plain - Q.plain, P.turns - Q.turns)


class ExactPlace(NamedTuple):
    """An exact displacement, plain + 2 pi turns: of angles, some are given in turns."""

    plain: Fraction
    turns: Fraction

    @staticmethod
    def at(x: Quantity | None) -> "ExactPlace":
        if x is None:
            return ExactPlace(Fraction(0), Fraction(0))
        return ExactPlace(Fraction(0), x.value) if x.per_turn else ExactPlace(x.value, Fraction(0))

    def equals(self, other: Quantity, sign: int) -> bool:
        """Whether it is sign times another one."""
        there = ExactPlace.at(other)
        return self == (sign * there.plain, sign * there.turns)


def _with_plain_laws(values: Values) -> Values:
    """The same values, formulas that say what a built-in law says put as that law."""
    if not has_formulas(values):
        return values
    from vibsim.cases.plain_laws import with_plain_laws

    return with_plain_laws(values)


def _formulas_of(values: Values) -> "FormulaParts | None":
    """The formulas of a case of parts, those of frictions that fall with speed among them; None of one
    without them.
    """
    if not (has_formulas(values) or any(map(falls, values.get("friction", {}).values()))):
        return None
    from vibsim.cases.formula_building import FormulaParts

    return FormulaParts(values)
