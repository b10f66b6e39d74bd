"""Formulas of a case: checks of them and of the numbers beside them, and the parts of a scene with them."""

import re
from collections.abc import Iterator, Mapping
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

from vibsim.cases.formula_places import (
    MOTOR,
    STATE_OF,
    FormulaPlace,
    FormulaScene,
    Unreadable,
    difference,
    places_of,
)
from vibsim.cases.formula_text import FUNCTIONS, FormulaError, names_in
from vibsim.cases.formula_values import meaning_of_number, number_node
from vibsim.cases.part_laws import SIDES, Direction, directions, falls
from vibsim.cases.problems import did_you_mean, shown
from vibsim.cases.quantities import Quantity, QuantityError
from vibsim.cases.schema_keys import all_keys
from vibsim.cases.schema_kinds import FORMULA_KEYS, Formula, has_formula, of_part, sides_of
from vibsim.cases.short_form import BASE as BASE_END
from vibsim.cases.short_form import GROUND as GROUND_END
from vibsim.cases.short_form import Ends, FoundDefault
from vibsim.physics import formulas as nodes
from vibsim.physics.formulas import ONE, ZERO, Node
from vibsim.physics.parts import BASE, GROUND, HYPERBOLIC

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)
LONGEST_NAME = 24


def formula_findings(values: Mapping[str, Any]) -> list[FoundDefault]:
    """All that is wrong with formulas and the numbers beside them."""
    scene = FormulaScene(values)
    places = list(places_of(values))
    found = [finding for place in places for finding in _of_formula(scene, place)]
    for part, of_it in _by_part(places).items():
        found += _of_numbers(scene, part, of_it)
    found += _of_parameters(scene)
    return found


def _by_part(places: list[FormulaPlace]) -> dict[tuple[str, str, str], list[FormulaPlace]]:
    parts: dict[tuple[str, str, str], list[FormulaPlace]] = {}
    for place in places:
        parts.setdefault((place.section, place.name, place.side), []).append(place)
    return parts


def _of_formula(scene: FormulaScene, place: FormulaPlace) -> Iterator[FoundDefault]:
    """Problems of one formula: of its text, its names, its units."""
    word = _bare_word(scene, place)
    if word is not None:
        yield word
        return
    try:
        if place.section == "friction" and place.key == "belt":
            yield from _belt_carries_no_motor(scene, place)
        yield from _clashes(scene, place)
        scene.node(place)
        if place.key == "mu":
            yield from _at_rest(scene, place)
    except FormulaError as error:
        yield _finding(place, error)
    except Unreadable:
        return


def _belt_carries_no_motor(scene: FormulaScene, place: FormulaPlace) -> Iterator[FoundDefault]:
    """A belt by a formula that is not one base of all carries bodies without the motor of the paper."""
    if not scene.motor or scene.motor_is_rotor or FormulaParts(dict(scene.values)).belts_are_base:
        return
    body = motor_body(scene)
    if body in _tied_to(scene, place.name):
        message = (
            "a belt by a formula between bodies, or beside a base, may not carry a body with a motor by M0 "
            f"and Omega0 alone: it carries {body}, by itself or through other frictions and rigid stops; "
            'write torque: "M0*(1 - w/Omega0)" for the motor'
        )
        yield FoundDefault(place.path, message)


def motor_body(scene: FormulaScene) -> str:
    """Name of the body that the motor is on."""
    motor = scene._part("motor", "") if "motor" in scene.values else {"on": "1"}
    return str(motor.get("on"))


def belt_carries(scene: FormulaScene, body: str) -> bool:
    """Whether a belt by a formula may carry a body, by itself or through other frictions and rigid stops."""
    frictions = _section(scene.values, "friction").items()
    belts = [name for name, part in frictions if has_formula("friction", part, "belt")]
    return any(body in _tied_to(scene, name) for name in belts)


def _tied_to(scene: FormulaScene, friction: str) -> set[str]:
    """The bodies that frictions and rigid stops may tie to the ends of a friction, and these."""
    pairs = []
    for section in ("friction", "stops"):
        for name, part in _section(scene.values, section).items():
            ends = Ends.read(part.get("between"))
            if ends is not None and (section == "friction" or str(part.get("law")) == "rigid"):
                pairs.append((section, name, {ends.P, ends.Q} - {GROUND_END, BASE_END}))
    tied = next(ends for section, name, ends in pairs if (section, name) == ("friction", friction))
    while True:
        more = set().union(*(ends for _, _, ends in pairs if ends & tied)) - tied
        if not more:
            return tied
        tied = tied | more


def _at_rest(scene: FormulaScene, place: FormulaPlace) -> Iterator[FoundDefault]:
    """mu must have a value at s = 0, which is what it holds."""
    try:
        scene.node(place, s=ZERO)
    except FormulaError as error:
        yield _finding(place, FormulaError(f"at s = 0, {error}", error.start, error.end))


def _bare_word(scene: FormulaScene, place: FormulaPlace) -> FoundDefault | None:
    """A word in place of a number, where that is no name: it is reported as in a case without formulas."""
    word = place.text.strip()
    measured = all_keys(scene.form).get(scene.form.pattern(place.path))
    if measured is None or not NAME.fullmatch(word):
        return None
    try:
        if word in scene.names(place):
            return None
        measured._replace(formula=False).read(word)
    except Unreadable:
        return None
    except QuantityError as error:
        return FoundDefault(place.path, str(error))
    return None


def _finding(place: FormulaPlace, error: FormulaError) -> FoundDefault:
    quoted = shown(place.text, 80)
    return FoundDefault(place.path, f'"{quoted}": {error}', span=(error.start, error.end))


def _clashes(scene: FormulaScene, place: FormulaPlace) -> Iterator[FoundDefault]:
    """A parameter, or a state, that a formula reads and that has the name of something else there."""
    own = scene.own(place)
    for name in names_in(place.text):
        if name not in own:
            continue
        for section in ("parameters", "states"):
            if name in _section(scene.values, section):
                own_meaning = f"{name} is {_meaning(place, name)} here, and {section}.{name} too"
                message = f'"{shown(place.text, 80)}": {own_meaning}; give that another name'
                yield FoundDefault(place.path, message)


def _meaning(place: FormulaPlace, name: str) -> str:
    return {
        "d": "x_P - x_Q",
        "v": "v_P - v_Q",
        "p": "the depth",
        "pv": "the rate of the depth",
        "s": "the slip speed",
        "phi": "the rotor's angle",
        "w": "the rotor's speed",
    }[name]


def _section(values: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    content = values.get(name)
    return content if isinstance(content, Mapping) else {}


def _of_numbers(
    scene: FormulaScene, part: tuple[str, str, str], places: list[FormulaPlace]
) -> Iterator[FoundDefault]:
    """Numbers beside formulas: each is named by one of them, and called by a name that is free."""
    section, name, side = part
    content = scene._part(section, name)
    inner = content.get(side) if side else content
    if len(_active(section, content, side)) > len(places):
        return  # one of the formulas cannot be read
    named = {word for place in places for word in names_in(place.text)}
    if not side:
        named |= {
            word
            for inside, keys in sides_of(section, content).items()
            for one in keys
            for word in names_in(str(content[inside][one.key]))
        }
    free = {word for one in _active(section, content, side) for word in one.numbers}
    excluded = {word for one in _active(section, content, side) for word in one.excluded}
    taken = _taken(scene, places)
    for key in inner if isinstance(inner, Mapping) else ():
        path = f"{places[0].part}.{key}"
        known = scene.form.pattern(path) in all_keys(scene.form) or key in ("plus", "minus")
        if known and key not in free:
            continue
        if any(place.key == key or key in excluded for place in places):
            continue
        yield from _of_number(path, key, named, taken, places)


def _active(section: str, content: Mapping[str, Any], side: str) -> list[Any]:
    return [*FORMULA_KEYS[section][:1]] if side else of_part(section, content)


def _of_number(
    path: str, key: str, named: set[str], taken: dict[str, str], places: list[FormulaPlace]
) -> Iterator[FoundDefault]:
    if not NAME.fullmatch(key) or len(key) > LONGEST_NAME:
        message = (
            f"the name of a number holds letters, digits and _, begins with a letter and has at most "
            f"{LONGEST_NAME} characters; got {shown(key)}"
        )
        yield FoundDefault(path, message, of_the_name=True)
    elif key in taken:
        message = f"the name is taken in formulas here: {key} is {taken[key]}; choose another"
        yield FoundDefault(path, message, of_the_name=True)
    elif key not in named:
        formulas = " and ".join(place.key for place in places)
        names = [name for name in sorted(named) if name not in taken]
        message = f"no formula beside it names {key}{did_you_mean(key, names)}; {formulas} reads "
        yield FoundDefault(path, message + (", ".join(names) or "no numbers"), of_the_name=True)


def _taken(scene: FormulaScene, places: list[FormulaPlace]) -> dict[str, str]:
    """Names that numbers beside these formulas may not have, and what they are."""
    taken = dict.fromkeys(FUNCTIONS, "a function")
    taken |= dict.fromkeys(scene.inputs(), "what every formula may read")
    taken |= {"t": "the time", "pi": "the number pi"}
    taken |= {name: f"the state {name}" for name in scene.states}
    for place in places:
        own = STATE_OF.get(place.section, ()) if place.section != "friction" or place.key == "mu" else ()
        taken |= {name: _meaning(place, name) for name in own}
    return taken


def _of_parameters(scene: FormulaScene) -> Iterator[FoundDefault]:
    """Names of parameters that are free in all formulas."""
    inputs = scene.inputs()
    for name in _section(scene.values, "parameters"):
        path = f"parameters.{name}"
        if not NAME.fullmatch(name) or len(name) > LONGEST_NAME:
            message = (
                f"the name of a parameter holds letters, digits and _, begins with a letter and has at most "
                f"{LONGEST_NAME} characters; got {shown(name)}"
            )
            yield FoundDefault(path, message, of_the_name=True)
        elif name in inputs or name in FUNCTIONS:
            what = "a function" if name in FUNCTIONS else "something that formulas read already"
            yield FoundDefault(path, f"the name is taken: {name} is {what}; choose another", of_the_name=True)


# Parts of a scene with formulas: links, stops, frictions, forces, rotors and further states.


Values = dict[str, Any]


class FormulaParts:
    """The formulas of a case of parts as nodes.

    values : its nested values in the long form, defaults filled in
    """

    def __init__(self, values: Values):
        self.values = values
        self.scene = FormulaScene(values)

    def node(self, section: str, name: str, key: str, side: str = "", **instead: Node) -> Node:
        """The node of the formula at a key of a part."""
        part = self.values[section] if not name else self.values[section][name]
        text = str((part[side] if side else part)[key])
        return self.scene.node(FormulaPlace(section, name, side, key, text), **instead)

    def has(self, section: str, name: str, key: str) -> bool:
        part = self.values.get(section, {})
        return has_formula(section, part.get(name) if name else part, key)

    def number_or_node(self, section: str, name: str, key: str) -> Node:
        """A number of a part as a node, or its formula."""
        part = self.values[section][name] if name else self.values[section]
        if isinstance(part[key], Quantity):
            return meaning_of_number(part[key]).node
        return self.node(section, name, key)

    # Friction.

    def friction(self, name: str, part: Values, weight: Any) -> "tuple[SlipForces, SlipForces] | None":
        """The forces of a friction forwards and backwards; None where they are numbers.

        weight : () -> m g of the first end [N], exact
        """
        on_its_own = isinstance(part["belt"], Formula) and not self.belts_are_base
        by_formulas = on_its_own or self.has("friction", name, "mu") or self.has("friction", name, "N")
        load = self._load(name, part, weight)
        if not (sides_of("friction", part) or by_formulas or (falls(part) and load != ZERO)):
            return None
        P, Q = self.scene.ends(FormulaPlace("friction", name, "", "mu", ""))
        if on_its_own:
            slip = nodes.sub(difference("v", P, Q), self.node("friction", name, "belt"))
        elif isinstance(part["belt"], Formula):
            P, Q = (BASE if end == GROUND else end for end in (P, Q))
            slip = difference("v", P, Q)
        else:
            slip = nodes.sub(difference("v", P, Q), meaning_of_number(part["belt"]).node)
        forward, backward = (self._coefficient(name, part, i) for i in (0, 1))
        return forward.forces(slip, load), backward.forces(nodes.neg(slip), load)

    @cached_property
    def belts_are_base(self) -> bool:
        """Whether belts by formulas move as a base does that nothing else is on: all alike, on the ground of
        a scene with a rotor and without a base.
        """
        ends = [
            Ends.read(part.get("between"))
            for name, part in self.values.get("friction", {}).items()
            if has_formula("friction", part, "belt")
        ]
        on_ground = all(one is not None and GROUND_END in (one.P, one.Q) for one in ends)
        alike = "base" not in self.values and on_ground and len(set(self.belts().values())) <= 1
        return alike and bool(self.values.get("rotors") or self.values.get("motor"))

    def belts(self) -> dict[str, Node]:
        """Velocities of the belts that move by formulas, by friction: of the surface on the ground, be it Q
        or P [m/s].
        """
        found: dict[str, Node] = {}
        for name, part in self.values.get("friction", {}).items():
            ends = Ends.read(part.get("between"))
            if has_formula("friction", part, "belt") and ends is not None:
                node = self.node("friction", name, "belt")
                found[name] = node if ends.Q == GROUND_END else nodes.neg(node)
        return found

    def _load(self, name: str, part: Values, weight: Any) -> Node:
        """max(0, N)."""
        if "N" not in part:
            return nodes.num(weight(part))
        load = self.number_or_node("friction", name, "N")
        return nodes.largest(load, ZERO, f"N of {name}")

    def _coefficient(self, name: str, part: Values, i: int) -> "_Coefficient":
        side = SIDES[i] if SIDES[i] in part else ""
        values = part[side] if side else part
        if isinstance(values.get("mu"), Formula):
            static = values["static"].value if "static" in values else Fraction(1)
            return _OfFormula(self, name, side, static)
        return _OfLaw(part, directions(part)[i] if not sides_of("friction", part) else _of_side(values))

    # Rotors and states.

    def rotors(self) -> Iterator[tuple[str, Values, dict[str, Quantity]]]:
        """Name, keys and start of each rotor, of a motor with a formula under the name motor."""
        initial = self.values["initial"]
        for name, part in self.values.get("rotors", {}).items():
            yield name, part, {"phi": initial[name]["phi"], "w": initial[name]["w"]}
        if self.scene.motor_is_rotor:
            part = self.values["motor"]
            start = initial["motor"]
            yield MOTOR, part | {"m": part["m3"]}, {"phi": start["phi"], "w": start["phidot"]}

    def torque(self, name: str) -> Node | None:
        """The torque on a rotor; None where there is none."""
        section, own = ("motor", "") if name == MOTOR else ("rotors", name)
        part = self.values["motor"] if name == MOTOR else self.values["rotors"][name]
        if "torque" in part:
            return self.node(section, own, "torque")
        if "M0" not in part:
            return None
        M0, Omega0 = (self.number_or_node(section, own, key) for key in ("M0", "Omega0"))
        share = nodes.div(("v", self.scene.index[name]), Omega0)
        return nodes.mul(M0, nodes.sub(ONE, share))

    def rotor_mass(self, body: str) -> Fraction:
        """Mass of the rotors on a body [kg]."""
        masses = [part["m"].value for _, part, _ in self.rotors() if part["on"] == body]
        return sum(masses, Fraction(0))


class SlipForces(NamedTuple):
    """Forces of a friction in one direction [N]: while slipping, where slip begins and ends, and the most
    that it holds; rises : whether that is above what slip begins with.
    """

    slip: Node
    start: Node
    hold: Node
    rises: bool


class _Coefficient:
    """A coefficient of friction in one direction: while slipping at a speed, the most that it holds, and
    whether that is above what slip begins with.
    """

    hold: Node
    rises: bool

    def slip(self, speed: Node) -> Node:
        raise NotImplementedError

    def forces(self, speed: Node, load: Node) -> SlipForces:
        """The coefficient times a load [N], at a speed of slip."""
        slip, start, hold = (nodes.mul(one, load) for one in (self.slip(speed), self.slip(ZERO), self.hold))
        return SlipForces(slip, start, hold, self.rises)


class _OfFormula(_Coefficient):
    def __init__(self, parts: FormulaParts, name: str, side: str, static: Fraction):
        self.parts, self.name, self.side = parts, name, side
        self.hold = nodes.mul(nodes.num(static), self.slip(ZERO))
        self.rises = static != 1

    def slip(self, speed: Node) -> Node:
        """The coefficient at a slip speed, which is never negative: |s| is s, and no switch."""
        node = self.parts.node("friction", self.name, "mu", self.side, s=speed)
        return nodes.where_positive(node, speed)


class _OfLaw(_Coefficient):
    """A built-in law, mu_d + (mu_s - mu_d) f(rate s), under a load that is a formula."""

    def __init__(self, part: Values, side: Direction):
        self.law, self.side = part.get("law"), side
        self.hold = nodes.num(side.hold)
        self.rises = side.hold != side.start

    def slip(self, speed: Node) -> Node:
        side = self.side
        if not side.drop:
            return nodes.num(side.slip)
        share = nodes.mul(number_node(side.rate, 0), speed)
        fall = (
            nodes.div(ONE, nodes.add(ONE, share))
            if self.law == HYPERBOLIC
            else nodes.call("exp", nodes.neg(share))
        )
        return nodes.add(nodes.num(side.slip), nodes.mul(nodes.num(side.drop), fall))


def _of_side(values: Mapping[str, Any]) -> Direction:
    """The Coulomb coefficients of one direction, beside a formula of the other."""
    mu = values["mu"].value
    return Direction(mu, mu * (values["static"].value if "static" in values else 1))
