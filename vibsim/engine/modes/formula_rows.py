"""Rows of a mode that formulas make: its tape, the forces on it, and the event functions of their switches.

A switch of a formula (|v|, max, where, a knot of a table, ...) is on one side in a mode; the function that
tells the side ends the mode at its zero. Switches are numbered in the order in which the parts of the scene
read them. A formula that no part of the mode reads, that of a stop which is open, leaves its switches asleep:
without a side.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import chain, islice
from threading import RLock
from typing import Any, Generic, NamedTuple

from vibsim.engine.flows.tape import POWER, Inputs, Tape, TapeMaker, TapeValues, chosen, motion_tape
from vibsim.engine.modes.depth_comparison import DepthComparison
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
from vibsim.physics.connections import event_parts
from vibsim.physics.formulas import (
    TIME,
    ZERO,
    HashedNode,
    Node,
    add,
    children,
    derivative,
    hashed,
    is_continuous,
    mul,
    num,
    resolved,
    sub,
    value_of,
)
from vibsim.physics.numbers import Kit, N
from vibsim.physics.parts import BASE, Scene, Stop

MOST_SIDES = 10_000  # of switches, which are not asked for anew
MOST_MODES = 1000  # whose sides are kept by node
MOST_OPERATIONS = 5000  # of tapes, from which on all are forgotten
SIDE = "side."  # begins the name of a column of events that tells the side of a switch
ZERO_UNIT = 2.0**-20  # of an order of a zero that is told beside a side, as in recording.c
UNKNOWN: Node = ()  # in place of a switch, where there is none more


class Root(NamedTuple):
    """A formula that a mode reads: for what, and the name of its part."""

    node: HashedNode
    role: tuple[Any, ...]
    text: str


# By the sides of the switches before it: the next switch that a mode reads, as `FormulaRows.awake` says.
Steps = Kept[tuple[int | None, ...], tuple[Node, int, int]]


class Read(NamedTuple):
    """The formulas of a mode, and the switches in them that are in no other one, the same for many modes."""

    roots: list[Root]
    outer: tuple[Node, ...]
    steps: Steps


Guard = tuple[int, Node, int]  # of a switch: number of the zero, formula, sign with which it is positive


class Outputs(Generic[N]):
    """The outputs of the tape of a mode: their places among the operations, and what they belong to."""

    def __init__(self, maker: TapeMaker[N], rows: ModeRows[N]) -> None:
        self.maker, self.rows = maker, rows
        self.places: list[int] = []
        self.texts: list[str] = []

    def add(self, node: Node, text: str, factor: N | int = 1) -> int:
        """The number of a new output, factor times a formula."""
        place = self.maker.place(node, self.rows.sides)
        return self.add_place(place if factor == 1 else self.maker.scaled(factor, place), text, node)

    def add_place(self, place: int, text: str, node: Node | None = None) -> int:
        """The number of a new output, the result at a place; node: its formula, if it has slopes."""
        if node is not None:
            self.rows.nodes[len(self.places)] = node
        self.places.append(place)
        self.texts.append(text)
        return len(self.places) - 1


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

    switches : all of them; owners : name of the part that has each
    """

    def __init__(self, scene: Scene[N], kit: Kit[N], columns: Mapping[int, int]) -> None:
        self.scene, self.kit, self.columns = scene, kit, columns
        self.n, self.elastic = len(scene.bodies), scene.elastic_stops
        self.switches: list[Node] = []
        self.owners: list[str] = []
        self.same: dict[Node, tuple[int, int]] = {}  # by node: its switch, and -1 where it is turned round
        known: dict[Node, tuple[int, int]] = {}
        self._lock = RLock()  # one thread at a time writes operations
        self._forget_operations()
        roots = list(self._all_roots())
        nodes = hashed(node for node, _, _ in roots)
        self.all_roots = [Root(node, root[1], root[2]) for node, root in zip(nodes, roots, strict=True)]
        for root in self.all_roots:
            for node in root.node.switches:
                if node not in self.same:
                    watched, sign = watched_by(node)
                    if watched not in known:
                        known[watched] = len(self.switches), sign
                        self.switches.append(node)
                        self.owners.append(root.text)
                    number, first = known[watched]
                    self.same[node] = number, sign * first
        by_speed: list[Joined] = [*self.scene.frictions, *(stop for _, stop in self.scene.rigid_stops)]
        by_speed += [stop for _, stop in self.elastic if stop.c != 0 or stop.force is not None]
        by_speed += [link for link in self.scene.links if link.c != 0 or link.force is not None]
        on_base = any(BASE in (part.P, part.Q) for part in by_speed)
        moving = ("course", "base") if on_base else ("course",)
        of_courses = [
            node for root in self.all_roots if root.role[0] in moving for node in root.node.switches
        ]
        self.of_courses = {self.same[node][0] for node in of_courses}
        self._readings = list(self._all_readings())
        self._read = Kept[tuple[Any, ...], Read](MOST_SIDES)
        self._steps = Kept[tuple[Node, ...], Steps](MOST_MODES)
        self.awake_in = Kept[Status, set[int]](MOST_MODES)  # numbers of the switches that modes read
        self._sides = Kept[tuple[int | None, ...], dict[Node, int]](MOST_MODES)
        self._bending: dict[int, bool] = {}
        self._tapes = Kept[tuple[Any, ...], Tape](MOST_SIDES)
        self._guards = Kept[tuple[int, int], list[Guard]](MOST_SIDES)
        self.behind = {node: self.within(node[1]) for node in self.same}

    def _forget_operations(self) -> None:
        """Begin with no operations of tapes, nor with what is known of their results."""
        self.maker = TapeMaker(self.kit, self.columns)
        self.compared = DepthComparison(self.scene, self.columns, self.maker)

    def _all_roots(self) -> Iterator[tuple[Node, tuple[Any, ...], str]]:
        """Every formula of the scene, what for, and the name of its part."""
        if self.scene.base_formula is not None:
            yield (self.scene.base_formula, ("base",), "base")
        for i, force in enumerate(self.scene.forces):
            if force.formula is not None:
                yield (force.formula, ("force", i), force.name)
        for i, link in enumerate(self.scene.links):
            if link.force is not None:
                yield (link.force, ("link", i), link.name)
        for i, stop in self.elastic:
            if stop.force is not None:
                yield (stop.force, ("stop", i), stop.name)
        for k, friction in enumerate(self.scene.frictions):
            for sense, node in zip((1, -1), friction.slips or (), strict=False):
                yield (node, ("slip", k, sense), friction.name)
            for sense, node in zip((1, -1), friction.holds or (), strict=False):
                yield (node, ("hold", k, sense), friction.name)
            if friction.course is not None:
                yield (friction.course, ("course", k), friction.name)

    def roots(self, status: Status) -> list[Root]:
        """The formulas that a mode reads."""
        return self._read_in(status).roots

    def _read_in(self, status: Status) -> Read:
        known = self._read.get(status[:2])
        if known is None:
            roots = [
                root for root, of, i, in_states in self._readings if not of or status[of - 1][i] in in_states
            ]
            outer = tuple(dict.fromkeys(chain.from_iterable(root.node.outer for root in reversed(roots))))
            steps = self._steps.get(outer)
            if steps is None:
                steps = self._steps.keep(outer, Kept(MOST_SIDES))
            known = self._read.keep(status[:2], Read(roots, outer, steps))
        return known

    def _all_readings(self) -> Iterator[tuple[Root, int, int, tuple[int, ...]]]:
        """Each formula with the parts whose state tells whether a mode reads it, 1 for stops, 2 for frictions
        and 0 where all modes do; which of them; and in which of its states.
        """
        for root in self.all_roots:
            kind, i, *sense = *root.role, 0
            if kind in ("slip", "hold"):
                yield root, 2, i, (sense[0] if kind == "slip" else STICK,)
            else:
                yield root, int(kind == "stop"), i, (CONTACT, LIFTED)

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

    @cached_property
    def event_columns(self) -> tuple[str, ...]:
        """Names of the columns of events that tell the side of each switch: side.PART.NUMBER."""
        numbers = (self.owners[: i + 1].count(owner) for i, owner in enumerate(self.owners))
        return tuple(f"{SIDE}{owner}.{number}" for owner, number in zip(self.owners, numbers, strict=True))

    def has_side(self, i: int, side: int) -> bool:
        """Whether switch `i` has such a side: a choice has two, a table one more than knots, mod all."""
        node = self.switches[i]
        if node[0] == "table":
            return -1 <= side < len(node[2])
        return node[0] == "mod" or abs(side) == 1

    def awake(self, status: Status, sides: Mapping[Node, int]) -> Iterator[tuple[Node, int, int]]:
        """The switches that a mode reads, as nodes with what `same` says of them, those first that others
        stand behind; `sides` may come to hold each before the next is asked for. What follows on the sides of
        those before it is found once.
        """
        _, outer, steps = self._read_in(status)
        key: tuple[int | None, ...] = ()
        found: Iterator[Node] | None = None
        for count in itertools.count():
            known = steps.get(key)
            if known is None:
                found = found or islice(self._found_awake(outer, sides), count, None)
                node = next(found, UNKNOWN)
                known = steps.keep(key, (node, *self.same.get(node, (0, 0))))
            if known[0] is UNKNOWN:
                return
            yield known
            key = (*key, sides.get(known[0]))

    def _found_awake(self, outer: Sequence[Node], sides: Mapping[Node, int]) -> Iterator[Node]:
        """The same, by going through the formulas."""
        ahead = [*reversed(outer)]
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
            below: tuple[Any, ...] = children(node)
            for one in (node[1], chosen(node, sides)) if node[0] == "choose" else below:
                ahead += reversed(one.outer)

    def watched(self, rows: ModeRows[N]) -> bool:
        """Whether the sides of a mode are those of the switches that its formulas read, no more and no less,
        and event functions tell where each of them ends.
        """
        awake = rows.awake
        if awake != {i for i, side in enumerate(rows.status.switches) if side is not None}:
            return False
        return all(
            ("switch", i, key) in rows.outputs for i in awake for key, _, _ in self.guards(i, rows.status)
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
            with self._lock:
                made = self.maker.tape([self.maker.place(node, sides) for node in nodes])
            tape = self._tapes.keep(key, made)
        return tape

    @cached_property
    def part_of(self) -> list[int]:
        """The part that has each switch, as events number parts."""
        names = event_parts(self.scene)
        return [names.index(owner) for owner in self.owners]

    def within(self, node: Node) -> tuple[Node, ...]:
        """The switches in a formula."""
        return self.maker.within(node)

    def write(self, rows: ModeRows[N], courses: Sequence[Mapping[Node, int]] = ()) -> list[Event[N]]:
        """Write the tape of a mode and its forces into its rows; the event functions of its switches, and of
        what must not become negative under a root.

        courses : of each column, the belts by formulas between it and the group that it is in, with signs
        """
        with self._lock:
            if len(self.maker.ops) > MOST_OPERATIONS:
                self._forget_operations()
            return self._write(rows, courses)

    def _write(self, rows: ModeRows[N], courses: Sequence[Mapping[Node, int]]) -> list[Event[N]]:
        status, maker, outputs = rows.status, self.maker, rows.outputs
        rows.sides = sides = self.sides(status)
        rows.columns = dict(self.columns)
        made = Outputs(maker, rows)
        for node, role, text in self.roots(status):
            if role[0] == "base":
                rows.base_tape = maker.tape([maker.place(node, sides)], [text])
                rows.base_values = motion_tape(self.kit, node, sides, text)
                outputs[role] = made.add(node, text)  # which no force reads: steps are checked by it
                continue
            if self._is_idle(role, rows) or (role[0] == "course" and status.frictions[role[1]] == STICK):
                continue
            outputs[role] = k = made.add(node, text)
            if role[0] in ("hold", "course"):
                continue
            P, Q, sign = self._ends(role, status)
            course = self.scene.frictions[role[1]].course if role[0] == "slip" else None
            if course is not None:
                outputs["power", role[1]] = made.add(mul(node, course), text)
            if sign:
                rows.formulas.append(FormulaForce(k, P, Q, sign))
        self._carry(rows, courses, made)
        roots = [*made.places]
        self._write_pushes(rows, made)
        rows.awake = self.awake_in.get(status) or {i for _, i, _ in self.awake(status, sides)}
        events: list[Event[N]] = []
        guards: list[tuple[int, int]] = []
        for i in sorted(rows.awake):
            for key, guard, sign in self.guards(i, status):
                place = maker.place(guard, sides)
                guards.append((place, sign))
                if self.compared.sign_by_stops(place, status) != sign:
                    outputs["switch", i, key] = k = made.add_place(place, self.owners[i], guard)
                    events.append(self._event(SWITCH, i, sign, (SWITCH, i, key), k))
        powers = [op for op in map(maker.ops.__getitem__, maker.needed(made.places)) if op.code == POWER]
        for place in dict.fromkeys(op.a for op in powers):
            if not (self.compared.kept(place, guards) or self.compared.sign_by_stops(place, status) > 0):
                needing = (k for k, root in enumerate(roots) if place in maker.needed([root]))
                outputs["base", place] = k = made.add_place(place, made.texts[next(needing, 0)])
                events.append(self._event(DOMAIN, k, 1, (DOMAIN, place), k))
        rows.tape = maker.tape(made.places, made.texts)
        return events

    def _carry(self, rows: ModeRows[N], courses: Sequence[Mapping[Node, int]], made: Outputs[N]) -> None:
        """Effects of belts by formulas on bodies that stick on them: the acceleration r of each beside that
        of its group, the force m r that this takes, and the torque u sin(phi) r on each rotor that it has.
        """
        for c, signs in enumerate(courses[: self.n]):
            if not signs:
                continue
            rate = ZERO
            for course, sign in signs.items():
                rate = add(rate, mul(num(sign), derivative(resolved(course, rows.sides), TIME)))
            names = {one.course: one.name for one in self.scene.frictions if one.course is not None}
            text = names[next(iter(signs))]
            rows.follow[c] = made.add(rate, text)
            inertia = made.add(rate, text, self.scene.bodies[c].m)
            rows.formulas.append(FormulaForce(inertia, c, -1, -1))
            for rotor in self.scene.rotors:
                if rotor.on == c and rotor.unbalance:
                    torque = made.add(mul(("sin", ("x", rotor.column)), rate), text, rotor.unbalance)
                    rows.factors[torque] = rotor.unbalance
                    rows.formulas.append(FormulaForce(torque, rotor.column, -1, 1))

    def _write_pushes(self, rows: ModeRows[N], made: Outputs[N]) -> None:
        """For stops that let go at zero force: what is left of it without powers of the depth, which
        tells its sign up to depth 0 and goes through the zeros that it has.
        """
        for i, stop in self.elastic:
            if stop.force is not None and stop.lets_go and rows.status.stops[i] != OPEN:
                rest = self.compared.rest(i, stop, stop.force, rows.sides)
                value = value_of(rest)
                if value is not None and value > 0:
                    rows.outputs["push", i] = NO_ZERO
                elif value is None and rest != stop.force:
                    rows.outputs["push", i] = made.add(rest, stop.name)

    def _is_idle(self, role: tuple[Any, ...], rows: ModeRows[N]) -> bool:
        """Whether a formula is the force of a stop that has let go, and what is left of it without powers of
        the depth is read in its place: next to the depth 0 those powers would ask for steps of no length.
        """
        if role[0] != "stop" or rows.status.stops[role[1]] != LIFTED:
            return False
        stop = self.scene.stops[role[1]]
        assert isinstance(stop, Stop) and stop.force is not None
        rest = self.compared.rest(role[1], stop, stop.force, rows.sides)
        value = value_of(rest)
        return rest != stop.force if value is None else value > 0

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

    def guards(self, i: int, status: Status) -> list[Guard]:
        """Event functions of switch `i` on the side that it has in a mode, none where it has none."""
        side = status.switches[i] if status.switches else None
        if side is None:
            return []
        return self._guards.get((i, side)) or self._guards.keep((i, side), [*_guards(self.switches[i], side)])

    def side_by_stops(self, node: Node, status: Status) -> int:
        """On which side an elastic stop keeps a switch that watches its depth: the upper one, 1, in contact
        and the lower one, -1, where it is open; 0 where none does.
        """
        if not self.elastic or node[0] != "choose" or self.behind[node]:
            return 0
        with self._lock:
            return self.compared.sign_by_stops(self.maker.place(node[1], {}), status)

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


def _guards(node: Node, side: int) -> Iterator[Guard]:
    """Event functions of a switch on one of its sides."""
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
