"""Rows of a mode that formulas make: its tape, the forces on it, and the event functions of their switches.

A switch of a formula (|v|, max, where, a knot of a table, ...) is on one side in a mode; the function that
tells the side ends the mode at its zero. Switches are numbered in the order in which the parts of the scene
read them. A formula that no part of the mode reads, that of a stop which is open, leaves its switches asleep:
without a side.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from itertools import chain, islice
from typing import Any, Generic, NamedTuple

from vibsim.engine.flows.tape import (
    CONSTANT,
    INPUTS,
    PLACE,
    SUB,
    Inputs,
    Op,
    Tape,
    TapeMaker,
    TapeValues,
    chosen,
    input_value,
    motion_tape,
    quotient,
    start_value,
)
from vibsim.engine.modes.rows import (
    DOMAIN,
    FORMULA,
    NO_ZERO,
    SWITCH,
    Event,
    FormulaForce,
    Joined,
    ModeRows,
    Term,
    Terms,
)
from vibsim.engine.modes.status import CONTACT, LIFTED, OPEN, STICK, Kept, Status
from vibsim.engine.modes.ties import Cut
from vibsim.physics.formulas import (
    ONE,
    SWITCHES,
    TIME,
    ZERO,
    Node,
    add,
    children,
    derivative,
    div,
    hashed,
    is_continuous,
    mul,
    num,
    power,
    resolved,
    sub,
    value_of,
    walk,
)
from vibsim.physics.numbers import Doubles, Kit, N, abs
from vibsim.physics.parts import BASE, Scene, Stop
from vibsim.physics.traced_numbers import RecordedNumbers, as_double

PROBES = (0.618, 1.414, 2.236)  # depths at which functions are compared, of no special meaning
IRRATIONALS = (0.7548776662, 0.5698402910, 0.8191725134)  # whose multiples give all else that they read
MOST_SIDES = 10_000  # of switches, which are not asked for anew
MOST_MODES = 1000  # whose sides are kept by node
UNKNOWN: Node = ()  # in place of a switch that has not been looked for
SAME = 2.0**-40  # ratios of two functions that differ by less are one


class Root(NamedTuple):
    """A formula that a mode reads: for what, and the name of its part."""

    node: Node
    role: tuple[Any, ...]
    text: str


class _LessDepth(NamedTuple):
    """What is left of a formula without a power of the depth of a stop; depth: that power is of this node,
    None where it is of a multiple.
    """

    exponent: Fraction
    rest: Node
    depth: Node | None = None


def watched_by(node: Node) -> tuple[Node, int]:
    """Node that a switch watches, the same for all that turn at the same instants, and -1 where its upper
    side is where that is negative.
    """
    if node[0] != "choose":
        return (node[0], *node[1:3]), 1
    guard, sign = node[1], 1
    while guard[0] == "mul" and guard[1][0] == "num":
        sign = sign if guard[1][1] > 0 else -sign
        guard = guard[2]
    if guard[0] == "sub" and repr(guard[1]) > repr(guard[2]):
        guard, sign = sub(guard[2], guard[1]), -sign
    return ("choose", guard), sign


class FormulaRows(Generic[N]):
    """Makes what formulas add to the rows of the modes of a scene.

    switches : all of them; owners : name of the part that has each, and its place among `event_parts`
    """

    def __init__(self, scene: Scene[N], kit: Kit[N], columns: Mapping[int, int]) -> None:
        self.scene, self.kit, self.columns = scene, kit, columns
        self.n = len(scene.bodies)
        self.switches: list[Node] = []
        self.owners: list[str] = []
        self.same: dict[Node, tuple[int, int]] = {}  # by node: its switch, and -1 where it is turned round
        known: dict[Node, tuple[int, int]] = {}
        roots = list(self._all_roots())
        nodes = hashed(root.node for root in roots)
        self.all_roots = [Root(node, *root[1:]) for node, root in zip(nodes, roots, strict=True)]
        self._outer: dict[Node, tuple[Node, ...]] = {}  # the switches in a node that are in no other one
        for root in self.all_roots:
            for node in walk([root.node]):
                if node not in self._outer:
                    below = (self._outer[child] for child in reversed(children(node)))
                    inside = dict.fromkeys(chain.from_iterable(below))
                    self._outer[node] = (node,) if node[0] in SWITCHES else tuple(inside)
                if node[0] in SWITCHES and node not in self.same:
                    watched, sign = watched_by(node)
                    if watched not in known:
                        known[watched] = len(self.switches), sign
                        self.switches.append(node)
                        self.owners.append(root.text)
                    number, first = known[watched]
                    self.same[node] = number, sign * first
        by_speed: list[Joined] = [*self.scene.frictions, *(stop for _, stop in self.scene.rigid_stops)]
        by_speed += [stop for _, stop in self.scene.elastic_stops if stop.c != 0 or stop.force is not None]
        by_speed += [link for link in self.scene.links if link.c != 0 or link.force is not None]
        on_base = any(BASE in (part.P, part.Q) for part in by_speed)
        moving = ("course", "base") if on_base else ("course",)
        of_courses = walk([root.node for root in self.all_roots if root.role[0] in moving])
        self.of_courses = {self.same[node][0] for node in of_courses if node[0] in SWITCHES}
        self._read = Kept[tuple[tuple[int, ...], tuple[int, ...]], list[Root]](MOST_SIDES)
        self._sides = Kept[tuple[int | None, ...], dict[Node, int]](MOST_MODES)
        self._awake = Kept[tuple[Any, ...], Node | None](MOST_SIDES)
        self._bending: dict[int, bool] = {}
        self._by_stops = Kept[tuple[Node, tuple[int, ...]], int](MOST_SIDES)
        self._tapes = Kept[tuple[Any, ...], Tape](MOST_SIDES)
        self._within = Kept[Node, list[Node]](MOST_SIDES)
        self.behind = {node: self.within(node[1]) for node in self.same}

    def _all_roots(self) -> Iterator[Root]:
        """Every formula of the scene."""
        if self.scene.base_formula is not None:
            yield Root(self.scene.base_formula, ("base",), "base")
        for i, force in enumerate(self.scene.forces):
            if force.formula is not None:
                yield Root(force.formula, ("force", i), force.name)
        for i, link in enumerate(self.scene.links):
            if link.force is not None:
                yield Root(link.force, ("link", i), link.name)
        for i, stop in self.scene.elastic_stops:
            if stop.force is not None:
                yield Root(stop.force, ("stop", i), stop.name)
        for k, friction in enumerate(self.scene.frictions):
            for sense, node in zip((1, -1), friction.slips or (), strict=False):
                yield Root(node, ("slip", k, sense), friction.name)
            for sense, node in zip((1, -1), friction.holds or (), strict=False):
                yield Root(node, ("hold", k, sense), friction.name)
            if friction.course is not None:
                yield Root(friction.course, ("course", k), friction.name)

    def roots(self, status: Status) -> list[Root]:
        """The formulas that a mode reads."""
        key = status[:2]
        known = self._read.get(key)
        if known is None:
            known = self._read.keep(key, [root for root in self.all_roots if self._is_read(root, status)])
        return known

    @staticmethod
    def _is_read(root: Root, status: Status) -> bool:
        role = root.role
        if role[0] == "stop":
            return bool(status.stops[role[1]] != OPEN)
        if role[0] in ("slip", "hold"):
            side = status.frictions[role[1]]
            return bool(side == (role[2] if role[0] == "slip" else STICK))
        return True

    def only_bends(self, i: int) -> bool:
        """Whether switch `i` is one of continuous formulas alone, as |a|: where it turns nothing jumps, nor
        does the acceleration of a belt, or the velocity of a base that something sticks to, rests on or is
        damped by.
        """
        bends = self._bending.get(i)
        if bends is None:
            bends = i not in self.of_courses and all(
                is_continuous(node) for node, (number, _) in self.same.items() if number == i
            )
            self._bending[i] = bends
        return bends

    def sides(self, status: Status) -> dict[Node, int]:
        """The sides of the switches that are awake."""
        known = self._sides.get(status.switches)
        if known is None:
            sides = status.switches or (None,) * len(self.switches)
            made = ((node, sign, sides[i]) for node, (i, sign) in self.same.items())
            known = {node: sign * side for node, sign, side in made if side is not None}
            known = self._sides.keep(status.switches, known)
        return known

    def awake(self, status: Status, sides: Mapping[Node, int]) -> Iterator[Node]:
        """The switches that a mode reads, those first that others stand behind; `sides` may come to hold each
        before the next is asked for. What follows on the sides of those before it is found once.
        """
        key: tuple[Any, ...] = status[:2]
        found: Iterator[Node] | None = None
        for count in itertools.count():
            node = self._awake.get(key, UNKNOWN)
            if node is UNKNOWN:
                found = found or islice(self._found_awake(status, sides), count, None)
                node = self._awake.keep(key, next(found, None))
            if node is None:
                return
            yield node
            key = (*key, sides.get(node))

    def _found_awake(self, status: Status, sides: Mapping[Node, int]) -> Iterator[Node]:
        """The same, by going through the formulas."""
        ahead = [node for root in self.roots(status) for node in reversed(self._outer[root.node])]
        seen: set[Node] = set()
        while ahead:
            node = ahead.pop()
            if node in seen:
                continue
            behind = [one for one in self.behind[node] if one not in seen]
            if behind:
                ahead += [node, *behind]
                continue
            seen.add(node)
            yield node
            below = (node[1], chosen(node, sides)) if node[0] == "choose" else children(node)
            for one in below:
                ahead += reversed(self._outer[one])

    def watched(self, rows: ModeRows[N]) -> bool:
        """Whether the sides of a mode are those of the switches that its formulas read, no more and no less,
        and event functions tell where each of them ends.
        """
        awake = rows.awake
        if awake != {i for i, side in enumerate(rows.status.switches) if side is not None}:
            return False
        return all(
            ("switch", i, key) in rows.outputs
            for i in awake
            for key, _, _ in self._guards(i, self.switches[i], rows.sides)
        )

    def guard_values(self, node: Node, sides: Mapping[Node, int], at: Inputs[N], blur: Inputs[N]) -> list[N]:
        """Values, each followed by the bound of its rounding, of the argument of a switch; of `mod` that of
        its step behind it.
        """
        read = node[1 : 3 if node[0] == "mod" else 2]
        values = TapeValues(self.kit, self.tape(read, sides), at, blur)
        return [value for k in range(len(read)) for value in values.output(k)]

    def tape(self, nodes: Sequence[Node], sides: Mapping[Node, int]) -> Tape:
        """A tape with formulas of the scene, or what they are made of, as its outputs."""
        key = *nodes, *(sides.get(one) for node in nodes for one in self.within(node))
        tape = self._tapes.get(key)
        if tape is None:
            maker = TapeMaker(self.kit, sides, self.columns)
            for node in nodes:
                maker.output(node)
            tape = self._tapes.keep(key, maker.tape)
        return tape

    def within(self, node: Node) -> list[Node]:
        """The switches in a formula."""
        known = self._within.get(node)
        if known is None:
            known = self._within.keep(node, [one for one in walk([node]) if one[0] in SWITCHES])
        return known

    def write(self, rows: ModeRows[N], courses: Sequence[Mapping[Node, int]] = ()) -> None:
        """Write the tape of a mode and its forces into its rows.

        courses : of each column, the belts by formulas between it and the group that it is in, with signs
        """
        status, sides = rows.status, self.sides(rows.status)
        maker = TapeMaker(self.kit, sides, self.columns)
        outputs: dict[tuple[object, ...], int] = {}
        for node, role, text in self.roots(status):
            if role[0] == "base":
                of_base = TapeMaker(self.kit, sides, self.columns)
                of_base.output(node, text)
                rows.base_tape = of_base.tape
                rows.base_values = motion_tape(self.kit, node, sides, text)
                continue
            if self._is_idle(maker, role, status, sides):
                continue
            outputs[role] = k = maker.output(node, text)
            rows.nodes[k] = node
            if role[0] in ("hold", "course"):
                continue
            P, Q, sign = self._ends(role, status)
            course = self.scene.frictions[role[1]].course if role[0] == "slip" else None
            if course is not None:
                outputs["power", role[1]] = k_power = maker.output(mul(node, course), text)
                rows.nodes[k_power] = mul(node, course)
            if sign:
                rows.formulas.append(FormulaForce(k, P, Q, sign))
        self._carry(rows, courses, maker, sides)
        roots = len(maker.tape.outputs)
        self._write_pushes(rows, maker, outputs, sides)
        rows.awake = {self.same[node][0] for node in self.awake(status, sides)}
        watched = {
            i: list(self._guards(i, self.switches[i], sides))
            for i in sorted(rows.awake)
            if self.switches[i] in sides
        }
        for i, guards in watched.items():
            for key, node, sign in guards:
                if self._sign_by_stops(maker, maker.place(node), status) != sign:
                    outputs["switch", i, key] = k = maker.output(node, self.owners[i])
                    rows.nodes[k] = node
        kept = [(maker.place(node), sign) for guards in watched.values() for _, node, sign in guards]
        for place in maker.bases:
            if not (self._kept(maker, place, kept) or self._sign_by_stops(maker, place, status) > 0):
                outputs["base", place] = len(maker.tape.outputs)
                maker.tape.texts.append(self._owner(maker.tape, place, roots))
                maker.tape.outputs.append(place)
        rows.tape, rows.outputs, rows.sides = maker.tape, outputs, sides
        rows.columns = dict(self.columns)

    def _carry(
        self,
        rows: ModeRows[N],
        courses: Sequence[Mapping[Node, int]],
        maker: TapeMaker[N],
        sides: Mapping[Node, int],
    ) -> None:
        """What belts by formulas do to those who stick on them: the acceleration r of each beside that of its
        group, the force m r that this takes, and the torque u sin(phi) r on each rotor that it has.
        """
        names = {one.course: one.name for one in self.scene.frictions if one.course is not None}
        for c, signs in enumerate(courses[: self.n]):
            if not signs:
                continue
            rate = ZERO
            for course, sign in signs.items():
                rate = add(rate, mul(num(sign), derivative(resolved(course, dict(sides)), TIME)))
            text = names[next(iter(signs))]
            rows.follow[c] = k = maker.output(rate, text)
            rows.nodes[k] = rate
            inertia = maker.scaled_output(rate, self.scene.bodies[c].m, text)
            rows.nodes[inertia] = rate
            rows.formulas.append(FormulaForce(inertia, c, -1, -1))
            for rotor in self.scene.rotors:
                if rotor.on == c and rotor.unbalance:
                    node = mul(("sin", ("x", rotor.column)), rate)
                    torque = maker.scaled_output(node, rotor.unbalance, text)
                    rows.nodes[torque], rows.factors[torque] = node, rotor.unbalance
                    rows.formulas.append(FormulaForce(torque, rotor.column, -1, 1))

    def _write_pushes(
        self, rows: ModeRows[N], maker: TapeMaker[N], outputs: dict[tuple[object, ...], int], sides: Any
    ) -> None:
        """For stops that let go at zero force: what is left of it without powers of the depth, which
        tells its sign up to depth 0 and goes through the zeros that it has.
        """
        for i, stop in self.scene.elastic_stops:
            if stop.force is not None and stop.lets_go and rows.status.stops[i] != OPEN:
                rest = self._less_depth(maker, stop.force, stop, sides).rest
                value = value_of(rest)
                if value is not None and value > 0:
                    outputs["push", i] = NO_ZERO
                elif value is None and rest != stop.force:
                    outputs["push", i] = k = maker.output(rest, stop.name)
                    rows.nodes[k] = rest

    def _is_idle(
        self, maker: TapeMaker[N], role: tuple[Any, ...], status: Status, sides: Mapping[Node, int]
    ) -> bool:
        """Whether a formula is the force of a stop that has let go, and what is left of it without powers of
        the depth is read in its place: next to the depth 0 those powers would ask for steps of no length.
        """
        if role[0] != "stop" or status.stops[role[1]] != LIFTED:
            return False
        stop = self.scene.stops[role[1]]
        assert isinstance(stop, Stop) and stop.force is not None
        rest = self._less_depth(maker, stop.force, stop, sides).rest
        value = value_of(rest)
        return rest != stop.force if value is None else value > 0

    def _less_depth(
        self, maker: TapeMaker[N], node: Node, stop: Stop[N], sides: Mapping[Node, int]
    ) -> _LessDepth:
        """A formula without its factors that are powers of the depth of a stop; of a sum those that all its
        terms have.
        """
        kind = node[0]
        if kind == "choose" and node in sides:
            return self._less_depth(maker, chosen(node, sides), stop, sides)
        if kind in ("mul", "add", "sub"):
            a, b = (self._less_depth(maker, one, stop, sides) for one in node[1:3])
            if kind == "mul":
                depth = a.depth if b.exponent == 0 else b.depth if a.exponent == 0 else a.depth and b.depth
                if a.exponent + b.exponent > 0:
                    return _LessDepth(a.exponent + b.exponent, mul(a.rest, b.rest), depth)
            common, depth = min(a.exponent, b.exponent), a.depth and b.depth
            if kind != "mul" and common > 0 and depth:
                a_rest, b_rest = (mul(one.rest, power(depth, num(one.exponent - common))) for one in (a, b))
                return _LessDepth(common, (add if kind == "add" else sub)(a_rest, b_rest), depth)
        if kind == "div":
            a = self._less_depth(maker, node[1], stop, sides)
            return a._replace(rest=div(a.rest, node[2]))
        base, exponent = (node[1], node[2]) if kind == "pow" and node[2] > 0 else (node, Fraction(1))
        ratio = 0.0 if value_of(base) else max(0.0, self._ratio(maker, maker.place(base), stop))
        if not ratio:
            return _LessDepth(Fraction(0), node)
        if base[0] == "mul" and base[1][0] == "num" and base is node:  # c p, which a gap of 0 makes one
            c = abs(base[1][1])
            if abs(ratio - as_double(c)) <= SAME * as_double(c):
                return _LessDepth(exponent, num(c), mul(num(1 / c), base))
        return _LessDepth(exponent, ONE, base if abs(ratio - 1) <= SAME else None)

    def _ends(self, role: tuple[Any, ...], status: Status) -> tuple[int, int, int]:
        """Columns of P and Q of a force, -1 for none, and the sign with which it acts on P; 0 where it does
        not.
        """
        scene, i = self.scene, role[1]
        assert isinstance(i, int)
        if role[0] == "force":
            return scene.forces[i].on, -1, 1
        parts: dict[str, Sequence[Joined]] = {
            "link": scene.links,
            "stop": scene.stops,
            "slip": scene.frictions,
        }
        part = parts[role[0]][i]
        if role[0] == "link":
            sign = -1
        elif role[0] == "stop":
            sign = scene.stops[i].sense if status.stops[i] == CONTACT else 0
        else:
            sign = -1 if role[2] == 1 else 1
        P, Q = (end if end >= 0 else self.columns[end] for end in (part.P, part.Q))
        return P, Q, sign

    @staticmethod
    def _guards(i: int, node: Node, sides: Mapping[Node, int]) -> Iterator[tuple[int, Node, int]]:
        """Event functions of a switch: (number of the zero, formula, sign with which it is positive)."""
        side = sides[node]
        if node[0] == "choose":
            yield 0, node[1], side
        elif node[0] == "mod":
            yield side, sub(node[1], mul(num(side), node[2])), 1
            yield side + 1, sub(node[1], mul(num(side + 1), node[2])), -1
        else:
            _, u, knots, pieces, _ = node
            if side >= 0:
                yield side, sub(u, num(knots[side])), 1
            if side < len(pieces):
                yield side + 1, sub(u, num(knots[side + 1])), -1

    @staticmethod
    def _owner(tape: Tape, place: int, roots: int) -> str:
        """Part of the first output that needs the result at a place of the tape; `roots` are
        asked.
        """
        needing = (k for k in range(roots) if place in tape.behind(tape.outputs[k]))
        return tape.texts[next(needing, 0)]

    def _sign_by_stops(self, maker: TapeMaker[N], place: int, status: Status) -> int:
        """Sign of a function on the tape that is the depth of an elastic stop but for a factor; 0 where it is
        that of none.
        """
        for i, stop in self.scene.elastic_stops:
            ratio = self._ratio(maker, place, stop)
            if ratio != 0:
                return 1 if (ratio > 0) == (status.stops[i] != OPEN) else -1
        return 0

    def _ratio(self, maker: TapeMaker[N], place: int, stop: Stop[N]) -> float:
        """A function on the tape over the depth of a stop, where that is one number; else 0."""
        P, Q = (end if end >= 0 else self.columns[end] for end in (stop.P, stop.Q))
        moved = P if self.n > P else Q
        ops = maker.tape.ops
        if self._is_depth(ops, place, stop, (P, Q)):
            return 1.0  # which needs no probe, nor does what does not read that column
        if not any(ops[one].code == PLACE and ops[one].a == moved for one in maker.tape.behind(place)):
            return 0.0
        ratios = []
        for i, depth in enumerate(PROBES):
            at, gap = self.probes[i], as_double(stop.gap)
            x = [*at.x]
            x[moved] = x[Q] - stop.sense * (gap + depth) if moved == P else x[P] + stop.sense * (gap + depth)
            depth = -(stop.sense * (x[P] - x[Q])) - gap
            ratios.append(self._probed(maker, (i, stop.name), replace(at, x=x), place) / depth)
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

    def _kept(self, maker: TapeMaker[N], place: int, guards: Sequence[tuple[int, int]]) -> bool:
        """Whether a function on the tape is what a switch keeps positive, but for a positive factor: abs(z),
        or d - g within `where(d > g, ...)`. guards : place of each guard, and the sign with which it is
        positive
        """
        if not guards:
            return False
        probes = [((i, None), at) for i, at in enumerate(self.probes)]
        values = {
            one: [self._probed(maker, *probe, one) for probe in probes]
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
        """What formulas read where functions are compared."""
        return [self._probe(i) for i in range(len(PROBES))]

    def _probe(self, i: int) -> Inputs[float]:
        """Numbers of no special meaning for all that formulas read; the ground is at rest."""
        some = [0.1 + (k + 1) * IRRATIONALS[i] % 1 for k in range(2 * self.n + 7)]
        x, v, (t, phi, w) = some[: self.n + 2], some[self.n + 2 : -3], some[-3:]
        x[self.n] = v[self.n] = 0.0
        return Inputs(t, x, v, phi, w)

    @staticmethod
    def _probed(maker: TapeMaker[N], probe: tuple[int, str | None], at: Inputs[float], place: int) -> float:
        """The result at a place of a tape that reads the values of a probe, in doubles."""
        values = maker.probed.setdefault(probe, {})
        if place not in values:
            for one in sorted(maker.tape.behind(place)):
                if one not in values:
                    op = maker.tape.ops[one]
                    plain = op if isinstance(op.value, float) else op._replace(value=as_double(op.value))
                    read = op.code in INPUTS
                    values[one] = (
                        input_value(plain, at) if read else start_value(RecordedNumbers, plain, values)
                    )
        return values[place]

    def side_by_stops(self, node: Node, status: Status) -> int:
        """On which side an elastic stop keeps a switch that watches its depth: the upper one, 1, in contact
        and the lower one, -1, where it is open; 0 where none does.
        """
        key = node, status.stops
        side = self._by_stops.get(key)
        if side is None:
            maker = TapeMaker(self.kit, {}, self.columns)
            plain = node[0] == "choose" and not self.behind[node]
            place = maker.place(node[1]) if plain else 0
            side = self._by_stops.keep(key, self._sign_by_stops(maker, place, status) if plain else 0)
        return side

    def events(self, rows: ModeRows[N]) -> list[Event[N]]:
        """The event functions of the switches of a mode, and of what must not become negative under a
        root.
        """
        events: list[Event[N]] = []
        for role, k in rows.outputs.items():
            if role[0] == "switch":
                _, i, key = role
                guards = self._guards(i, self.switches[i], rows.sides)
                sign = next(sign for number, _, sign in guards if number == key)
                events.append(self._event(SWITCH, i, sign, (SWITCH, i, key), k))
            elif role[0] == "base":
                events.append(self._event(DOMAIN, k, 1, (DOMAIN, role[1]), k))
        return events

    def _event(self, kind: int, part: int, sign: int, key: tuple[int, ...], k: int) -> Event[N]:
        zero = self.kit.number(0)
        return Event(kind, part, sign, key, (Term(FORMULA, sign, k),), zero, zero)

    @staticmethod
    def limits(rows: ModeRows[N], cut: Cut[N], direction: int) -> Terms[N]:
        """Terms that the formulas of the ties of a cut add to the force that it can pass."""
        return tuple(
            Term(FORMULA, 1, rows.outputs["hold", i, orientation * direction])
            for i, orientation in cut.ties
            if ("hold", i, orientation * direction) in rows.outputs
        )


def _is_one_ratio(ratios: Sequence[float]) -> bool:
    """Whether ratios of two functions at several places are one positive number."""
    return bool(ratios[0] > 0 and all(abs(one - ratios[0]) <= SAME * ratios[0] for one in ratios))
