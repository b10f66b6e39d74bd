"""Formulas of random scenes as trees of our own: as text for a case, and as numbers for the second solver.

An expression is a tuple: ("par", name, value, unit), a number beside the formula; ("num", value);
("name", name); ("+", a, b), and so "-", "*", "/"; ("**", a, p); ("call", function, a); and the switches
("abs", a), ("sign", a), ("step", a), ("max", a, b), ("min", a, b), ("where", a, "<", b, then, else),
("mod", a, b) and ("table", a, pairs, units, kind). Values are floats in SI units. Nothing here is vibsim's.
"""

from __future__ import annotations

from math import floor, pi
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

Expression = tuple[Any, ...]
SWITCHES = ("abs", "sign", "step", "max", "min", "where", "mod", "table")
UNIT_VALUES = {"Hz": 2 * pi, "mm": 1e-3, "ms": 1e-3, "deg": pi / 180}


def par(name, value, unit=""):
    """A number beside the formula, `value` in `unit`."""
    return ("par", name, value, unit)


def total(*terms):
    """The sum of expressions."""
    result = terms[0]
    for term in terms[1:]:
        result = ("+", result, term)
    return result


def product(*factors):
    """The product of expressions."""
    result = factors[0]
    for factor in factors[1:]:
        result = ("*", result, factor)
    return result


def call(function, argument):
    """A function of one argument."""
    return ("call", function, argument)


def children(e: Expression) -> tuple[Expression, ...]:
    """The expressions in an expression."""
    kind = e[0]
    if kind in ("par", "num", "name"):
        return ()
    if kind == "**":
        return (e[1],)
    if kind == "call":
        return (e[2],)
    if kind == "where":
        return (e[1], e[3], e[4], e[5])
    if kind == "table":
        return (e[1],)
    return e[1:]


def walk(e: Expression):
    """An expression and all that is in it."""
    yield e
    for child in children(e):
        yield from walk(child)


def numbers_of(*expressions):
    """Names of the numbers beside formulas, and their texts with units."""
    found = {}
    for e in expressions:
        for one in walk(e):
            if one[0] == "par":
                found[one[1]] = f"{one[2]!r} {one[3]}".strip()
    return found


def text(e: Expression) -> str:
    """An expression as a formula of a case; every operation in brackets."""
    kind = e[0]
    if kind in ("par", "name"):
        return str(e[1])
    if kind == "num":
        return repr(e[1])
    if kind in ("+", "-", "*", "/"):
        return f"({text(e[1])} {kind} {text(e[2])})"
    if kind == "**":
        return f"{text(e[1])}**{e[2]!r}"
    if kind == "call":
        return f"{e[1]}({text(e[2])})"
    if kind == "where":
        return f"where({text(e[1])} {e[2]} {text(e[3])}, {text(e[4])}, {text(e[5])})"
    if kind == "table":
        pairs = ", ".join(f"[{u!r} {e[3][0]}, {f!r} {e[3][1]}]" for u, f in e[2])
        return f"table({text(e[1])}, [{pairs}], '{e[4]}')"
    return f"{kind}({', '.join(text(child) for child in e[1:])})"


class Compiled:
    """Expressions as one Python function each, with the sides of their switches fixed.

    names : what each name stands for, as Python; switches : all of them, each once, in order
    """

    def __init__(self, names: dict[str, str]) -> None:
        self.names = names
        self.functions: dict[str, Any] = {"np": np, "clip": _clip, "horner": _horner}
        self.switches: list[Expression] = []
        self.guards: list[Any] = []
        self.owners: list[str] = []

    def function(self, e: Expression, owner: str, locals_: dict[str, str] | None = None):
        """(t, y, S) -> value of an expression; owner: name of the part; locals_: names of its place."""
        source = self._code(e, owner, locals_ or {})
        return eval(f"lambda t, y, S: {source}", self.functions)

    def used(self, e: Expression, owner: str) -> list[int]:
        """Numbers of the switches of an expression of a part."""
        return [self.switches.index((owner, one)) for one in walk(e) if one[0] in SWITCHES]

    def _code(self, e, owner, places) -> str:
        kind = e[0]
        if kind == "par":
            return repr(e[2] * UNIT_VALUES.get(e[3], 1.0))
        if kind == "num":
            return repr(e[1])
        if kind == "name":
            return places.get(e[1]) or self.names[e[1]]
        code = [self._code(child, owner, places) for child in children(e)]
        if kind in ("+", "-", "*", "/"):
            return f"({code[0]} {kind} {code[1]})"
        if kind == "**":
            whole = float(e[2]).is_integer()
            return f"({code[0]})**{e[2]!r}" if whole else f"clip({code[0]})**{e[2]!r}"
        if kind == "call":
            name = {"asin": "arcsin", "acos": "arccos", "atan": "arctan"}.get(e[1], e[1])
            return f"np.{name}({code[0]})"
        i = self._switch(e, owner, code)
        return _side_code(e, i, code)

    def _switch(self, e, owner, code) -> int:
        if (owner, e) in self.switches:
            return self.switches.index((owner, e))
        guard = {"max": "{0} - {1}", "min": "{1} - {0}", "where": "{1} - {0}"}.get(e[0], "{0}")
        self.switches.append((owner, e))
        self.owners.append(owner)
        source = guard.format(*code)
        self.guards.append(eval(f"lambda t, y, S: {source}", self.functions))
        return len(self.switches) - 1

    # Sides: +1 or -1 of the sign of the guard; of mod the whole number of turns, of a table its piece.

    def side(self, i: int, t, y, S) -> int:
        """The side on which switch i is at a state."""
        e, value = self.switches[i][1], self.guards[i](t, y, S)
        if e[0] == "mod":
            return floor(value / _number(e[2]))
        if e[0] == "table":
            return sum(1 for u, _ in e[2] if value >= u)
        return 1 if value >= 0 else -1

    def margins(self, i: int, t, y, S) -> list[tuple[float, int]]:
        """What stays positive while switch i is on its side, and the side behind each zero."""
        e, value, side = self.switches[i][1], self.guards[i](t, y, S), S[i]
        if e[0] == "mod":
            step = _number(e[2])
            return [(value - side * step, side - 1), ((side + 1) * step - value, side + 1)]
        if e[0] == "table":
            knots = [u for u, _ in e[2]]
            below = [(value - knots[side - 1], side - 1)] if side > 0 else []
            return below + ([(knots[side] - value, side + 1)] if side < len(knots) else [])
        return [(value * side, -side)]


def _clip(value):
    return value if value > 0 else 0.0


def _number(e: Expression) -> float:
    return e[2] * UNIT_VALUES.get(e[3], 1.0) if e[0] == "par" else e[1]


def _side_code(e, i, code) -> str:
    kind, on = e[0], f"S[{i}]"
    if kind == "abs":
        return f"({on} * ({code[0]}))"
    if kind == "sign":
        return f"{on}"
    if kind == "step":
        return f"(1.0 if {on} > 0 else 0.0)"
    if kind in ("max", "min"):
        return f"({code[0]} if {on} > 0 else {code[1]})"
    if kind == "where":
        return f"({code[2]} if {on} > 0 else {code[3]})"
    if kind == "mod":
        return f"({code[0]} - {on} * {code[1]})"
    return _piece_code(e, on, code[0])


def _piece_code(e, on, u) -> str:
    """A table on one of its pieces: the polynomial of it, or an end value."""
    knots, values = zip(*e[2], strict=True)
    if e[4] == "cubic":
        pieces = CubicSpline(knots, values, bc_type="not-a-knot").c[::-1].T.tolist()  # lowest power first
    else:
        pairs = zip(e[2], e[2][1:], strict=False)
        pieces = [[f, (g - f) / (w - u)] for (u, f), (w, g) in pairs]
    table = [[values[0]], *pieces, [values[-1]]]
    starts = [0.0, *knots]
    return f"horner({table!r}[{on}], {u} - {starts!r}[{on}])"


def _horner(coefficients, u):
    total = 0.0
    for c in reversed(coefficients):
        total = total * u + c
    return total
