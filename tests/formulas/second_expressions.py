"""Formulas of random scenes for the second solver: as Python functions with the sides of switches fixed.

They are read by Python's own parser; nothing here is vibsim's.
"""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass
from itertools import pairwise
from math import floor, pi
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

FUNCTIONS = {name: f"np.{name}" for name in ("exp", "log", "sqrt", "sin", "cos", "sinh", "cosh", "tanh")}
FUNCTIONS |= {"asin": "np.arcsin", "atan": "np.arctan"}
OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**"}
UNIT_VALUES = {"Hz": 2 * pi, "mm": 1e-3}
UNIT_IN_TABLE = re.compile(r"(?<=\d) [A-Za-z]+(?=[],])")


@dataclass(frozen=True)
class Law:
    """A formula of a case, and the numbers beside it as texts with units."""

    text: str
    numbers: dict[str, str]

    @property
    def tree(self) -> ast.expr:
        return ast.parse(UNIT_IN_TABLE.sub("", self.text), mode="eval").body


def law_of(text: str, numbers: dict[str, str]) -> Law:
    """A formula with those of the numbers that it names."""
    names = {node.id for node in ast.walk(Law(text, {}).tree) if isinstance(node, ast.Name)}
    return Law(text, {name: value for name, value in numbers.items() if name in names})


def si_value(text: str) -> float:
    """A number with its unit, in SI units."""
    value, _, unit = text.partition(" ")
    return float(value) * UNIT_VALUES.get(unit, 1.0)


@dataclass
class Switch:
    """A switch of a part: its guard, a function of (t, y, S), the step of a mod, the knots of a table."""

    owner: str
    text: str
    kind: str
    guard: Any
    step: float = 0.0
    knots: tuple[float, ...] = ()

    def side(self, t, y, S) -> int:
        """+1 or -1 by the sign of the guard; of mod the whole number of turns, of a table its piece."""
        value = self.guard(t, y, S)
        if self.kind == "mod":
            return floor(value / self.step)
        if self.kind == "table":
            return sum(1 for u in self.knots if value >= u)
        return 1 if value >= 0 else -1

    def margins(self, side, t, y, S) -> list[tuple[float, int]]:
        """What stays positive while the switch is on a side, and the side behind each zero."""
        value = self.guard(t, y, S)
        if self.kind == "mod":
            return [(value - side * self.step, side - 1), ((side + 1) * self.step - value, side + 1)]
        if self.kind == "table":
            below = [(value - self.knots[side - 1], side - 1)] if side > 0 else []
            return below + ([(self.knots[side] - value, side + 1)] if side < len(self.knots) else [])
        return [(value * side, -side)]


class Compiled:
    """Formulas as one Python function each. names : what each name stands for, as Python"""

    def __init__(self, names: dict[str, str]) -> None:
        self.names = names
        self.functions: dict[str, Any] = {"np": np, "clip": _clip, "horner": _horner}
        self.switches: list[Switch] = []

    def function(self, law: Law, owner: str, places: dict[str, str] | None = None):
        """(t, y, S) -> value of the law of a part; places: names of its place."""
        numbers = {name: repr(si_value(text)) for name, text in law.numbers.items()}
        return self._made(self._code(law.tree, owner, self.names | (places or {}) | numbers))

    def _made(self, code: str):
        return eval(f"lambda t, y, S: {code}", self.functions)

    def _code(self, node, owner, names) -> str:
        if isinstance(node, ast.Constant):
            return repr(node.value)
        if isinstance(node, ast.Name):
            return names[node.id]
        if isinstance(node, ast.UnaryOp):
            return f"(-{self._code(node.operand, owner, names)})"
        if isinstance(node, ast.BinOp):
            a, b = (self._code(each, owner, names) for each in (node.left, node.right))
            if isinstance(node.op, ast.Pow) and not float(b).is_integer():
                a = f"clip({a})"
            return f"({a} {OPERATORS[type(node.op)]} {b})"
        if node.func.id in FUNCTIONS:
            return f"{FUNCTIONS[node.func.id]}({self._code(node.args[0], owner, names)})"
        return self._switched(node, owner, names)

    def _switched(self, node, owner, names) -> str:
        """A switch on the side that it has."""
        kind, first = node.func.id, node.args[0]
        compared = [first.left, *first.comparators] if kind == "where" else [first]
        arguments = compared if kind == "table" else [*compared, *node.args[1:]]
        code = [self._code(each, owner, names) for each in arguments]
        pairs = ast.literal_eval(node.args[1]) if kind == "table" else []
        i = self._number(node, owner, code, tuple(u for u, _ in pairs))
        on = f"S[{i}]"
        if kind == "table":
            return _piece_code(pairs, node.args[2].value, on, code[0])
        return {
            "abs": "({on} * {0})",
            "sign": "{on}",
            "step": "(1.0 if {on} > 0 else 0.0)",
            "max": "({0} if {on} > 0 else {1})",
            "min": "({0} if {on} > 0 else {1})",
            "where": "({2} if {on} > 0 else {3})",
            "mod": "({0} - {on} * {1})",
        }[kind].format(*code, on=on)

    def _number(self, node, owner, code, knots) -> int:
        """The place of a switch among all, where each is once."""
        text, kind = ast.unparse(node), node.func.id
        for i, switch in enumerate(self.switches):
            if (switch.owner, switch.text) == (owner, text):
                return i
        guard = {"max": "{0} - {1}", "min": "{1} - {0}", "where": "{1} - {0}"}.get(kind, "{0}")
        step = float(code[1]) if kind == "mod" else 0.0
        self.switches.append(Switch(owner, text, kind, self._made(guard.format(*code)), step, knots))
        return len(self.switches) - 1


def _clip(value):
    return value if value > 0 else 0.0


def _piece_code(pairs, kind, on, u) -> str:
    """A table on one of its pieces: the polynomial of it, or an end value."""
    knots, values = zip(*pairs, strict=True)
    if kind == "cubic":
        pieces = CubicSpline(knots, values, bc_type="not-a-knot").c[::-1].T.tolist()  # lowest power first
    else:
        pieces = [[f, (g - f) / (w - u)] for (u, f), (w, g) in pairwise(pairs)]
    table = [[values[0]], *pieces, [values[-1]]]
    starts = [0.0, *knots]
    return f"horner({table!r}[{on}], {u} - {starts!r}[{on}])"


def _horner(coefficients, u):
    total = 0.0
    for c in reversed(coefficients):
        total = total * u + c
    return total
