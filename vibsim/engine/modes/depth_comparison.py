"""Comparison of results of a tape with the depths of the elastic stops, and with each other, at probes.

What a formula is but for a factor gives its sign without its value: the depth of a stop in contact is
positive, and so is what a switch keeps so. Functions are compared where what they read is nothing special.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from typing import Generic, NamedTuple

from vibsim.engine.flows.tape import (
    CONSTANT,
    INPUTS,
    PLACE,
    SUB,
    Inputs,
    Op,
    TapeMaker,
    chosen,
    input_value,
    quotient,
    start_value,
)
from vibsim.engine.modes.status import OPEN, Status
from vibsim.physics.formulas import ONE, ZERO, Node, add, div, mul, neg, num, power, sub, value_of
from vibsim.physics.numbers import Doubles, N, abs
from vibsim.physics.parts import Scene, Stop
from vibsim.physics.traced_numbers import RecordedNumbers, as_double

PROBES = (0.618, 1.414, 2.236)  # depths at which functions are compared, of no special meaning
IRRATIONALS = (0.7548776662, 0.5698402910, 0.8191725134)  # whose multiples give all else that they read
SAME = 2.0**-40  # ratios of two functions that differ by less are one


class _LessDepth(NamedTuple):
    """A formula divided by a power of the depth of a stop; depth: that power is of this node,
    None where it is of a multiple.
    """

    exponent: Fraction
    rest: Node
    depth: Node | None = None


class DepthComparison(Generic[N]):
    """The results of the operations of a scene, compared but for a factor.

    columns : of ground and base, by end; maker : whose operations are compared
    """

    def __init__(self, scene: Scene[N], columns: Mapping[int, int], maker: TapeMaker[N]) -> None:
        self.columns, self.maker = columns, maker
        self.n, self.elastic = len(scene.bodies), scene.elastic_stops
        self._ratios: dict[tuple[int, int], float] = {}
        self._probed: dict[tuple[int, int | None], dict[int, float]] = {}
        self._rests: dict[tuple[int | None, ...], Node] = {}

    def rest(self, i: int, stop: Stop[N], force: Node, sides: Mapping[Node, int]) -> Node:
        """The force of a stop divided by powers of its depth."""
        key = i, *map(sides.get, self.maker.within(force))
        rest = self._rests.get(key)
        if rest is None:
            rest = self._rests[key] = self._less_depth(force, i, stop, sides).rest
        return rest

    def _less_depth(self, node: Node, i: int, stop: Stop[N], sides: Mapping[Node, int]) -> _LessDepth:
        """A formula without its factors that are powers of the depth of a stop; of a sum those that all its
        terms have but for those that are 0 on these sides.
        """
        kind = node[0]
        if self._is_zero(node, sides):
            return _LessDepth(Fraction(0), ZERO)
        if kind == "choose" and node in sides:
            return self._less_depth(chosen(node, sides), i, stop, sides)
        if kind in ("mul", "add", "sub"):
            a, b = (self._less_depth(one, i, stop, sides) for one in node[1:3])
            if kind != "mul" and b.rest == ZERO:
                return a
            if kind != "mul" and a.rest == ZERO:
                return b if kind == "add" else b._replace(rest=neg(b.rest))
            if kind == "mul":
                depth = a.depth if b.exponent == 0 else b.depth if a.exponent == 0 else a.depth and b.depth
                if a.exponent + b.exponent > 0:
                    return _LessDepth(a.exponent + b.exponent, mul(a.rest, b.rest), depth)
            common, depth = min(a.exponent, b.exponent), a.depth and b.depth
            if kind != "mul" and common > 0 and depth:
                a_rest, b_rest = (mul(one.rest, power(depth, num(one.exponent - common))) for one in (a, b))
                return _LessDepth(common, (add if kind == "add" else sub)(a_rest, b_rest), depth)
        if kind == "div":
            a = self._less_depth(node[1], i, stop, sides)
            return a._replace(rest=div(a.rest, node[2]))
        base, exponent = (node[1], node[2]) if kind == "pow" and node[2] > 0 else (node, Fraction(1))
        ratio = 0.0 if value_of(base) else max(0.0, self._ratio(self.maker.place(base, sides), i, stop))
        if not ratio:
            return _LessDepth(Fraction(0), node)
        if base[0] == "mul" and base[1][0] == "num" and base is node:  # c p, which a gap of 0 makes one
            c = abs(base[1][1])
            if abs(ratio - as_double(c)) <= SAME * as_double(c):
                return _LessDepth(exponent, num(c), mul(num(1 / c), base))
        return _LessDepth(exponent, ONE, base if abs(ratio - 1) <= SAME else None)

    def _is_zero(self, node: Node, sides: Mapping[Node, int]) -> bool:
        op = self.maker.ops[self.maker.place(node, sides)]
        return op.code == CONSTANT and op.value == 0

    def sign_by_stops(self, place: int, status: Status) -> int:
        """Sign of a result that is the depth of an elastic stop but for a factor; else 0."""
        for i, stop in self.elastic:
            ratio = self._ratio(place, i, stop)
            if ratio != 0:
                return 1 if (ratio > 0) == (status.stops[i] != OPEN) else -1
        return 0

    def _ratio(self, place: int, i: int, stop: Stop[N]) -> float:
        """A result over the depth of elastic stop `i`, where that is one number; else 0."""
        if (place, i) not in self._ratios:
            self._ratios[place, i] = self._ratio_by_probes(place, i, stop)
        return self._ratios[place, i]

    def _ratio_by_probes(self, place: int, i: int, stop: Stop[N]) -> float:
        P, Q = (end if end >= 0 else self.columns[end] for end in (stop.P, stop.Q))
        moved = P if self.n > P else Q
        ops = self.maker.ops
        if self._is_depth(ops, place, stop, (P, Q)):
            return 1.0  # which needs no probe, nor does what does not read that column
        if not any(ops[one].code == PLACE and ops[one].a == moved for one in self.maker.needed([place])):
            return 0.0
        ratios = []
        for k, depth in enumerate(PROBES):
            at, gap = self.probes[k], as_double(stop.gap)
            x = [*at.x]
            x[moved] = x[Q] - stop.sense * (gap + depth) if moved == P else x[P] + stop.sense * (gap + depth)
            depth = -(stop.sense * (x[P] - x[Q])) - gap
            ratios.append(self._value((k, i), replace(at, x=x), place) / depth)
        sign = -1 if ratios[0] < 0 else 1
        return ratios[0] if _is_one_ratio([sign * ratio for ratio in ratios]) else 0.0

    @staticmethod
    def _is_depth(ops: Sequence[Op], place: int, stop: Stop[N], ends: tuple[int, int]) -> bool:
        """Whether a result is the depth of a stop between two columns as cases write it, x_Q - x_P - gap."""
        op = ops[place]
        if stop.gap != 0 and op.code == SUB and ops[op.b].code == CONSTANT and ops[op.b].value == stop.gap:
            op = ops[op.a]
        elif stop.gap != 0:
            return False
        if op.code != SUB or ops[op.a].code != PLACE or ops[op.b].code != PLACE:
            return False
        return (ops[op.a].a, ops[op.b].a) == (ends[::-1] if stop.sense > 0 else ends)

    def kept(self, place: int, guards: Sequence[tuple[int, int]]) -> bool:
        """Whether a result is what a switch keeps positive, but for a positive factor: abs(z),
        or d - g within `where(d > g, ...)`. guards : place of each guard, and the sign with which it is
        positive
        """
        if not guards:
            return False
        values = {
            one: [self._value((k, None), at, one) for k, at in enumerate(self.probes)]
            for one in (place, *(k for k, _ in guards))
        }
        return any(
            _is_one_ratio(
                [quotient(Doubles, sign * a, b) for a, b in zip(values[place], values[k], strict=True)]
            )
            for k, sign in guards
        )

    @cached_property
    def probes(self) -> list[Inputs[float]]:
        """The inputs at which formulas are compared: numbers of no special meaning; the ground is at rest."""
        probes = []
        for one in IRRATIONALS:
            some = [0.1 + (k + 1) * one % 1 for k in range(2 * self.n + 7)]
            x, v, (t, phi, w) = some[: self.n + 2], some[self.n + 2 : -3], some[-3:]
            x[self.n] = v[self.n] = 0.0
            probes.append(Inputs(t, x, v, phi, w))
        return probes

    def _value(self, probe: tuple[int, int | None], at: Inputs[float], place: int) -> float:
        """The result at a place that reads the values of a probe, in doubles."""
        values = self._probed.setdefault(probe, {})
        if place not in values:
            for one in self.maker.needed([place]):
                if one not in values:
                    op = self.maker.ops[one]
                    plain = op if isinstance(op.value, float) else op._replace(value=as_double(op.value))
                    read = op.code in INPUTS
                    values[one] = (
                        input_value(plain, at) if read else start_value(RecordedNumbers, plain, values)
                    )
        return values[place]


def _is_one_ratio(ratios: Sequence[float]) -> bool:
    """Whether ratios of two functions at several places are one positive number."""
    return bool(ratios[0] > 0 and all(abs(one - ratios[0]) <= SAME * ratios[0] for one in ratios))
