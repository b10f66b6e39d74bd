"""Makes the rows of a mode (`vibsim.engine.modes.rows`) from a scene and what touches and sticks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Generic

from vibsim.engine.modes.formula_rows import FormulaRows
from vibsim.engine.modes.rows import (
    ACCELERATION,
    CLEARANCE,
    COUPLING,
    DIFFERENCE,
    FORMULA,
    GAP,
    HOLD,
    LOAD,
    PUSH,
    RATE,
    SLIDE,
    STRIKE,
    Acceleration,
    Coupling,
    Event,
    ForceTerms,
    Joined,
    ModeRows,
    RotorOn,
    Term,
    Terms,
)
from vibsim.engine.modes.status import CONTACT, LIFTED, OPEN, RESTING, STICK, Kept, Status
from vibsim.engine.modes.ties import Cut, Edge, Groups, Limits, Tie, cuts
from vibsim.physics.formulas import Node
from vibsim.physics.numbers import Kit, N, abs, total_of
from vibsim.physics.parts import BASE, EXTENSION, GROUND, Clearance, Friction, RigidStop, Scene, Stop

Courses = dict[Node, int]  # velocities of belts by formulas, how often each

MOST_EVENTS, MOST_MODES = 20_000, 5000  # event functions of the rows that are kept, some 30 MB; modes


def with_course(courses: Courses, tie: Friction[N] | RigidStop[N], sign: int) -> Courses:
    """`courses` and that of a tie, so often as `sign` says; without those that cancel."""
    course = tie.course if isinstance(tie, Friction) else None
    if course is None:
        return courses
    count = courses.get(course, 0) + sign
    return {one: times for one, times in (courses | {course: count}).items() if times}


@dataclass
class TiedColumns(Generic[N]):
    """The columns of a mode that its ties alone decide, as in `ModeRows`; stuck: these ties.

    courses : belts by formulas between each column and the leading one of its group, with their signs: what
        it has in velocity beside its drift
    resting : frictions whose ends the ties keep from sliding, once they are asked for
    """

    stuck: list[Tie]
    groups: Groups
    mass: list[N | None]
    mobility: list[N]
    drift: list[N]
    courses: list[Courses]
    resting: set[int] | None = None


class RowMaker(Generic[N]):
    """Makes the rows of the modes of a scene, each once."""

    def __init__(self, scene: Scene[N], kit: Kit[N]) -> None:
        self.scene, self.kit = scene, kit
        self.n = len(scene.bodies)
        self.columns = {end: scene.column(end) for end in (GROUND, BASE)}
        self.zero = kit.number(0)
        self.by_status = Kept[Status, ModeRows[N]](MOST_EVENTS)
        self._tied = Kept[tuple[int, ...], TiedColumns[N]](MOST_MODES)
        self._events_of_stops: dict[tuple[int, int], list[Event[N]]] = {}  # those that no mode changes
        self.guarded = self._guarded()
        self.formulas = FormulaRows(scene, kit, self.columns) if scene.has_formulas else None

    def _guarded(self) -> set[int]:
        """Elastic stops that are never pressed, as a rigid one between the same ends is met before them or
        with them.
        """

        def way(stop: Stop[N] | RigidStop[N]) -> tuple[int, int, int]:
            P, Q = self.ends(stop)
            return (P, Q, stop.sense) if P < Q else (Q, P, -stop.sense)

        rigid = [(way(stop), stop.gap) for _, stop in self.scene.rigid_stops]
        return {
            i
            for i, stop in self.scene.elastic_stops
            if any(along == way(stop) and gap <= stop.gap for along, gap in rigid)
        }

    def ends(self, part: Joined) -> Edge:
        """Columns of the ends of a part."""
        P, Q = part.P, part.Q
        return P if P >= 0 else self.columns[P], Q if Q >= 0 else self.columns[Q]

    def rows(self, status: Status) -> ModeRows[N]:
        """The rows of the mode `status`."""
        rows = self.by_status.get(status)
        if rows is None:
            made = self._make(status)
            rows = self.by_status.keep(status, made, 1 + len(made.events))
        return rows

    def is_watched(self, status: Status) -> bool:
        """Whether a mode has a side of each switch that its formulas read, and event functions that tell
        where it ends.
        """
        return self.formulas is None or self.formulas.watched(self.rows(status))

    def tie(self, k: int) -> Friction[N] | RigidStop[N]:
        """The part that is tie number k: a friction, or a rigid stop."""
        count = len(self.scene.frictions)
        if k < count:
            return self.scene.frictions[k]
        stop = self.scene.stops[k - count]
        assert isinstance(stop, RigidStop), "elastic stops do not come to rest"
        return stop

    def limits(self, k: int) -> Limits[N]:
        """Force that tie number k holds against P going forwards and backwards against Q [N]; None: any
        force.
        """
        part = self.tie(k)
        if isinstance(part, RigidStop):
            return (self.zero, None) if part.sense == EXTENSION else (None, self.zero)
        return part.limits

    def belt(self, k: int) -> N:
        """Velocity of P against Q where tie number k holds [m/s]."""
        part = self.tie(k)
        return self.zero if isinstance(part, RigidStop) else part.belt

    def tied(self, status: Status) -> TiedColumns[N]:
        """The columns that the ties of a mode alone decide."""
        tied = tuple(status.tied)
        bodies = self._tied.get(tied)
        if bodies is None:
            stuck: list[Tie] = [(k, *self.ends(self.tie(k))) for k in tied]
            groups = Groups(self.n, stuck)
            drift, courses = self._drifts(groups, stuck), self._courses(groups, stuck)
            bodies = TiedColumns(stuck, groups, *self._masses(groups), drift, courses)
            bodies = self._tied.keep(tied, bodies)
        return bodies

    def resting(self, status: Status) -> set[int]:
        """The frictions whose ends the ties of a mode keep from sliding. Speeds of belts are added along the
        ties, so those that differ by no more than the rounding of these sums are equal: 0.1 + 0.2 and 0.3.
        """
        bodies = self.tied(status)
        if bodies.resting is None:
            bodies.resting = self._resting(bodies)
        return bodies.resting

    def _resting(self, bodies: TiedColumns[N]) -> set[int]:
        leader, drift, courses = bodies.groups.leader, bodies.drift, bodies.courses
        belts = self.zero
        for k, _, _ in bodies.stuck:
            belts = belts + abs(self.belt(k))
        lost = (len(bodies.stuck) + 2) * self.kit.eps  # of each belt, and of each sum
        resting = set()
        for k, friction in enumerate(self.scene.frictions):
            P, Q = self.ends(friction)
            if leader[P] == leader[Q]:
                over = abs(drift[P] - drift[Q] - friction.belt)
                if over <= lost * (belts + abs(friction.belt)) and self._goes_along(courses, friction):
                    resting.add(k)
        return resting

    def _courses(self, groups: Groups, stuck: Sequence[Tie]) -> list[Courses]:
        courses: list[Courses] = [{} for _ in range(self.n + 2)]
        if self.scene.has_courses:
            for i, one, other, sign in self._walk(groups, stuck):
                courses[other] = with_course(courses[one], self.tie(i), sign)
        return courses

    def _goes_along(self, courses: Sequence[Courses], tie: Friction[N] | RigidStop[N]) -> bool:
        """Whether the ends of a tie have the difference of velocities of its belt, as far as that is a
        formula.
        """
        P, Q = self.ends(tie)
        return courses[P] == with_course(courses[Q], tie, 1)

    def can_last(self, status: Status) -> bool:
        """Whether the belts by formulas in the ties of a mode agree: two that do not may only stand for an
        instant.
        """
        if not self.scene.has_courses:
            return True
        courses = self.tied(status).courses
        return all(self._goes_along(courses, self.tie(k)) for k in status.tied)

    def _make(self, status: Status) -> ModeRows[N]:
        scene, tied = self.scene, self.tied(status)
        groups, parts = tied.groups, (self._couplings(status), self._constants(status))
        rows = ModeRows(status, groups, groups.leader, tied.mass, tied.mobility, *parts, drift=tied.drift)
        rows.rotors = [
            RotorOn(one.column, one.on, one.unbalance, scene.bodies[one.column].m) for one in scene.rotors
        ]
        switch_events = self.formulas.write(rows, tied.courses) if self.formulas else []
        rows.tied = [c for c in range(self.n) if len(groups.members[groups.leader[c]]) > 1]
        for i, stop in enumerate(scene.stops):
            state = status.stops[i]
            events = self._events_of_stops.get((i, state))
            if events is None:
                events = self._stop_events(rows, i, stop, state)
                if state == OPEN or isinstance(stop, RigidStop) or stop.force is None:
                    self._events_of_stops[i, state] = events
            rows.events += events
        self._friction_events(rows, tied.stuck)
        for i, clearance in enumerate(scene.clearances):
            rows.events.append(self._clearance_event(i, clearance, status.clearances[i]))
        rows.events += switch_events
        return rows

    def _masses(self, groups: Groups) -> tuple[list[N | None], list[N]]:
        """Mass and mobility by column."""
        mass: list[N | None] = [None] * (self.n + 2)
        mobility = [self.zero] * (self.n + 2)
        for c in range(self.n):
            if groups.leader[c] == c:
                total = total_of(self.kit, (self.scene.bodies[member].m for member in groups.members[c]))
                mass[c], mobility[c] = total, 1 / total
        return mass, mobility

    def _drifts(self, groups: Groups, stuck: Sequence[Tie]) -> list[N]:
        """Velocity of each column against its leader: belts between them."""
        drift = [self.zero] * (self.n + 2)
        if not any(friction.belt for friction in self.scene.frictions):
            return drift
        for i, one, other, sign in self._walk(groups, stuck):
            belt = self.belt(i)
            drift[other] = drift[one] + belt if sign > 0 else drift[one] - belt
        return drift

    @staticmethod
    def _walk(groups: Groups, stuck: Sequence[Tie]) -> Iterator[tuple[int, int, int, int]]:
        """The way from the leading columns to all others along ties: (number of the tie, column, the next
        one, 1 where that is P of the tie and -1 where it is Q).
        """
        reached = set(groups.members)
        ahead = list(reached)
        while ahead:
            c = ahead.pop()
            for i, P, Q in stuck:
                if c == Q and P not in reached:
                    yield i, Q, P, 1
                    reached.add(P)
                    ahead.append(P)
                elif c == P and Q not in reached:
                    yield i, P, Q, -1
                    reached.add(Q)
                    ahead.append(Q)

    def _couplings(self, status: Status) -> list[Coupling[N]]:
        merged: dict[Edge, Coupling[N]] = {}
        for link in self.scene.links:
            if link.force is None:
                self._couple(merged, self.ends(link), link.k, link.c, self.zero)
        for i, stop in self.scene.elastic_stops:
            if status.stops[i] == CONTACT and stop.force is None:
                self._couple(merged, self.ends(stop), stop.k, stop.c, stop.k * (stop.sense * stop.gap))
        return list(merged.values())

    @staticmethod
    def _couple(merged: dict[Edge, Coupling[N]], ends: Edge, k: N, c: N, offset: N) -> None:
        P, Q = ends
        if (Q, P) in merged:
            P, Q, offset = Q, P, -offset
        if (P, Q) not in merged:
            merged[P, Q] = Coupling(P, Q, k, c, offset)
        else:
            one = merged[P, Q]
            one.k, one.c, one.offset = one.k + k, one.c + c, one.offset + offset

    def _constants(self, status: Status) -> list[tuple[int, N]]:
        """Forces of slipping frictions by column [N]."""
        constants: dict[int, N] = {}
        for i, friction in enumerate(self.scene.frictions):
            if status.frictions[i] != STICK and friction.slips is None:
                force = -friction.forward if status.frictions[i] > 0 else friction.backward
                P, Q = self.ends(friction)
                for column, value in ((P, force), (Q, -force)):
                    if column < self.n:
                        constants[column] = value if column not in constants else constants[column] + value
        return sorted(constants.items())

    def _stop_events(
        self, rows: ModeRows[N], i: int, stop: Stop[N] | RigidStop[N], state: int
    ) -> list[Event[N]]:
        if isinstance(stop, RigidStop):
            if state == RESTING:
                return []
            apart: Terms[N] = (Term(DIFFERENCE, stop.sense, *self.ends(stop)),)
            return [Event(STRIKE, i, -1, (STRIKE, i), apart, stop.gap, abs(stop.gap), turns=True)]
        P, Q = self.ends(stop)
        s, gap, k, c = stop.sense, stop.gap, stop.k, stop.c

        def depth(sign: int, turns: bool = True) -> Event[N]:
            terms: Terms[N] = (Term(DIFFERENCE, -sign * s, P, Q),)
            return Event(GAP, i, sign, (GAP, i), terms, -sign * gap, abs(gap), turns=turns)

        def push(sign: int) -> Event[N]:
            if stop.force is not None:
                output = rows.outputs["push" if ("push", i) in rows.outputs else "stop", i]
                pushed: Terms[N] = (Term(FORMULA, sign, output),)
                return Event(PUSH, i, sign, (PUSH, i), pushed, self.zero, self.zero)
            terms: Terms[N] = (Term(DIFFERENCE, -sign * s * k, P, Q), Term(RATE, -sign * s * c, P, Q))
            constant = -sign * (k * gap)
            return Event(PUSH, i, sign, (PUSH, i), terms, constant, abs(constant))

        if state == OPEN:
            return [] if i in self.guarded else [depth(-1)]
        if state == LIFTED:
            return [push(-1), depth(1, turns=False)]
        if not stop.lets_go:
            return [depth(1)]
        if stop.force is None:
            return [push(1)]
        # a formula may come to zero with the depth, and not go through it; or with that alone
        return [depth(1)] if rows.lets_go_with_depth(i) else [push(1), depth(1)]

    def _friction_events(self, rows: ModeRows[N], stuck: Sequence[Tie]) -> None:
        """SLIDE of each slipping friction, HOLD of each cut through a group; in the order of the ties."""
        scene, status = self.scene, rows.status
        held: dict[int, list[Cut[N]]] = {}
        limits = {k: self.limits(k) for k, _, _ in stuck}
        for leader, members in rows.groups.members.items():
            ties = [tie for tie in stuck if rows.leader[tie[1]] == leader]
            if ties:
                for cut in cuts(members, ties, limits, self.reference(leader, members)):
                    first = min(i for i, _ in cut.ties)
                    held.setdefault(first, []).append(cut)
        for k in range(len(scene.frictions) + len(scene.stops)):
            if k < len(scene.frictions) and status.frictions[k] != STICK:
                rows.events.append(self._slide_event(rows, k, scene.frictions[k], status.frictions[k]))
            for cut in held.get(k, ()):
                rows.cuts.append(cut)
                rows.events += self._hold_events(rows, len(rows.cuts) - 1, cut)

    def reference(self, leader: int, members: Sequence[int]) -> int:
        """The column of a group that cuts leave on the other side: ground, base, else the motor's body."""
        if leader < self.n and self.scene.motor is not None and self.scene.motor.on in members:
            return self.scene.motor.on
        return leader

    def _slide_event(self, rows: ModeRows[N], i: int, friction: Friction[N], sign: int) -> Event[N]:
        P, Q = self.ends(friction)
        terms: Terms[N] = (Term(RATE, sign, P, Q),)
        if friction.course is None:
            ends = (rows.leader[P], sign), (rows.leader[Q], -sign)
            slope = tuple([self._acceleration(rows, *end) for end in ends if end[0] != self.n])
        else:
            terms, slope = (*terms, Term(FORMULA, -sign, rows.outputs["course", i])), ()
        constant = -(sign * friction.belt)
        return Event(SLIDE, i, sign, (SLIDE, i), terms, constant, abs(friction.belt), slope)

    def _acceleration(self, rows: ModeRows[N], leader: int, factor: int) -> Acceleration[N]:
        """factor times the acceleration of a group, or of the base."""
        if leader > self.n:
            return Acceleration(self.kit.number(1), factor, (Term(ACCELERATION, 1, leader),), ())
        if leader not in rows.forces:
            rows.forces[leader] = self._force_on(rows, rows.groups.members[leader])
        return Acceleration(rows.own_mass(leader), factor, *rows.forces[leader])

    def _force_on(self, rows: ModeRows[N], members: Iterable[int]) -> ForceTerms[N]:
        """Terms and constants of the force from outside on a set of columns."""
        inside = set(members)
        terms: list[Term[N]] = []
        for q, coupling in enumerate(rows.couplings):
            if (coupling.P in inside) != (coupling.Q in inside):
                terms.append(Term(COUPLING, 1 if coupling.Q in inside else -1, q))
        terms += [Term(LOAD, 1, c) for c in sorted(inside & self._loaded)]
        for one in rows.formulas:
            if (one.P in inside) != (one.Q in inside):
                terms.append(Term(FORMULA, one.sign if one.P in inside else -one.sign, one.output))
        return tuple(terms), tuple([value for column, value in rows.constants if column in inside])

    @cached_property
    def _loaded(self) -> set[int]:
        """Columns that forces, a motor or rotors act on."""
        loaded = {force.on for force in self.scene.forces if force.acts}
        loaded |= {one.on for one in self.scene.rotors}
        return loaded if self.scene.motor is None else loaded | {self.scene.motor.on}

    def _hold_events(self, rows: ModeRows[N], number: int, cut: Cut[N]) -> list[Event[N]]:
        """above - T and below + T of the force T = m a - F that the ties of a cut must pass to its
        columns, the one without where it is not limited.
        """
        terms, constants = self._unbalanced(rows, cut.columns)
        # slipping forwards (the columns of the cut overtake) comes first: there T = -below
        events: list[Event[N]] = []
        for direction, limit in ((1, cut.below), (-1, cut.above)):
            if limit is None:
                continue
            turned = tuple([Term(t.kind, -direction * t.coefficient, t.P, t.Q) for t in terms])
            if self.formulas:
                turned = (*self.formulas.limits(rows, cut, direction), *turned)
            constant = limit
            for value in constants:
                constant = constant - direction * value
            key = (HOLD, cut.columns, direction)
            events.append(Event(HOLD, number, direction, key, turned, constant, abs(constant)))
        return events

    def _unbalanced(self, rows: ModeRows[N], columns: Sequence[int]) -> ForceTerms[N]:
        """Terms and constants of F - m a, what the force from outside on a part of a group is too much for
        its motion.
        """
        terms, constants = self._force_on(rows, columns)
        leader = rows.leader[columns[0]]
        if leader != self.n:
            m = total_of(self.kit, (self.scene.bodies[c].m for c in columns))
            terms += (Term(ACCELERATION, -m, leader),)
        return terms, constants

    def tie_force(self, rows: ModeRows[N], columns: Sequence[int]) -> tuple[Terms[N], N]:
        """Terms and constant of the force m a - F that ties must pass to a part of a group."""
        terms, constants = self._unbalanced(rows, columns)
        constant = self.zero
        for value in constants:
            constant = constant - value
        return tuple(Term(t.kind, -t.coefficient, t.P, t.Q) for t in terms), constant

    def _clearance_event(self, i: int, clearance: Clearance[N], state: int) -> Event[N]:
        P, Q = self.ends(clearance)
        sign = 1 if state else -1
        terms: Terms[N] = (Term(DIFFERENCE, sign, P, Q),)
        distance = clearance.distance
        return Event(CLEARANCE, i, sign, (CLEARANCE, i), terms, -sign * distance, abs(distance))
