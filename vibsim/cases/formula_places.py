"""The places of a scene in which formulas stand: their dimension there, and the meaning of each name in them.

A formula reads the numbers beside it, those of `parameters`, names of its own place (d and v of a link), the
time t, pi, further states, and x_NAME, v_NAME, phi_NAME, w_NAME of bodies and rotors.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from vibsim.cases.any_unit import (
    FORCE,
    LENGTH,
    PURE,
    RATE,
    TIME,
    TORQUE,
    VELOCITY,
    Dimension,
    any_quantity,
    dimension_of,
    product,
)
from vibsim.cases.formula_text import FormulaError, names_in
from vibsim.cases.formula_values import Meaning, formula_node, meaning_of_number
from vibsim.cases.quantities import Quantity, QuantityError, is_inertia
from vibsim.cases.schema_keys import Form, all_keys, form_of
from vibsim.cases.schema_kinds import FORMULA_KEYS, ONE_PART, Formula, FormulaKey, of_part, sides_of
from vibsim.cases.short_form import BASE as BASE_END
from vibsim.cases.short_form import GROUND as GROUND_END
from vibsim.cases.short_form import Ends
from vibsim.physics import formulas as nodes
from vibsim.physics.formulas import PI, ZERO, Node
from vibsim.physics.parts import BASE, GROUND, columns_of

STATE_OF = {"links": ("d", "v"), "stops": ("p", "pv"), "friction": ("s",), "rotors": ("phi", "w")}
MOTOR = "motor"


class FormulaPlace(NamedTuple):
    """A formula in a case.

    Attributes
    ----------
    section : its section
    name : of the part; empty for base and motor
    side : "plus" or "minus" of a friction, or empty
    key : the key that holds it
    text : the formula
    """

    section: str
    name: str
    side: str
    key: str
    text: str

    @property
    def part(self) -> str:
        """Dotted key of the part, or of plus and minus in it, beside whose numbers the formula stands."""
        return ".".join(word for word in (self.section, self.name, self.side) if word)

    @property
    def path(self) -> str:
        """Dotted key of the formula."""
        return f"{self.part}.{self.key}"


def places_of(values: Mapping[str, Any]) -> Iterator[FormulaPlace]:
    """The formulas of a case, by its nested values."""
    for section in FORMULA_KEYS:
        content = values.get(section)
        if not isinstance(content, Mapping):
            continue
        parts = {"": content} if section in ONE_PART else content
        for name, part in parts.items():
            if not isinstance(part, Mapping):
                continue
            for one in of_part(section, part):
                if isinstance(part[one.key], str | int | float | Formula):
                    yield FormulaPlace(section, name, "", one.key, str(part[one.key]))
            for side, keys in sides_of(section, part).items():
                for one in keys:
                    yield FormulaPlace(section, name, side, one.key, str(part[side][one.key]))


class Unreadable(Exception):
    """A formula reads a number that cannot be read, which is reported at its own place."""


class FormulaScene:
    """The names that formulas may read in a case.

    values : its nested values, texts or what is read from them, of either form
    """

    def __init__(self, values: Mapping[str, Any]):
        self.values = values
        self.form: Form = form_of(values)
        self.torsional, self.mixed = self.form.torsional, self.form.mixed
        self.bodies = self._names("bodies")
        self.states = self._names("states")
        self.rotors = self._names("rotors")
        self.motor = isinstance(values.get("motor"), Mapping)
        self.motor_is_rotor = bool(self.motor and of_part("motor", values["motor"]))
        if "excitation" in values:
            self._of_short_form(values)
        self.index = self._index()
        # what moves its body depends on the angles of all rotors that it may come to move together with
        if self.motor and not self.motor_is_rotor:
            self.motor_is_rotor = bool(self.rotors) or self._turns_are_counted()
            self.index = self._index()

    def _index(self) -> dict[str, int]:
        """Columns of bodies, rotors and states by their names."""
        turning = [*self.rotors, *([MOTOR] if self.motor_is_rotor else [])]
        return {name: i for i, name in enumerate([*self.bodies, *turning, *self.states])}

    def _turns_are_counted(self) -> bool:
        """Whether a formula reads the angle of the motor otherwise than within a turn: an engine keeps that
        of a rotor in full, that of the paper's motor in its turn.
        """
        for place in places_of(self.values):
            if place.section == "rotors" or "phi" not in names_in(place.text):
                continue
            try:
                if not nodes.is_periodic(self.node(place), ("phi",)):
                    return True
            except (FormulaError, Unreadable):
                continue
        return False

    def _of_short_form(self, values: Mapping[str, Any]) -> None:
        """The two blocks are the bodies 1 and 2, the motor is that of the excitation."""
        blocks, source = values.get("blocks"), values.get("excitation")
        fixed = isinstance(blocks, Mapping) and str(blocks.get("m2")) == "fixed"
        self.bodies = ["1"] if fixed else ["1", "2"]
        self.motor = isinstance(source, Mapping) and source.get("kind") == "motor"
        self.motor_is_rotor = self.motor and bool(of_part("excitation", source))

    def _names(self, section: str) -> list[str]:
        content = self.values.get(section)
        return [*content] if isinstance(content, Mapping) else []

    # Dimensions.

    def turns(self, body: str) -> bool:
        """Whether a body turns."""
        masses = self._part("bodies", "") if self.mixed else {}
        return self.torsional or is_inertia(str(masses.get(body)))

    def _turns_at(self, place: FormulaPlace) -> bool:
        """Whether the part of a formula is one of turning bodies."""
        if not self.mixed:
            return self.torsional
        part = self._part(place.section, place.name)
        ends = Ends.read(part.get("between"))
        bodies = [str(part.get("on"))] if ends is None else [ends.P, ends.Q]
        return any(self.turns(body) for body in bodies)

    def wanted(self, place: FormulaPlace) -> tuple[Dimension | None, str]:
        """Dimension that a formula must have, and the name of that quantity."""
        turns = self._turns_at(place)
        force = TORQUE if turns else FORCE
        if place.key in ("force", "N"):
            return force, "a torque" if turns else "a force" if place.key == "force" else "a load"
        if place.key == "rate":
            state = self.state_dimension(place.name)
            return None if state is None else product(state, TIME, -1), "the unit of its start per second"
        return {
            "mu": (PURE, "a coefficient"),
            "belt": (RATE if turns else VELOCITY, "a velocity"),
            "torque": (TORQUE, "a torque"),
            "M0": (TORQUE, "a torque"),
            "Omega0": (RATE, "an angular rate"),
            "x": (PURE, "an angle") if self.torsional else (LENGTH, "a displacement"),
        }[place.key]

    def state_dimension(self, name: str) -> Dimension | None:
        """Of a further state, that of its start; None where that cannot be read."""
        part = self._part("states", name)
        start = part.get("start", "0")
        quantity = self._quantity("states", name, "start", start, free=True)
        return None if quantity is None else dimension_of(quantity)

    # Numbers.

    def _part(self, section: str, name: str) -> Mapping[str, Any]:
        content = self.values.get(section)
        if section in ONE_PART or not name:
            part = content
        else:
            part = content.get(name) if isinstance(content, Mapping) else None
        return part if isinstance(part, Mapping) else {}

    def _quantity(self, section: str, name: str, key: str, value: Any, free: bool) -> Quantity | None:
        """A number of a part; free: of any unit. None where it cannot be read, or is none."""
        if isinstance(value, Quantity):
            return value
        if not isinstance(value, str):
            return None
        path = f"{section}.{key}" if section in ONE_PART else f"{section}.{name}.{key}"
        measured = all_keys(self.form).get(self.form.pattern(path))
        try:
            if free or measured is None:
                return any_quantity(value)[0]
            quantity = measured.read(value)
        except QuantityError:
            return None
        return quantity if isinstance(quantity, Quantity) else None

    def numbers_beside(self, place: FormulaPlace) -> dict[str, Quantity | None]:
        """The numbers of the part that a formula may name; None for those that cannot be read."""
        part = self._part(place.section, place.name)
        found = self._numbers_of(place, part, of_part(place.section, part), "")
        inner = part.get(place.side) if place.side else None
        if isinstance(inner, Mapping):
            keys = FORMULA_KEYS[place.section][:1]
            found |= self._numbers_of(place, inner, [*keys], f"{place.side}.")
        return found

    def _numbers_of(
        self, place: FormulaPlace, part: Mapping[str, Any], active: list[FormulaKey], prefix: str
    ) -> dict[str, Quantity | None]:
        free = {name for one in active for name in one.numbers}
        formulas = {one.key for one in active}
        known = all_keys(self.form)
        numbers: dict[str, Quantity | None] = {}
        for key, value in part.items():
            path = place._replace(key=f"{prefix}{key}", side="").path
            is_free = key in free or self.form.pattern(path) not in known
            if key in formulas or isinstance(value, Mapping | Ends):
                continue
            if not is_free and known.get(self.form.pattern(path)) is None and not isinstance(value, Quantity):
                continue  # a word, or the start of a state
            numbers[key] = self._quantity(place.section, place.name, f"{prefix}{key}", value, is_free)
        return numbers

    def parameters(self) -> dict[str, Quantity | None]:
        content = self.values.get("parameters")
        parts = content.items() if isinstance(content, Mapping) else ()
        return {name: self._quantity("parameters", name, "", value, free=True) for name, value in parts}

    # Names.

    @staticmethod
    def time_alone() -> dict[str, Meaning]:
        return {"t": Meaning(nodes.TIME, TIME), "pi": Meaning(PI, PURE)}

    def inputs(self) -> dict[str, Meaning]:
        """Names that every formula may read: the time, pi, states, and the motion of bodies and rotors."""
        known = self.time_alone()
        for name in self.states:
            known[name] = Meaning(("v", self.index[name]), self.state_dimension(name))
        for name in self.bodies:
            x, v = columns_of(name)
            turns = self.turns(name)
            known[x] = Meaning(("x", self.index[name]), PURE if turns else LENGTH)
            known[v] = Meaning(("v", self.index[name]), RATE if turns else VELOCITY)
        for name in self.rotors:
            known[f"phi_{name}"] = Meaning(("x", self.index[name]), PURE)
            known[f"w_{name}"] = Meaning(("v", self.index[name]), RATE)
        if self.motor:
            known |= self._motor_inputs()
        return known

    def _motor_inputs(self) -> dict[str, Meaning]:
        if not self.motor_is_rotor:
            return {"phi": Meaning(("phi",), PURE), "w": Meaning(("w",), RATE)}
        i = self.index[MOTOR]
        return {"phi": Meaning(("x", i), PURE), "w": Meaning(("v", i), RATE)}

    def own(self, place: FormulaPlace) -> dict[str, Meaning]:
        """The names of a formula's own place."""
        x, v = (PURE, RATE) if self._turns_at(place) else (LENGTH, VELOCITY)
        if place.section == "links":
            P, Q = self.ends(place)
            return {"d": Meaning(difference("x", P, Q), x), "v": Meaning(difference("v", P, Q), v)}
        if place.section == "stops":
            depth, rate = self.depth(place)
            return {"p": Meaning(depth, x), "pv": Meaning(rate, v)}
        if place.section == "friction" and place.key == "mu":
            P, Q = self.ends(place)
            return {"s": Meaning(difference("v", P, Q), v)}
        if place.section == "rotors":
            i = self.index[place.name]
            return {"phi": Meaning(("x", i), PURE), "w": Meaning(("v", i), RATE)}
        return {}

    def ends(self, place: FormulaPlace) -> tuple[int, int]:
        """Columns of the ends of a part. Raises Unreadable."""
        ends = Ends.read(self._part(place.section, place.name).get("between"))
        index = self.index | {GROUND_END: GROUND, BASE_END: BASE}
        if ends is None or ends.P not in index or ends.Q not in index:
            raise Unreadable
        return index[ends.P], index[ends.Q]

    def depth(self, place: FormulaPlace) -> tuple[Node, Node]:
        """Depth of a stop and its rate: sense (x_Q - x_P) - gap."""
        P, Q = self.ends(place)
        part = self._part(place.section, place.name)
        gap = self._quantity(place.section, place.name, "gap", part.get("gap"), free=False)
        if gap is None or part.get("acts") not in ("extension", "compression"):
            raise Unreadable
        first, second = (P, Q) if part["acts"] == "compression" else (Q, P)
        depth = nodes.sub(difference("x", first, second), meaning_of_number(gap).node)
        return depth, difference("v", first, second)

    def names(self, place: FormulaPlace, **instead: Node) -> dict[str, Meaning]:
        """All that a formula may read; the nearest of equal names. instead : other nodes for own names.

        Raises Unreadable where a number that it names cannot be read.
        """
        in_time = place.section == "base" or place.key == "belt"
        inputs = self.time_alone() if in_time else self.inputs()
        own = {name: one._replace(node=instead.get(name, one.node)) for name, one in self.own(place).items()}
        numbers = self.parameters() | self.numbers_beside(place)
        read = names_in(place.text)
        known = {}
        for name, quantity in numbers.items():
            if quantity is not None:
                known[name] = meaning_of_number(quantity)
            elif name in read:
                raise Unreadable
        return known | inputs | own

    def node(self, place: FormulaPlace, **instead: Node) -> Node:
        """The node of a formula. Raises FormulaError, and Unreadable."""
        names = self.names(place, **instead)
        if any(names[name].dimension is None for name in names_in(place.text) if name in names):
            raise Unreadable
        wanted, called = self.wanted(place)
        return formula_node(place.text, names, wanted, called)


def difference(kind: str, P: int, Q: int) -> Node:
    """x_P - x_Q, or v_P - v_Q; the ground is at 0."""
    first, second = (ZERO if end == GROUND else (kind, end) for end in (P, Q))
    return nodes.sub(first, second)
