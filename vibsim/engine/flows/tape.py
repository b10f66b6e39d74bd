"""Tapes: the formulas of one mode as a list of operations, and what is computed along it.

A formula is a tree (`vibsim.physics.formulas`); in a mode each of its switches is on one side. What is left
is analytic, and becomes operations on numbers or on Taylor series: equal parts once, operands before results.
Here are values along it at one instant, with bounds of their rounding, for what Python decides. C has these
and the coefficients of series, by the usual recurrences (Jorba & Zou 2005): `tape.c`, `tape_series.h`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import Any, Generic, NamedTuple, cast

from vibsim.engine import _engine
from vibsim.physics.formulas import (
    FUNCTIONS,
    SWITCHES,
    HashedNode,
    Node,
    children,
    derivative,
    piece_of_table,
    resolved,
)
from vibsim.physics.formulas import TIME as TIME_NODE
from vibsim.physics.numbers import TWO_PI, Doubles, Kit, N, abs

# Operations, the same numbers in tape.h; of functions, as functions.h lists them.
CONSTANT, TIME, PLACE, SPEED, ANGLE, SPIN, ADD, SUB, SCALE, MUL, SQUARE, DIV = range(12)
INPUTS = (CONSTANT, TIME, PLACE, SPEED, ANGLE, SPIN)
NAMES = dict(enumerate(_engine.FUNCTIONS.split(), DIV + 1))
CODES = {name: code for code, name in NAMES.items()}
SIN, COS, SINH, COSH = CODES["sin"], CODES["cos"], CODES["sinh"], CODES["cosh"]
EXP, LOG, TANH, ATAN = CODES["exp"], CODES["log"], CODES["tanh"], CODES["atan"]
POWER = DIV + 1 + len(NAMES)
ARITHMETIC = {"add": ADD, "sub": SUB, "mul": MUL, "div": DIV}
LEAVES = ("num", "pi", "t", "x", "v", "phi", "w")  # nodes that are made of no others
PAIRS = {"sin": (SIN, "cos"), "cos": (COS, "sin"), "sinh": (SINH, "cosh"), "cosh": (COSH, "sinh")}
ULPS = 4  # rounding of an elementary function, in units of eps


class Op(NamedTuple):
    """One operation: its code, the places of its operands on the tape, and its number.

    value : of CONSTANT; factor of SCALE; exponent of POWER
    """

    code: int
    a: int = -1
    b: int = -1
    value: Any = 0.0


@dataclass
class Tape:
    """Operations in order, and the places of the results that are asked for.

    ops : each writes its own place; b of SIN, COS, SINH, COSH is the place of the other one of the two, of
        TANH that of 1 - tanh^2, of a function by a divisor that of the divisor
    outputs : places by number of the output; texts : what each output belongs to, for messages
    """

    ops: list[Op] = field(default_factory=list)
    outputs: list[int] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)


class TapeMaker(Generic[N]):
    """Writes formulas as operations, each once for all formulas and all sides of their switches; a tape has
    those of them that its outputs need.

    columns : {end: column}; ops : all operations, with their places here
    """

    def __init__(self, kit: Kit[N], columns: Mapping[int, int]) -> None:
        self.kit, self.columns = kit, columns
        self.ops: list[Op] = []
        self._places: dict[tuple[Any, ...], int] = {}
        self._place_of: dict[Op, int] = {}
        self._together: dict[int, range] = {}  # places of operations that go on a tape as one
        self._within: dict[Node, tuple[Node, ...]] = {}
        self._behind: dict[int, dict[int, None]] = {}

    def tape(self, places: Sequence[int], texts: Sequence[str] = ()) -> Tape:
        """A tape whose outputs are the results at some places; texts: what they belong to."""
        needed = self.needed(places)
        on_tape = {one: i for i, one in enumerate(needed)} | {-1: -1}
        ops = [
            op if op.code in INPUTS else Op(op.code, on_tape[op.a], on_tape[op.b], op.value)
            for op in map(self.ops.__getitem__, needed)
        ]
        return Tape(ops, [on_tape[place] for place in places], [*texts])

    def needed(self, places: Iterable[int]) -> dict[int, None]:
        """The places of all that some results are made of, themselves among them, operands first."""
        needed: dict[int, None] = {}
        for place in places:
            if place in needed:
                continue
            behind = self._behind.get(place)
            if behind is None:
                behind = self._behind[place] = {}
                self._find_behind(place, behind)
            needed |= behind
        return needed

    def _find_behind(self, place: int, found: dict[int, None]) -> None:
        if place not in found:
            together = self._together.get(place) or (place,)
            for one in together:
                code, *operands, _ = self.ops[one]
                for operand in operands if code not in INPUTS else ():
                    if operand >= 0 and operand not in together:
                        self._find_behind(operand, found)
            found |= dict.fromkeys(together)

    def within(self, node: Node) -> tuple[Node, ...]:
        """The switches in a formula."""
        if isinstance(node, HashedNode):
            return node.switches
        known = self._within.get(node)
        if known is None:
            below = dict.fromkeys(chain.from_iterable(map(self.within, children(node))))
            known = self._within[node] = (*below, node) if node[0] in SWITCHES else (*below,)
        return known

    def place(self, node: Node, sides: Mapping[Node, int]) -> int:
        """The place of a formula on these sides of its switches: what it is made of is written first, where
        it is not there.
        """
        switches = self.within(node)
        key = (node, *map(sides.get, switches)) if switches else node
        place = self._places.get(key)
        if place is None:
            place = self._places[key] = self._written(node, sides)
        return place

    def _written(self, node: Node, sides: Mapping[Node, int]) -> int:
        kind = node[0]
        if kind in LEAVES:
            return self._leaf(node)
        if kind == "choose":
            return self.place(chosen(node, sides), sides)
        a = self.place(node[1], sides)
        if kind in ARITHMETIC:
            return self._arithmetic(kind, a, self.place(node[2], sides))
        if kind == "mod":
            b = self.place(node[2], sides)
            return self._two(SUB, a, self.scaled(self.kit.number(sides.get(node, 0)), b))
        return self._table(node, a, sides) if kind == "table" else self._function(node, a, sides)

    def _leaf(self, node: Node) -> int:
        """The place of a number, or of what formulas read."""
        kind = node[0]
        if kind == "num":
            return self._constant(self.kit.number(node[1]))
        if kind == "pi":
            return self._constant(pi_of(self.kit))
        if kind == "t":
            return self._op(Op(TIME))
        if kind in ("x", "v"):
            column = node[1] if node[1] >= 0 else self.columns[node[1]]
            return self._op(Op(PLACE if kind == "x" else SPEED, column))
        return self._op(Op(ANGLE if kind == "phi" else SPIN))

    def _arithmetic(self, kind: str, a: int, b: int) -> int:
        ops = self.ops
        if kind == "mul":
            if a == b:
                return self._folded(Op(SQUARE, a))
            if ops[a].code == CONSTANT:
                return self.scaled(ops[a].value, b)
            if ops[b].code == CONSTANT:
                return self.scaled(ops[b].value, a)
        elif kind == "div" and ops[b].code == CONSTANT and ops[a].code != CONSTANT:
            return self.scaled(1 / ops[b].value, a)
        return self._two(ARITHMETIC[kind], a, b)

    def _function(self, node: Node, a: int, sides: Mapping[Node, int]) -> int:
        kind, kit = node[0], self.kit
        if kind == "pow":
            return self._folded(Op(POWER, a, -1, kit.number(node[2])))
        if kind in ("exp", "log"):
            return self._folded(Op(CODES[kind], a))
        if self.ops[a].code == CONSTANT:
            return self._constant(kit.function(kind)(self.ops[a].value))
        if kind in PAIRS:
            return self._pair(kind, a)
        divisor = FUNCTIONS[kind].divisor
        if divisor is not None:
            return self._folded(Op(CODES[kind], a, self.place(divisor(node[1]), sides)))
        one, place = self._constant(kit.number(1)), len(self.ops)
        return self._as_one(Op(TANH, a, place + 2), Op(SQUARE, place), Op(SUB, one, place + 1))

    def _pair(self, kind: str, a: int) -> int:
        first, second = (SIN, COS) if kind in ("sin", "cos") else (SINH, COSH)
        place = self._place_of.get(Op(first, a))
        if place is None:
            place = len(self.ops)
            self._place_of[Op(first, a)] = self._as_one(Op(first, a, place + 1), Op(second, a, place))
        return place if kind in ("sin", "sinh") else place + 1

    def _as_one(self, *ops: Op) -> int:
        """The place of the first of several operations, which go on a tape together."""
        first = len(self.ops)
        self.ops += ops
        places = range(first, len(self.ops))
        self._together |= dict.fromkeys(places, places)
        return first

    def _table(self, node: Node, a: int, sides: Mapping[Node, int]) -> int:
        knot, piece = piece_of_table(node, sides.get(node, 0))
        from_knot = self._two(SUB, a, self._constant(self.kit.number(knot)))
        place = self._constant(self.kit.number(piece[-1]))
        for coefficient in reversed(piece[:-1]):
            scaled = self._arithmetic("mul", place, from_knot)
            place = self._two(ADD, self._constant(self.kit.number(coefficient)), scaled)
        return place

    def _constant(self, value: N) -> int:
        return self._op(Op(CONSTANT, -1, -1, value))

    def scaled(self, factor: N | float, a: int) -> int:
        """The place of factor times the result at a place."""
        if factor == 1:
            return a
        return self._folded(Op(SCALE, a, -1, self.kit.number(factor)))

    def _two(self, code: int, a: int, b: int) -> int:
        return self._folded(Op(code, a, b))

    def _folded(self, op: Op) -> int:
        """The place of an operation, which is done at once where its operands are constants."""
        ops = self.ops
        if ops[op.a].code == CONSTANT and (op.b < 0 or ops[op.b].code == CONSTANT):
            values = {i: ops[i].value for i in (op.a, op.b) if i >= 0}
            return self._constant(start_value(self.kit, op, values))
        return self._op(op)

    def _op(self, op: Op) -> int:
        place = self._place_of.get(op)
        if place is None:
            place = self._place_of[op] = len(self.ops)
            self.ops.append(op)
        return place


def chosen(node: Node, sides: Mapping[Node, int]) -> Node:
    """The formula that a `choose` is on the side that holds."""
    result: Node = node[2] if sides.get(node, 1) > 0 else node[3]
    return result


def pi_of(kit: Kit[N]) -> N:
    """The number pi."""
    if isinstance(kit, type) and issubclass(kit, Doubles):
        half: Any = TWO_PI / 2
        return cast("N", half)
    return 4 * kit.function("atan")(kit.number(1))


@dataclass(slots=True)
class Inputs(Generic[N]):
    """Values that a tape reads at one instant: time, displacements and velocities by column, angle and speed
    of the rotor.
    """

    t: N
    x: Sequence[N]
    v: Sequence[N]
    phi: N
    w: N


def input_value(op: Op, at: Inputs[N]) -> N:
    """The value of an operation that reads."""
    if op.code == CONSTANT:
        constant: N = op.value
        return constant
    if op.code == TIME:
        return at.t
    if op.code in (PLACE, SPEED):
        return at.x[op.a] if op.code == PLACE else at.v[op.a]
    return at.phi if op.code == ANGLE else at.w


def start_value(kit: Kit[N], op: Op, values: Mapping[int, N] | Sequence[N]) -> N:
    """The value of an operation on values. A power of what is negative is that of 0, which with an exponent
    below 0 counts as 0: of slopes, whose instant of being infinite a step leaves behind.
    """
    code, a = op.code, values[op.a]
    if code in (ADD, SUB, MUL, DIV):
        b = values[op.b]
        if code == ADD:
            return a + b
        if code == SUB:
            return a - b
        return a * b if code == MUL else quotient(kit, a, b)
    if code == SCALE:
        scaled: N = op.value * a
        return scaled
    if code == SQUARE:
        return a * a
    if code == POWER:
        return kit.power(a, op.value) if a > 0 else 0 * a if op.value < 0 else kit.power(0 * a, op.value)
    if code == LOG and not a > 0:
        return kit.inf * 0
    return kit.function(NAMES[code])(a)


def motion_tape(kit: Kit[N], formula: Node, sides: Mapping[Node, int], text: str) -> Tape:
    """A formula in the time alone, on these sides of its switches, and its first two derivatives."""
    maker, nodes = TapeMaker(kit, {}), [resolved(formula, sides)]
    nodes += [derivative(nodes[0], TIME_NODE)]
    nodes += [derivative(nodes[1], TIME_NODE)]
    return maker.tape([maker.place(node, {}) for node in nodes], [text] * 3)


def quotient(kit: Kit[N], a: N, b: N) -> N:
    """a / b, and what is no number where b is 0."""
    return kit.inf * 0 if b == 0 else a / b


class TapeValues(Generic[N]):
    """Values along a tape at one instant, each with a bound of its rounding.

    blur : uncertainty of what is read; None where that is exact
    at_zeros : whether bases of powers that are within rounding of zero are zero
    """

    def __init__(
        self, kit: Kit[N], tape: Tape, at: Inputs[N], blur: Inputs[N] | None = None, at_zeros: bool = False
    ) -> None:
        self.kit, self.tape = kit, tape
        self.values: list[N] = []
        self.bounds: list[N] = []
        for i, op in enumerate(tape.ops):
            if op.code in INPUTS:
                self.values.append(input_value(op, at))
                if blur is None or op.code == CONSTANT:
                    self.bounds.append(kit.number(0))
                else:
                    self.bounds.append(abs(input_value(op, blur)))
            elif at_zeros and op.code == POWER and abs(self.values[op.a]) <= self.bounds[op.a]:
                self.values.append(start_value(kit, op, {op.a: kit.number(0)}))
                self.bounds.append(kit.number(0))
            else:
                self.values.append(start_value(kit, op, self.values))
                self.bounds.append(self._bound(i, op))

    def output(self, k: int) -> tuple[N, N]:
        """Output number k and its bound."""
        place = self.tape.outputs[k]
        return self.values[place], self.bounds[place]

    def _bound(self, i: int, op: Op) -> N:
        """Rounding bound of a result from those of its operands and its own, of products in full."""
        values, bounds, eps = self.values, self.bounds, self.kit.eps
        value, a, lost = abs(values[i]), abs(values[op.a]), bounds[op.a]
        if op.code in (ADD, SUB):
            return lost + bounds[op.b] + eps * value
        if op.code == SCALE:
            factor: N = abs(op.value)
            return factor * lost + 2 * eps * value
        if op.code == SQUARE:
            return (2 * a + lost) * lost + eps * value
        if op.code == MUL:
            return a * bounds[op.b] + (abs(values[op.b]) + bounds[op.b]) * lost + eps * value
        if op.code == DIV:
            b = abs(values[op.b])
            return quotient(self.kit, lost + value * bounds[op.b], b) + eps * value
        return self._slope(op, a, value) * lost + ULPS * eps * value

    def _slope(self, op: Op, a: N, value: N) -> N:
        """The size of the derivative of a function where its argument has the size a, or a bound of it."""
        one = self.kit.number(1)
        if op.code in (SIN, COS, TANH, ATAN):
            return one
        if op.code == EXP:
            return value
        if op.code in (SINH, COSH):
            return self.kit.function("cosh")(a)
        if op.code == POWER:
            return quotient(self.kit, abs(op.value) * value, a) if a > 0 else 0 * one
        if op.code == LOG:
            return quotient(self.kit, one, a)
        return quotient(self.kit, one, abs(self.values[op.b]))
