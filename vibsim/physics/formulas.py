"""Formulas: laws of force, torque, motion and rate as expressions in the state of a scene and in time.

A formula is a tree of nodes; a node is a tuple whose first entry says what it is:

    ("num", value)         a number, an exact Fraction in SI units
    ("pi",)  ("t",)        pi; the time [s]
    ("x", end)  ("v", end) displacement [m] and velocity [m/s] of an end of a part: number of a body, GROUND
                           or BASE
    ("phi",)  ("w",)       angle [rad] and speed [rad/s] of the rotor of `Scene.motor`
    ("add", a, b)  ("sub", a, b)  ("mul", a, b)  ("div", a, b)
    ("pow", a, p)          a**p, p a Fraction that is no whole number: a >= 0
    ("sin", a)             and cos, exp, log, sinh, cosh, tanh, atan, asin, acos
    ("choose", g, a, b, text)   a where g > 0, b where g < 0; text: as it stands in the case, "abs(v)"
    ("mod", a, b, text)    a - k b, k the whole number with 0 <= a - k b < b; b a positive number
    ("table", u, knots, pieces, text)   the polynomial pieces[k](u - knots[k]) between knots k and k + 1; the
                           end values outside, of a derivative one more piece, (0,); knots: Fractions,
                           pieces: Fractions, lowest power first

Nodes compare by what they say, so equal parts of formulas are one. Make them with the functions of this
module, which compute what is made of numbers alone exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import chain
from typing import Any, NamedTuple

Node = tuple[Any, ...]

ZERO: Node = ("num", Fraction(0))
ONE: Node = ("num", Fraction(1))
PI: Node = ("pi",)
TIME: Node = ("t",)
SWITCHES = ("choose", "mod", "table")  # nodes of several sides, of which a mode says which holds
MOST_EXACT = 64  # largest whole power that is written as products


def num(value: Fraction | int | str) -> Node:
    """A number."""
    return ("num", Fraction(value) if isinstance(value, int | float | str) else value)


def value_of(node: Node) -> Fraction | None:
    """The number that a node is; None of any other."""
    return node[1] if node[0] == "num" else None


def add(a: Node, b: Node) -> Node:
    """a + b."""
    if a[0] == b[0] == "num":
        return num(a[1] + b[1])
    return b if a == ZERO else a if b == ZERO else ("add", a, b)


def sub(a: Node, b: Node) -> Node:
    """a - b."""
    if a[0] == b[0] == "num":
        return num(a[1] - b[1])
    return a if b == ZERO else mul(num(-1), b) if a == ZERO else ("sub", a, b)


def neg(a: Node) -> Node:
    """-a."""
    return mul(num(-1), a)


def mul(a: Node, b: Node) -> Node:
    """a b; a number comes first."""
    if a[0] == b[0] == "num":
        return num(a[1] * b[1])
    if b[0] == "num":
        a, b = b, a
    if a == ZERO:
        return ZERO
    if a == ONE:
        return b
    if a[0] == "num" and b[0] == "mul" and b[1][0] == "num":
        return mul(num(a[1] * b[1][1]), b[2])
    return ("mul", a, b)


def div(a: Node, b: Node) -> Node:
    """a / b. Raises ZeroDivisionError where b is the number 0."""
    if b[0] == "num":
        return mul(num(1 / b[1]), a)
    return ZERO if a == ZERO else ("div", a, b)


SUMS_AND_PRODUCTS = {"add": add, "sub": sub, "mul": mul, "div": div}


def power(a: Node, b: Node) -> Node:
    """a**b: products of a where b is a whole number, exp(b log a) where it is no number."""
    p = value_of(b)
    if p is None:
        return call("exp", mul(b, call("log", a)))
    if p.denominator != 1:
        return ("pow", a, p)
    if abs(p) > MOST_EXACT:
        raise ValueError(f"whole powers beyond {MOST_EXACT} are not supported")
    if p < 0:
        return div(ONE, power(a, num(-p)))
    result, square, n = ONE, a, int(p)
    while n:
        if n % 2:
            result = mul(square, result)
        n //= 2
        square = mul(square, square) if n else square
    return result


def call(name: str, a: Node) -> Node:
    """A function of one argument by its name in a formula: one of FUNCTIONS, or sqrt."""
    if name == "sqrt":
        return ("pow", a, Fraction(1, 2))
    if name == "tan":
        return div(call("sin", a), call("cos", a))
    at, value = FUNCTIONS[name].known
    return value if a == num(at) else (name, a)


def choose(g: Node, a: Node, b: Node, text: str) -> Node:
    """a where g > 0, b where g < 0."""
    value = value_of(g)
    if value is not None:
        return a if value >= 0 else b
    return a if a == b else ("choose", g, a, b, text)


def absolute(a: Node, text: str) -> Node:
    """|a|."""
    return a if is_never_negative(a) else choose(a, a, neg(a), text)


def where_positive(node: Node, known: Node) -> Node:
    """A formula where `known` is never negative: |known| is known, and so each switch that watches a multiple
    of it by a number.
    """
    base = known[2] if known[0] == "mul" and known[1][0] == "num" else known
    return _with_sign(node, base, _sense(known, base), {})


def _with_sign(node: Node, base: Node, sign: int, made: dict[Node, Node]) -> Node:
    if node not in made:
        sense = sign * _sense(node[1], base) if node[0] == "choose" else 0
        if sense:
            made[node] = _with_sign(node[2 if sense > 0 else 3], base, sign, made)
        else:
            below = tuple(_with_sign(child, base, sign, made) for child in children(node))
            made[node] = node if below == children(node) else _of_parts(node, below)
    return made[node]


def _of_parts(node: Node, below: tuple[Node, ...]) -> Node:
    """A node of that kind whose children are others."""
    if node[0] in SUMS_AND_PRODUCTS:
        return SUMS_AND_PRODUCTS[node[0]](*below)
    return (node[0], *below, *node[1 + len(below) :])


def _sense(node: Node, base: Node) -> int:
    """1 or -1 where a formula is a positive or negative number times another one, else 0."""
    if node == base:
        return 1
    if node[0] not in ("mul", "div"):
        return 0
    number = value_of(node[1] if node[0] == "mul" else node[2])
    sign = 0 if number is None or number == 0 else 1 if number > 0 else -1
    return sign * _sense(node[2] if node[0] == "mul" else node[1], base)


def largest(a: Node, b: Node, text: str) -> Node:
    """The larger of a and b."""
    for one, other in ((a, b), (b, a)):
        if other == ZERO and is_never_negative(one):
            return one
    return choose(sub(a, b), a, b, text)


def is_never_negative(node: Node) -> bool:
    """Whether the form of a formula keeps it from being negative, as of max(a, 0), |a|, mod(a, b) and their
    products with numbers above 0. At its zeros it does not change its sign: no switch has to watch them.
    """
    if node[0] == "mod":
        return True
    if node[0] == "mul":
        return is_never_negative(node[1]) and is_never_negative(node[2])
    if node[0] != "choose":
        value = value_of(node)
        return value is not None and value >= 0
    sides = zip(node[2:4], (1, -1), strict=True)
    return all(
        is_never_negative(one) or (_sense(one, node[1]) or _sense(node[1], one)) == sign
        for one, sign in sides
    )


def smallest(a: Node, b: Node, text: str) -> Node:
    """The smaller of a and b."""
    return choose(sub(b, a), a, b, text)


def is_continuous(node: Node) -> bool:
    """Whether the sides of a switch are equal at its zero, however it is rounded: |a|, max(a, b), min(a,
    b).
    """
    if node[0] != "choose":
        return False
    _, guard, above, below, _ = node
    return guard in (sub(above, below), sub(below, above)) or {above, below} == {guard, neg(guard)}


def children(node: Node) -> tuple[Node, ...]:
    """The nodes that a node is made of."""
    kind = node[0]
    if kind in ("add", "sub", "mul", "div"):
        return node[1:]
    if kind == "choose":
        return node[1:4]
    if kind == "mod":
        return node[1:3]
    if kind in ("num", "pi", "t", "x", "v", "phi", "w"):
        return ()
    return (node[1],)


class HashedNode(tuple[Any, ...]):
    """A node that knows its hash, which for a tuple is made anew of all that is below it.

    switches : those in it, in the order of `walk`; outer: those of them that are in no other one, from the
        last to the first
    """

    hashed: int
    switches: tuple[Node, ...] = ()
    outer: tuple[Node, ...] = ()

    def __hash__(self) -> int:
        try:
            return self.hashed
        except AttributeError:
            self.hashed = super().__hash__()
            return self.hashed


def hashed(formulas: Iterable[Node]) -> list[HashedNode]:
    """The same formulas of nodes that know their hashes, equal ones being one."""
    known: dict[HashedNode, HashedNode] = {}
    # by identity: a node within other ones is gone into once, and not hashed
    made: dict[int, HashedNode] = {}

    def of(node: Node) -> HashedNode:
        one = made.get(id(node))
        if one is None:
            below = children(node)
            parts = [of(child) for child in below]
            one = HashedNode((node[0], *parts, *node[1 + len(below) :]))
            made[id(node)] = one = known.setdefault(one, one)
            inside = dict.fromkeys(switch for part in parts if part.switches for switch in part.switches)
            if node[0] in SWITCHES:
                one.switches, one.outer = (*inside, one), (one,)
            elif inside:
                outer = dict.fromkeys(chain.from_iterable(part.outer for part in reversed(parts)))
                one.switches, one.outer = (*inside,), (*outer,)
        return one

    return [of(node) for node in formulas]


def begun_later(node: Node, t: Fraction) -> Node:
    """A formula as it is from the time t [s] on, which becomes 0."""
    known: dict[Node, Node] = {}
    for one in walk([node]):
        parts = (known.get(part, part) if isinstance(part, tuple) else part for part in one)
        known[one] = add(TIME, num(t)) if one == TIME else tuple(parts)
    return known[node]


def walk(nodes: Iterable[Node]) -> Iterator[Node]:
    """Each distinct node of formulas once, children before what is made of them."""
    found: dict[Node, None] = {}
    for node in nodes:
        _find_below(node, found)
    return iter(found)


def _find_below(node: Node, found: dict[Node, None]) -> None:
    if node not in found:
        for child in children(node):
            _find_below(child, found)
        found[node] = None


def reads(nodes: Iterable[Node], kinds: Sequence[str]) -> bool:
    """Whether formulas read any of the inputs `kinds`."""
    return any(node[0] in kinds for node in walk(nodes))


def resolved(node: Node, sides: Mapping[Node, int]) -> Node:
    """The formula without switches that a formula is where its switches are on these sides; on the upper one
    those that have none.
    """
    kind = node[0]
    if kind == "choose":
        return resolved(node[2] if sides.get(node, 1) > 0 else node[3], sides)
    below = tuple(resolved(child, sides) for child in children(node))
    if kind == "mod":
        return sub(below[0], mul(num(sides.get(node, 0)), below[1]))
    if kind == "table":
        return _piece(node, below[0], sides.get(node, 0))
    if below == children(node):
        return node
    return _of_parts(node, below)


def _piece(node: Node, u: Node, side: int) -> Node:
    """A table between two of its knots, or outside of them."""
    knot, coefficients = piece_of_table(node, side)
    at, result = sub(u, num(knot)), ZERO
    for coefficient in reversed(coefficients):
        result = add(num(coefficient), mul(result, at))
    return result


def piece_of_table(node: Node, side: int) -> tuple[Fraction, tuple[Fraction, ...]]:
    """Knot from which a table counts on a side, and its coefficients, lowest power first: between the knots
    `side` and `side` + 1; before the first knot, on side -1, and behind the last one a constant.
    """
    _, _, knots, pieces, _ = node
    if 0 <= side < len(knots) - 1:
        return knots[side], pieces[side]
    if len(pieces) == len(knots):
        return Fraction(0), pieces[-1]
    if side < 0:
        return Fraction(0), pieces[0][:1]
    width, value = knots[-1] - knots[-2], Fraction(0)
    for coefficient in reversed(pieces[-1]):
        value = value * width + coefficient
    return Fraction(0), (value,)


def is_periodic(node: Node, of: Node) -> bool:
    """Whether a formula reads an angle in sines and cosines of whole multiples of it alone, so that 2 pi more
    of it change nothing.
    """
    if node == of:
        return False
    if node[0] in ("sin", "cos"):
        rate = value_of(derivative(node[1], of))
        if rate is not None:
            return rate.denominator == 1
    return all(is_periodic(child, of) for child in children(node))


def derivative(node: Node, of: Node) -> Node:
    """The partial derivative of a formula with respect to the input `of`; of one with switches it has these
    as well.
    """
    return _Derivative(of).of_node(node)


class _Derivative:
    """Derivatives of the nodes of formulas with respect to one input, each made once."""

    def __init__(self, of: Node) -> None:
        self.known: dict[Node, Node] = {of: ONE}

    def of_node(self, node: Node) -> Node:
        if node not in self.known:
            self.known[node] = self._made(node)
        return self.known[node]

    def _made(self, node: Node) -> Node:
        kind, below = node[0], children(node)
        slopes = [self.of_node(child) for child in below]
        if all(slope == ZERO for slope in slopes):
            return ZERO
        if kind == "add":
            return add(*slopes)
        if kind == "sub":
            return sub(*slopes)
        if kind == "mul":
            return add(mul(slopes[0], below[1]), mul(below[0], slopes[1]))
        if kind == "div":
            return div(sub(slopes[0], mul(node, slopes[1])), below[1])
        if kind == "choose":
            return choose(below[0], slopes[1], slopes[2], node[4])
        if kind == "mod":
            return slopes[0]
        if kind == "table":
            _, u, knots, pieces, text = node
            rates = tuple(tuple(n * c for n, c in enumerate(piece))[1:] or (Fraction(0),) for piece in pieces)
            outside = ((Fraction(0),),) * (len(rates) < len(knots))
            return mul(("table", u, knots, rates + outside, text), slopes[0])
        return mul(self._slope(node, below[0]), slopes[0])

    @staticmethod
    def _slope(node: Node, a: Node) -> Node:
        if node[0] == "pow":
            return mul(num(node[2]), ("pow", a, node[2] - 1))
        return FUNCTIONS[node[0]].slope(node, a)


# The functions of one argument, by name. Checks of cases, values in pictures, peers and the engine go by what
# is said of them here; how their values are computed is in `engine/functions.h`.


class Function(NamedTuple):
    """A function.

    slope : its derivative as a formula, from that of its value and that of its argument
    known : an argument, and its value there, which is exact
    least, most : ends of the numbers that it is of, None without; strictly : whether the least is none of
        them
    harmless : an argument of which its value is not large; None where that is so everywhere
    divisor : of a function whose derivative is 1 or -1 over it, that as a formula of the argument
    """

    slope: Callable[[Node, Node], Node]
    known: tuple[int, Node]
    least: int | None = None
    most: int | None = None
    strictly: bool = False
    harmless: float | None = None
    divisor: Callable[[Node], Node] | None = None

    def covers(self, x: Fraction) -> bool:
        """Whether it has a value at x."""
        above = self.least is None or x > self.least or (x == self.least and not self.strictly)
        return above and (self.most is None or x <= self.most)


def _over(divisor: Callable[[Node], Node], sign: int = 1) -> Callable[[Node, Node], Node]:
    """The derivative of a function by its divisor."""
    return lambda _, a: div(num(sign), divisor(a))


def _square_and_one(a: Node) -> Node:
    """1 + a^2"""
    return add(ONE, mul(a, a))


def _root_beside_one(a: Node) -> Node:
    """sqrt(1 - a^2)"""
    return ("pow", sub(ONE, mul(a, a)), Fraction(1, 2))


FUNCTIONS = {
    "sin": Function(lambda _, a: ("cos", a), (0, ZERO)),
    "cos": Function(lambda _, a: neg(("sin", a)), (0, ONE)),
    "tan": Function(lambda y, _: add(ONE, mul(y, y)), (0, ZERO)),  # written as sin over cos
    "exp": Function(lambda y, _: y, (0, ONE), harmless=0.0),
    "log": Function(lambda _, a: div(ONE, a), (1, ZERO), least=0, strictly=True, harmless=1.0),
    "sinh": Function(lambda _, a: ("cosh", a), (0, ZERO), harmless=0.0),
    "cosh": Function(lambda _, a: ("sinh", a), (0, ONE), harmless=0.0),
    "tanh": Function(lambda y, _: sub(ONE, mul(y, y)), (0, ZERO)),
    "atan": Function(_over(_square_and_one), (0, ZERO), divisor=_square_and_one),
    "asin": Function(_over(_root_beside_one), (0, ZERO), -1, 1, harmless=0.0, divisor=_root_beside_one),
    "acos": Function(_over(_root_beside_one, -1), (1, ZERO), -1, 1, harmless=0.0, divisor=_root_beside_one),
}
