"""Parts of a scene with formulas: links, stops, frictions, forces, rotors and further states."""

from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any

from vibsim.cases.formula_keys import Formula, has_formula, sides_of
from vibsim.cases.formula_places import MOTOR, FormulaPlace, FormulaScene, difference
from vibsim.cases.formula_values import meaning_of_number, number_node
from vibsim.cases.part_laws import SIDES, Direction, directions
from vibsim.cases.quantities import Quantity
from vibsim.cases.short_form import GROUND as GROUND_END
from vibsim.physics import formulas as nodes
from vibsim.physics.formulas import ONE, ZERO, Node
from vibsim.physics.friction_laws import HYPERBOLIC
from vibsim.physics.parts import BASE, GROUND

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

    def friction(
        self, name: str, part: Values, weight: Any
    ) -> tuple[tuple[Node, Node], tuple[Node, Node], bool] | None:
        """Forces while slipping, and the most that it holds, forwards and backwards, and whether that is
        above what slip begins with; None without formulas.

        weight : () -> m g of the first end [N], exact
        """
        sides = sides_of("friction", part)
        if not (sides or self.has("friction", name, "mu") or self.has("friction", name, "N")):
            return None
        load = self._load(name, part, weight)
        P, Q = self.scene.ends(FormulaPlace("friction", name, "", "mu", ""))
        if isinstance(part["belt"], Formula):
            P, Q = (BASE if end == GROUND else end for end in (P, Q))
            slip = difference("v", P, Q)
        else:
            slip = nodes.sub(difference("v", P, Q), meaning_of_number(part["belt"]).node)
        speeds = (slip, nodes.neg(slip))
        slips, holds, rises = [], [], False
        for i, speed in enumerate(speeds):
            coefficient = self._coefficient(name, part, i)
            slips.append(nodes.mul(coefficient.slip(speed), load))
            holds.append(nodes.mul(coefficient.hold, load))
            rises = rises or coefficient.rises
        return (slips[0], slips[1]), (holds[0], holds[1]), rises

    def belts(self) -> dict[str, Node]:
        """Velocities of the belts that move by formulas, by friction: of the surface on the ground, be it Q
        or P [m/s].
        """
        found: dict[str, Node] = {}
        for name, part in self.values.get("friction", {}).items():
            if isinstance(part.get("belt"), Formula):
                node = self.node("friction", name, "belt")
                found[name] = node if part["between"].Q == GROUND_END else nodes.neg(node)
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


class _Coefficient:
    """A coefficient of friction in one direction: while slipping at a speed, the most that it holds, and
    whether that is above what slip begins with.
    """

    hold: Node
    rises: bool

    def slip(self, speed: Node) -> Node:
        raise NotImplementedError


class _OfFormula(_Coefficient):
    def __init__(self, parts: FormulaParts, name: str, side: str, static: Fraction):
        self.parts, self.name, self.side = parts, name, side
        self.hold = nodes.mul(nodes.num(static), self.slip(ZERO))
        self.rises = static != 1

    def slip(self, speed: Node) -> Node:
        return self.parts.node("friction", self.name, "mu", self.side, s=speed)


class _OfLaw(_Coefficient):
    """A built-in law, mu_d + (mu_s - mu_d) f(rate s), under a load that is a formula."""

    def __init__(self, part: Values, side: Direction):
        self.law, self.side = part.get("law"), side
        self.hold = nodes.num(side.hold)
        self.rises = side.hold != side.slip + side.drop

    def slip(self, speed: Node) -> Node:
        side = self.side
        if not side.drop:
            return nodes.num(side.slip)
        share = nodes.mul(number_node(side.rate, 0), speed)
        falls = (
            nodes.div(ONE, nodes.add(ONE, share))
            if self.law == HYPERBOLIC
            else nodes.call("exp", nodes.neg(share))
        )
        return nodes.add(nodes.num(side.slip), nodes.mul(nodes.num(side.drop), falls))


def _of_side(values: Mapping[str, Any]) -> Direction:
    """The Coulomb coefficients of one direction, beside a formula of the other."""
    mu = values["mu"].value
    return Direction(mu, mu * (values["static"].value if "static" in values else 1))
