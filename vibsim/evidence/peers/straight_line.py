"""Equations written once for numbers of any kind, turned into straight-line Python functions.

An `OperationLog` hands out numbers that note down what is done with them. What scipy's solvers call again and
again is then a list of assignments to local variables: no loop over parts is left in it. Behind it: formulas
read into such numbers, the parts and formulas that switch, and the linear algebra of ties.
"""

import math
import re
from bisect import bisect_right
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from vibsim.physics.connections import base_formulas, formulas_of
from vibsim.physics.formulas import (
    FUNCTIONS,
    SWITCHES,
    TIME,
    ZERO,
    Node,
    derivative,
    mul,
    num,
    piece_of_table,
    reads,
    walk,
)
from vibsim.physics.parts import AT_FORCE, BASE, Friction, RigidStop, Scene

NAMES: dict[str, Any] = {
    **{name: value for name, value in vars(math).items() if not name.startswith("_")},
    "sgn": lambda v: math.copysign(1.0, v) if v else 0.0,
    "power": lambda a, p: a**p if a > 0 else 0.0**p,  # a base that rounding has made negative counts as 0
}


class OperationLog:
    """A number kit whose numbers are local variables of a function of time, state and parameters.

    skin : depth [m] below which a power of a depth is not read, as of heyoka; 0 of solvers that read it at 0
    """

    def __init__(self, states: int, parameters: int = 0, skin: float = 0.0):
        self.skin, self._tables = skin, dict[str, Callable[[float], float]]()
        self.t = Noted(self, "t")
        self.states = [Noted(self, f"s{i}") for i in range(states)]
        self.parameters = [Noted(self, f"p{i}") for i in range(parameters)]
        self._lines = _unpacked("state", self.states) + _unpacked("parameters", self.parameters)

    def note(self, text: str) -> "Noted":
        """The variable that is assigned `text`."""
        name = f"a{len(self._lines)}"
        self._lines.append(f"{name} = {text}")
        return Noted(self, name)

    def call(self, name: str, a: Any) -> "Noted":
        """A function of NAMES."""
        return self.note(f"{name}({_text(a)})")

    def sin(self, a: Any) -> "Noted":
        return self.call("sin", a)

    def cos(self, a: Any) -> "Noted":
        return self.call("cos", a)

    def exp(self, a: Any) -> "Noted":
        return self.call("exp", a)

    def tanh(self, a: Any) -> "Noted":
        return self.call("tanh", a)

    def power(self, a: Any, p: float) -> "Noted":
        """a**p, a >= 0."""
        return self.note(f"power({_text(a)}, {p!r})")

    def choose(self, flag: Any, yes: Any, no: Any) -> "Noted":
        """`yes` where the flag is 1, `no` where it is 0."""
        return self.note(f"{_text(yes)} if {_text(flag)} else {_text(no)}")

    def table(self, function: Callable[[float], float], a: Any) -> "Noted":
        """function(a)."""
        name = f"table{len(self._tables)}"
        self._tables[name] = function
        return self.note(f"{name}({_text(a)})")

    def sgn(self, a: Any) -> "Noted":
        """-1, 0 or 1."""
        return self.note(f"sgn({_text(a)})")

    def where(self, a: Any, yes: Any, no: Any) -> "Noted":
        """`yes` where a >= 0, else `no`."""
        return self.note(f"{_text(yes)} if {_text(a)} >= 0.0 else {_text(no)}")

    def function(self, values: Sequence[Any]) -> Callable[..., Any]:
        """The function (t, state, parameters) that returns the tuple of `values`."""
        answer = "".join(f"{_text(value)}, " for value in values)
        lines = ["def function(t, state, parameters=()):", *self._needed(answer), f"return ({answer})"]
        scope: dict[str, Any] = {}
        exec("\n    ".join(lines), NAMES | self._tables, scope)
        function: Callable[..., Any] = scope["function"]
        return function

    def _needed(self, answer: str) -> list[str]:
        """The lines that the answer is made of."""
        needed, lines = set(VARIABLE.findall(answer)), []
        for line in reversed(self._lines):
            name, _, text = line.partition(" = ")
            if name in needed or name.endswith(","):  # s0, s1, = state
                lines.append(line)
                needed.update(VARIABLE.findall(text))
        return lines[::-1]


VARIABLE = re.compile(r"\ba\d+\b")


class Noted:
    """A number of a tape."""

    def __init__(self, tape: OperationLog, name: str):
        self.tape, self.name = tape, name

    def __add__(self, other: Any) -> "Noted":
        return self.tape.note(f"{self.name} + {_text(other)}")

    def __radd__(self, other: Any) -> "Noted":
        return self.tape.note(f"{_text(other)} + {self.name}")

    def __sub__(self, other: Any) -> "Noted":
        return self.tape.note(f"{self.name} - {_text(other)}")

    def __rsub__(self, other: Any) -> "Noted":
        return self.tape.note(f"{_text(other)} - {self.name}")

    def __mul__(self, other: Any) -> "Noted":
        return self.tape.note(f"{self.name} * {_text(other)}")

    def __rmul__(self, other: Any) -> "Noted":
        return self.tape.note(f"{_text(other)} * {self.name}")

    def __truediv__(self, other: Any) -> "Noted":
        return self.tape.note(f"{self.name} / {_text(other)}")

    def __rtruediv__(self, other: Any) -> "Noted":
        return self.tape.note(f"{_text(other)} / {self.name}")

    def __neg__(self) -> "Noted":
        return self.tape.note(f"-{self.name}")


def _text(value: Any) -> str:
    return value.name if isinstance(value, Noted) else repr(float(value))


def _unpacked(called: str, names: Sequence[Noted]) -> list[str]:
    return ["".join(f"{each.name}, " for each in names) + f"= {called}"] if names else []


# The parts of a scene that have states: stops and frictions, and which states each of them has.


FREE, CONTACT, LIFTED = "free", "contact", "lifted"  # of an elastic stop; lifted: deep, its damper would pull
OPEN, REST = "open", "rest"  # of a rigid stop
FORWARD, BACKWARD, STICK = "forward", "backward", "stick"  # of a friction
TIES = (REST, STICK)


@dataclass(frozen=True)
class Switch:
    """A part that has states.

    number : of the part among all stops and frictions, as files count them
    """

    number: int
    part: Any
    states: tuple[str, ...]

    @property
    def tie(self) -> str | None:
        """The state in which it ties its ends; None for an elastic stop."""
        return next((state for state in self.states if state in TIES), None)

    @property
    def direction(self) -> int:
        """Sign of the force on P that counts as positive: the push of a rigid stop, else along the axis."""
        return self.part.sense if isinstance(self.part, RigidStop) else 1


def switches_of(scene: Scene) -> tuple[Switch, ...]:
    """Stops, then frictions; those without any force are no parts of the motion."""
    parts = enumerate([*scene.stops, *scene.frictions])
    return tuple(Switch(i, part, _states(part)) for i, part in parts if not _is_idle(part))


def _is_idle(part: Any) -> bool:
    return (
        isinstance(part, Friction)
        and part.slips is None
        and not any((*part.limits, part.forward, part.backward))
    )


def _states(part: Any) -> tuple[str, ...]:
    if isinstance(part, Friction):
        return FORWARD, BACKWARD, STICK
    if isinstance(part, RigidStop):
        return OPEN, REST
    return (FREE, CONTACT, LIFTED) if part.release == AT_FORCE else (FREE, CONTACT)


# Formulas, read node by node into numbers of a kit.
#
# A choice is s a + (1 - s) b, its side s known: 1 where its guard is positive. What stands in a branch that
# is not taken, or in the law of a part that does not act, may have no value, such as the logarithm of what is
# below 0: there a function that is not defined everywhere is read at a place where it is.


HARMLESS = {"pow": 1.0, "div": 1.0} | {
    name: of.harmless for name, of in FUNCTIONS.items() if of.harmless is not None
}
Label = tuple[Any, ...]  # of a flag: of a state of a part, or of a side of a switch


class FormulaReader:
    """Values of formulas as numbers of `kit`.

    inputs : what formulas read, by node; sides : for each switch by its `switch_key` the numbers that
    `FormulaSwitch.parameters` gives, None to find the side from the guard wherever it is read; flags : 1 or 0
    for each state of a part, by label, whether its law acts
    """

    def __init__(self, kit: Any, inputs: dict[Node, Any], sides: Mapping[Node, Sequence[Any]] | None = None):
        self.kit, self.inputs, self.sides = kit, inputs, sides
        self.flags: dict[Label, Any] = {}
        self._known: dict[tuple[Node, tuple[Label, ...]], Any] = {}
        self._products: dict[tuple[Label, ...], Any] = {}

    def value(self, node: Node, *acting: Label) -> Any:
        """The value of a formula; acting : labels of the flags that say whether it is in use."""
        if not reads_partly_defined(node):
            acting = ()
        if (node, acting) not in self._known:
            self._known[node, acting] = self._value(node, acting)
        return self._known[node, acting]

    def _value(self, node: Node, acting: tuple[Label, ...]) -> Any:
        kind = node[0]
        if kind in ("num", "pi"):
            return float(node[1]) if kind == "num" else math.pi
        if node in self.inputs:
            return self.inputs[node]
        if kind == "choose":
            return self._chosen(node, node[2], node[3], acting)
        if kind in ("mod", "table"):
            return self._remainder(node, acting) if kind == "mod" else self._of_table(node, acting)
        choice, above, below = powers_of_choice(node)
        if choice is not None:
            return self._chosen(choice, above, below, acting)
        if kind in ("add", "sub", "mul"):
            a, b = (self.value(child, *acting) for child in node[1:])
            return a + b if kind == "add" else a - b if kind == "sub" else a * b
        argument = self._defined(kind, self.value(node[2] if kind == "div" else node[1], *acting), acting)
        if kind == "div":
            return self.value(node[1], *acting) / argument
        if isinstance(argument, float):
            return NAMES["power"](argument, float(node[2])) if kind == "pow" else NAMES[kind](argument)
        return self.kit.power(argument, float(node[2])) if kind == "pow" else self.kit.call(kind, argument)

    def _defined(self, kind: str, argument: Any, acting: tuple[Label, ...]) -> Any:
        """The argument of a function, or one at which it is defined where the formula is not in use."""
        if not acting or kind not in HARMLESS or isinstance(argument, float):
            return argument
        if acting not in self._products:
            self._products[acting] = math.prod(
                (self.flags[label] for label in acting[1:]), start=self.flags[acting[0]]
            )
        flag = self._products[acting]
        return flag * argument + (1.0 - flag) * HARMLESS[kind] if HARMLESS[kind] else flag * argument

    def _chosen(self, switch: Node, above: Node, below: Node, acting: tuple[Label, ...]) -> Any:
        key = switch_key(switch)
        if (key, 1) not in self.flags:
            if self.sides is None:
                self.flags[key, 1] = self.kit.where(self.value(switch[1], *acting), 1.0, 0.0)
            else:
                self.flags[key, 1] = self.sides[key][0]
            self.flags[key, 0] = 1.0 - self.flags[key, 1]
        yes, no = self.value(above, *acting, (key, 1)), self.value(below, *acting, (key, 0))
        return self.kit.choose(self.flags[key, 1], yes, no)

    def _remainder(self, node: Node, acting: tuple[Label, ...]) -> Any:
        a, step = (self.value(child, *acting) for child in node[1:3])
        turns = self.kit.call("floor", a / step) if self.sides is None else self.sides[switch_key(node)][0]
        return a - turns * step

    def _of_table(self, node: Node, acting: tuple[Label, ...]) -> Any:
        u, degree = self.value(node[1], *acting), table_degree(node)
        if self.sides is None:
            return self.kit.table(lambda u: _in_piece(u, *piece_of(node, table_side(node[2], u))), u)
        switch_numbers = self.sides[switch_key(node)]
        own = switch_numbers[-1][node]
        return _in_piece(u, *own) if degree else own[1]


def powers_of_choice(node: Node) -> tuple[Node | None, Node, Node]:
    """(a or b)**p as a**p or b**p, so that neither kinks: the choice, its sides; (None, ...) of other nodes.
    A number may stand before the choice.
    """
    factor, base = num(1), node[1] if node[0] == "pow" else ZERO
    if base[0] == "mul" and base[1][0] == "num":
        factor, base = base[1:]
    if base[0] != "choose":
        return None, ZERO, ZERO
    above, below = (mul(factor, side) for side in base[2:4])
    return base, _power(above, node[2]), _power(below, node[2])


def _power(base: Node, p: Any) -> Node:
    return ZERO if base == ZERO and p > 0 else ("pow", base, p)


@lru_cache(maxsize=4096)
def reads_partly_defined(node: Node) -> bool:
    """Whether a formula has functions that are not defined, or overflow, for some arguments."""
    return reads([node], tuple(HARMLESS))


def table_degree(node: Node) -> int:
    """The highest power of the pieces of a table."""
    return max(map(len, node[3])) - 1


def table_side(knots: Sequence[Any], u: float) -> int:
    """The piece that u lies in: -1 before the first knot, the number of pieces behind the last one."""
    return bisect_right(knots, u) - 1


def piece_of(node: Node, side: int) -> list[float]:
    """Knot from which a table counts on a side, and its coefficients, lowest power first, as many on all."""
    knot, piece = piece_of_table(node, side)
    return [float(knot), *map(float, piece), *[0.0] * (table_degree(node) + 1 - len(piece))]


def _in_piece(u: Any, knot: Any, *coefficients: Any) -> Any:
    beyond, value = u - knot, coefficients[-1]
    for coefficient in reversed(coefficients[:-1]):
        value = value * beyond + coefficient
    return value


# Switches of formulas: choices, remainders and tables, those with one guard taken together.


def switch_key(node: Node) -> Node:
    """The key that switches which turn together share: the guard of choices, number and step of remainders,
    argument and knots of tables.
    """
    return {"choose": node[:2], "mod": node[:3]}.get(node[0], node[:3])


@dataclass(frozen=True)
class FormulaSwitch:
    """Switches of formulas that turn at the same instants.

    key : of `switch_key`; tables : the tables among them; power : 1 where the upper side of a choice has a
    root, or a power that is no whole number, of the guard itself, which has no series at 0, -1 where the
    lower side has one, 0 where none has. Its side is 1 or 0 of a choice, the whole number of steps of a
    remainder, the piece of a table.
    """

    key: Node
    tables: tuple[Node, ...] = ()
    power: int = 0

    @property
    def places(self) -> int:
        """How many event functions it has: a side of a choice ends at one place, any other at two."""
        return 1 if self.key[0] == "choose" else 2

    def guard(self, reader: FormulaReader, skin: float) -> Any:
        """The number that its side follows from."""
        value = reader.value(self.key[1])
        if self.key[0] == "mod":
            return value / reader.value(self.key[2])
        return value - self.power * skin if self.power and skin else value

    def side(self, guard: float, before: int) -> int:
        """The side on which it is; that of before where it is on none."""
        if self.key[0] == "choose":
            return before if guard == 0 else int(guard > 0)
        return math.floor(guard) if self.key[0] == "mod" else table_side(self.key[2], guard)

    def from_zero(self, guard: float) -> float:
        """How far the guard is from where the side changes, or from the nearest such place."""
        if self.key[0] == "choose":
            return guard
        return (
            guard - round(guard)
            if self.key[0] == "mod"
            else min((guard - knot for knot in map(float, self.key[2])), key=abs)
        )

    def behind(self, side: int, place: int) -> int:
        """The side behind the zero of an event function."""
        return 1 - side if self.key[0] == "choose" else side + (1 if place else -1)

    def parameters(self, side: int) -> list[float]:
        """The numbers by which formulas and event functions know the side: the side itself; of a table a and
        b of each event function a u + b, and `piece_of` each table.
        """
        if self.key[0] != "table":
            return [float(side)]
        knots = self.key[2]
        below = [1.0, -float(knots[side])] if side >= 0 else [0.0, 1.0]
        above = [-1.0, float(knots[side + 1])] if side + 1 < len(knots) else [0.0, 1.0]
        return [*below, *above, *(number for table in self.tables for number in piece_of(table, side))]

    def numbers(self, parameters: Iterable[Any]) -> list[Any]:
        """Its parameters, taken from those of a mode; the pieces of tables as the last one, by table."""
        left = iter(parameters)
        if self.key[0] != "table":
            return [next(left)]
        ends = [next(left) for _ in range(4)]
        return [*ends, {table: [next(left) for _ in range(table_degree(table) + 2)] for table in self.tables}]

    def ends(self, reader: FormulaReader, skin: float) -> list[Any]:
        """Its event functions: positive on its side, zero where that ends."""
        assert reader.sides is not None
        guard, numbers = self.guard(reader, skin), reader.sides[self.key]
        if self.key[0] == "choose":
            return [(2.0 * numbers[0] - 1.0) * guard]
        if self.key[0] == "mod":
            return [guard - numbers[0], (numbers[0] + 1.0) - guard]
        return [numbers[0] * guard + numbers[1], numbers[2] * guard + numbers[3]]


@lru_cache(maxsize=64)
def formula_switches(scene: Scene) -> tuple[FormulaSwitch, ...]:
    """The switches of all formulas of a scene, those first that stand in the guards of others."""
    tables: dict[Node, dict[Node, None]] = {}
    powers: dict[Node, int] = {}
    formulas = [one.formula for one in formulas_of(scene)] if scene.has_formulas else []
    for node in walk([*formulas, *base_formulas(scene), *course_rates(scene)]):
        choice, *sides = powers_of_choice(node) if node[0] == "pow" else (node, *node[2:4])
        if choice is not None and choice[0] in SWITCHES:
            key = switch_key(choice)
            tables.setdefault(key, {})
            if node[0] == "table":
                tables[key][node] = None
            if choice[0] == "choose":
                powers[key] = powers.get(key) or sum(_roots(choice, sides))
    return tuple(FormulaSwitch(key, tuple(own), powers.get(key, 0)) for key, own in tables.items())


def _roots(choice: Node, sides: Sequence[Node]) -> tuple[int, int]:
    """1 where the upper side of a choice, or what becomes of it, has a power of the guard; -1 where the lower
    side has one; 0 else.
    """
    bases = [{one[1] for one in walk([side]) if one[0] == "pow"} for side in sides]
    above, below = (any(_is_multiple(base, choice[1]) for base in side) for side in bases)
    return int(above), -int(below)


def _is_multiple(base: Node, guard: Node) -> bool:
    """Whether a base is the guard, but for a number."""
    base, guard = (one[2] if one[0] == "mul" and one[1][0] == "num" else one for one in (base, guard))
    return base == guard


def two_sided_power(scene: Scene) -> str | None:
    """A power of a choice that has no series where its guard is 0, whichever side it comes from, such as
    abs(z)**0.5; None without any.
    """
    for one in formulas_of(scene) if scene.has_formulas else ():
        for node in walk([one.formula]):
            choice, *sides = powers_of_choice(node) if node[0] == "pow" else (node, *node[2:4])
            if choice is not None and choice[0] == "choose" and all(_roots(choice, sides)):
                return f"{choice[4]}**{float(node[2]):g}" if node[0] == "pow" else str(choice[4])
    return None


def course_rates(scene: Scene) -> list[Node]:
    """Accelerations of the belts whose velocities are formulas of time, in the order of the frictions."""
    return [derivative(one.course, TIME) for one in scene.frictions if one.course is not None]


# Accelerations of bodies some of which are tied, and the forces in the ties, from forces: linear algebra.
#
# Bodies with masses M under forces F, tied by rows W of relative displacements, move by
#
#     M a = F + W' T,     W a = -w q
#
# with T the forces in the ties, q the accelerations of base and belts, w their share in the rows. All ties
# are solved for at once; no body is merged with another.


DEPENDENT = 1e-10  # of the largest singular value, below which rows of ties are dependent
NOTHING = 1e-13  # of a mobility: rounding of what a tie leaves free


@dataclass(frozen=True)
class TiedBodies:
    """a = mobility F + driven q (n) and T = force F + driven_force q (ties)."""

    mobility: np.ndarray
    driven: np.ndarray
    force: np.ndarray
    driven_force: np.ndarray


def masses(scene: Scene) -> np.ndarray:
    """Masses of the bodies on the line [kg], unbalanced masses of motor and rotors with their bodies (n)."""
    m = np.array([float(body.m) for body in scene.line])
    if scene.motor is not None:
        m[scene.motor.on] += scene.motor.m3
    return m


def driven_count(scene: Scene) -> int:
    """How many accelerations are given by time alone: of a base, then of belts."""
    return scene.has_base + sum(friction.course is not None for friction in scene.frictions)


def rows_of(scene: Scene, switches: Sequence[Switch]) -> tuple[np.ndarray, np.ndarray]:
    """Share of each body (ties, n), and of base and belts (ties, driven), in the displacement of each part's
    ends, P counted in the direction of the part's positive force.
    """
    rows, driven = np.zeros((len(switches), len(scene.line))), np.zeros((len(switches), driven_count(scene)))
    courses = [friction.name for friction in scene.frictions if friction.course is not None]
    for i, switch in enumerate(switches):
        for end, sign in ((switch.part.P, switch.direction), (switch.part.Q, -switch.direction)):
            if end >= 0:
                rows[i, end] = sign
            elif end == BASE and scene.has_base:
                driven[i, 0] = sign
        if isinstance(switch.part, Friction) and switch.part.course is not None:
            driven[i, scene.has_base + courses.index(switch.part.name)] = -1.0
    return rows, driven


def tied_bodies(scene: Scene, tied: Sequence[Switch]) -> TiedBodies:
    """The motion of the bodies of `scene` while the parts `tied` hold their ends together.

    Raises ArithmeticError where more parts tie the same bodies than need be: then the forces are not unique.
    """
    W, w = rows_of(scene, tied)
    mobility = np.diag(1 / masses(scene))
    compliance = W @ mobility @ W.T
    spread = np.linalg.svd(compliance, compute_uv=False)
    if len(tied) and spread[-1] < DEPENDENT * spread[0]:
        names = " and ".join(switch.part.name for switch in tied)
        raise ArithmeticError(f"{names} hold the same bodies at once: their forces are not unique")
    inverse = np.linalg.inv(compliance)
    force, driven_force = -inverse @ W @ mobility, -inverse @ w
    through = mobility @ W.T
    left = mobility + through @ force
    left[np.abs(left) < NOTHING * mobility.max()] = 0.0  # or a body at rest would creep through its guards
    return TiedBodies(left, through @ driven_force, force, driven_force)
