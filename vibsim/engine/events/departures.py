"""How event functions leave their zeros: signs of derivatives, with what rounding leaves open of them.

Derivatives are those of the Taylor recurrences in every mode: what is zero by the laws of motion, as the
acceleration of a body whose springs are slack, is exactly zero there. Modal coordinates leave rounding.

Elastic stops and clearances that tied ends just touch rest at zero while the tie holds. Behind the release
they have a zero of order 3, as the motion itself, or of order 2 where a force jumps there.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Generic

from vibsim.engine.doubts import CROSSES, LEAVES, SIGN, name_of_event
from vibsim.engine.errors import State, Stopped
from vibsim.engine.events.records import Happened
from vibsim.engine.events.relative_motion import RelativeMotion
from vibsim.engine.events.switches import SwitchSides
from vibsim.engine.flows.base_motion import NO_SIDES
from vibsim.engine.flows.expansion import Expansion, highest_derivative
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import (
    CLEARANCE,
    COUPLING,
    DIFFERENCE,
    FORMULA,
    GAP,
    PUSH,
    STRIKE,
    Event,
    EventKey,
    Known,
    ModeRows,
    Term,
)
from vibsim.engine.modes.status import CONTACT, KEPT, OPEN, VIOLATED, Status
from vibsim.physics.formulas import Node
from vibsim.physics.numbers import N, abs, total_of
from vibsim.physics.parts import Clearance, Stop

FEW = 2  # derivatives behind the first that is asked for: most often enough
# of what a rate changes by within a step: rounding may have left so little; rules.c asks for 256 times that
GRAZING = 2.0**-28
TIMES = 8  # units of the time, within which an event was found where its function is zero


class DerivativeSigns(Generic[N]):
    """Decides on which side of zero event functions are just behind an instant."""

    def __init__(
        self,
        relative: RelativeMotion[N],
        maker: RowMaker[N],
        expansion: Expansion[N],
        doubt: Callable[[N, str, Iterable[str]], None],
    ) -> None:
        self.relative, self.maker, self.expansion, self.kit = relative, maker, expansion, expansion.kit
        self._doubt = doubt
        self.jet = highest_derivative(maker.scene)
        formulas = maker.formulas
        self.switches = SwitchSides(maker.scene, maker, relative, self.kit) if formulas else None
        self.stopped = threading.Event()  # set from any thread: what is decided then is left undecided

    def doubt(self, state: State[N], reason: str, names: Iterable[str]) -> None:
        """Count a decision that rounding could turn; reason, names of events: as of a `Doubt`."""
        self._doubt(state.t, reason, names)

    def doubt_event(self, state: State[N], status: Status, event: Event[N], reason: str) -> None:
        """As `doubt`, of an event function of the mode `status`."""
        rows = self.maker.rows(self.with_sides(state, status))
        self.doubt(state, reason, [name_of_event(self.maker, rows, event)])

    def enter(self, state: State[N], status: Status) -> ModeRows[N]:
        """The rows of a mode, whose derivatives at a state are asked for next. Raises Stopped."""
        if self.stopped.is_set():
            raise Stopped
        rows = self.maker.rows(self.with_sides(state, status))
        self.expansion.look(state, rows)
        return rows

    def with_sides(self, state: State[N], status: Status) -> Status:
        """The status with a side of each switch that its formulas read, where it has none yet."""
        return status if self.switches is None else self.switches.with_sides(state, status)

    def sides(self, status: Status) -> Mapping[Node, int]:
        """The sides of the switches of formulas that a mode says."""
        return NO_SIDES if self.switches is None else self.switches.rows.sides(status)

    def event(self, rows: ModeRows[N], key: EventKey) -> Event[N]:
        return next(event for event in rows.events if event.key == key)

    def watches(self, state: State[N], status: Status, key: EventKey) -> bool:
        """Whether a mode has an event function; none of a switch that a stop holds on its side."""
        rows = self.maker.rows(self.with_sides(state, status))
        return any(event.key == key for event in rows.events)

    def departure(self, state: State[N], status: Status, key: EventKey, first: int = 1) -> tuple[int, int]:
        """(sign, order) of the first derivative, from order `first`, that is not zero, of a function that
        begins at zero: in doubt where rounding could have it leave to the other side, or later than it does.
        The sign is 0 where all are zero. The derivative of order 1 is one of velocities where differences
        alone make the function, and no rounding of a flow is in it.
        """
        event, values = self._behind(state, status, key, first)
        order = leading(values, first)
        if self.is_open(state, event, values, first):
            self.doubt_event(state, status, event, LEAVES)
        return sign(values[order]), order

    def order(self, state: State[N], status: Status, key: EventKey, first: int = 1) -> int:
        """As of `departure`, of a mode that only may come: without doubt."""
        return leading(self._behind(state, status, key, first)[1], first)

    def entered(self, state: State[N], status: Status, key: EventKey) -> Event[N]:
        """An event function of a mode, whose derivatives at a state are asked for next."""
        return self.event(self.enter(state, status), key)

    def _behind(self, state: State[N], status: Status, key: EventKey, first: int) -> tuple[Event[N], list[N]]:
        """An event function and its derivatives at a state in a mode, see `as_far_as_needed`."""
        event = self.entered(state, status, key)
        direct = {1: self._direct_rate(state, event)} if event.is_made_of(DIFFERENCE) else {}
        return event, self.as_far_as_needed(event, first, direct)

    def is_open(self, state: State[N], event: Event[N], values: Sequence[N], first: int) -> bool:
        """Whether rounding leaves the first of the derivatives `values`, from order `first`, that is not zero
        open, or one before it.
        """
        bounds = self._bounds_of(state, event, leading(values, first))
        return any(
            0 < lost >= abs(value) for value, lost in zip(values[first:], bounds[first:], strict=False)
        )

    def clear_sign(self, state: State[N], event: Event[N], values: Sequence[N], first: int) -> int:
        """Sign of the first of the derivatives `values`, from order `first`, that is not rounding alone, of
        the state or of the time; 0 where all are.
        """
        order = self._first_clear(state, event, values, first)
        return 0 if order is None else sign(values[order])

    def clear_order(self, state: State[N], status: Status, key: EventKey) -> int:
        """Order of the zero with which an event function of a mode that is taken to rise begins: derivatives
        that are rounding alone are none. 1 where those beyond it do not tell that it rises.
        """
        event, values = self._behind(state, status, key, 1)
        order = self._first_clear(state, event, values, 1)
        return order if order is not None and values[order] > 0 else 1

    def _first_clear(self, state: State[N], event: Event[N], values: Sequence[N], first: int) -> int | None:
        """Order of the derivative of `clear_sign`; None where there is none."""
        bounds = self._bounds_of(state, event, len(values) - 1)
        late = TIMES * self.kit.eps * abs(state.t)
        changes = [late * abs(value) for value in (*values[1:], 0 * late)]
        orders = range(first, len(values))
        return next((n for n in orders if abs(values[n]) > bounds[n] + changes[n]), None)

    def _bounds_of(self, state: State[N], event: Event[N], highest: int) -> list[N]:
        """Bounds of the rounding of derivatives up to an order. That of order 1 of displacements is one of
        velocities.
        """
        bounds = self.expansion.bounds(event, highest, state.t == 0)
        if highest > 0 and event.is_made_of(DIFFERENCE):
            bounds[1] = self.kit.number(0)
            for term in event.terms:
                bounds[1] = (
                    bounds[1]
                    + abs(term.coefficient) * self.relative.base_rounding((term.P, term.Q), state)[1]
                )
        return bounds

    def as_far_as_needed(self, event: Event[N], first: int, direct: Mapping[int, N]) -> list[N]:
        """Derivatives of an event function of the mode entered last: at least up to the first, from order
        `first`, that is not zero; all that a run's own series have where there is none.

        direct : derivatives that are known better, by order
        """
        values: list[N] = []
        for highest in (min(first + FEW, self.jet), self.jet, self.expansion.furthest):
            values = self.expansion.derivatives(event, highest)
            for order, value in direct.items():
                values[order] = value
            if any(values[first:]):
                break
        return values

    def crossing(self, state: State[N], status: Status, key: EventKey, order: int) -> tuple[int, int]:
        """(+1 where the event function goes on falling through its zero, -1 where it turns back; order of the
        zero).

        order : of a zero here from which it was taken to rise, and fell back within the grid of time: its
            derivatives up to that order are rounding; of a rigid stop all but its rate

        Where the function stood at zero, or just grazes it, and what sets it into motion meets it with the
        rounding of where it came from, the first derivative beyond that decides, in doubt; where there is
        none it stands on, and is no more than its rounding as far as a series reaches.
        """
        rows = self.maker.rows(self.with_sides(state, status))
        event = self.event(rows, key)
        if event.is_made_of(DIFFERENCE) and (order == 0 or event.kind == STRIKE):
            rate = self._direct_rate(state, event)
            if rate != 0:
                return -sign(rate), 1
        self.expansion.look(state, rows)
        for highest in (self.jet, self.expansion.furthest):
            values = self.expansion.derivatives(event, highest)
            first = leading(values, order + 1)
            if first == 1 and abs(values[1]) > GRAZING * self._span(state) * abs(values[2]):
                return -sign(values[first]), first
            bounds = self.bounds(state, event, highest)
            if 0 < bounds[first] >= abs(values[first]):
                self.doubt_event(state, status, event, CROSSES)
                plain = (n for n in range(first, highest) if abs(values[n]) > bounds[n])
                first = next(plain, 0)
            if first and values[first] != 0:
                return -sign(values[first]), first
        self.doubt_event(state, status, event, CROSSES)
        return 0, self.kit.order(self.maker.scene) + 2  # coefficients of a displacement

    def bounds(self, state: State[N], event: Event[N], highest: int) -> list[N]:
        """Bounds of the rounding of the derivatives of an event function of the mode entered last: of what
        the state is made of, and of what the motion led through within a step before it, or since t = 0.
        """
        return self.expansion.bounds(event, highest, state.t == 0, self._span(state))

    def _span(self, state: State[N]) -> N:
        """A step of the mode entered last, as far as there is motion before `state` [s]."""
        step = self.expansion.step
        return step if step < state.t else state.t

    def _direct_rate(self, state: State[N], event: Event[N]) -> N:
        """Rate of a function made of differences, from the velocities: no rounding of a flow in it."""
        v = self.relative.columns_of(state, "v")
        return total_of(self.kit, (term.coefficient * (v[term.P] - v[term.Q]) for term in event.terms))

    def passes_now(self, state: State[N], event: Event[N], values: Sequence[N]) -> bool:
        """Whether an event function of the mode entered last that a formula is part of passes zero within the
        resolution of time, and by more than rounding: values are its derivatives here, from order 0.
        """
        if all(term.kind != FORMULA for term in event.terms):
            return False
        rate = abs(values[1])
        resolution = TIMES * self.kit.eps * abs(state.t)
        return bool(abs(values[0]) <= rate * resolution and rate > self.expansion.bounds(event, 1, False)[1])

    def hold_values(self, state: State[N], rows: ModeRows[N], event: Event[N]) -> list[N]:
        """Derivatives of a HOLD function, see `as_far_as_needed`; its value straight from the state where
        couplings alone make it.
        """
        direct = {0: self._direct_hold(state, rows, event)} if event.is_made_of(COUPLING) else {}
        return self.as_far_as_needed(event, 0, direct)

    def pulls(self, state: State[N], status: Status, stop: Stop[N], i: int) -> bool:
        """Whether elastic stop number `i`, in contact, would have to pull, where it lets go by force."""
        if not stop.lets_go:
            return False
        rows = self.enter(state, status)
        if rows.lets_go_with_depth(i):
            return False
        event = self.event(rows, (PUSH, i))
        values = self.expansion.derivatives(event, self.jet)
        if self.is_open(state, event, values, 0):
            self.doubt_event(state, status, event, SIGN)
        return values[0] < 0

    def _direct_hold(self, state: State[N], rows: ModeRows[N], event: Event[N]) -> N:
        x, v = (self.relative.columns_of(state, of) for of in ("x", "v"))

        def part(term: Term[N]) -> N:
            one = rows.couplings[term.P]
            force = one.k * (x[one.P] - x[one.Q]) + one.c * (v[one.P] - v[one.Q]) + one.offset
            return term.coefficient * force

        return total_of(self.kit, map(part, event.terms)) + event.constant


def leading(values: Sequence[N], first: int) -> int:
    """Order of the first derivative, from order `first`, that is not zero; the last where all are."""
    last = len(values) - 1
    return next((n for n in range(first, last) if values[n] != 0), last)


def sign(value: N) -> int:
    """-1, 0 or +1."""
    return 1 if value > 0 else -1 if value < 0 else 0


def first_sign(values: Iterable[N]) -> int:
    """Sign of the first value that is not zero; 0 where all are."""
    for value in values:
        if value != 0:
            return sign(value)
    return 0


# Elastic stops and clearances that tied ends just touch, and that part or close where the tie lets go.


class TouchingParts(Generic[N]):
    """Decides which of these part and which close."""

    def __init__(self, maker: RowMaker[N], departures: DerivativeSigns[N]) -> None:
        self.maker, self.departures = maker, departures

    def parted(
        self, state: State[N], status: Status, after: Status, order: int, known: Known
    ) -> tuple[Status, Happened]:
        """As `touching`, behind the release of ties, for the parts that the tied ends just touched."""
        parts = self.departures.relative.touched(state, *released_parts(self.maker, status, after))
        return self.touching(state, status, after, parts, order, known)

    def touching(
        self,
        state: State[N],
        status: Status,
        after: Status,
        parts: tuple[Sequence[int], Sequence[int]],
        order: int,
        known: Known,
    ) -> tuple[Status, Happened]:
        """The status `after` an event, with those of some elastic stops and clearances, `parts`, whose ends
        just touch as the motion takes them; what happened to them since `status`. Their functions have a zero
        of some order there, which goes into `known`.
        """
        happened: Happened = []
        after, _ = self.left(state, after, parts[0], order)
        for i in parts[0]:
            known |= zeros_of_touch(self.maker, after, i, order)
            if status.stops[i] != after.stops[i]:
                happened.append(("contact_begin" if after.stops[i] == CONTACT else "contact_end", i))
        for i in parts[1]:
            closes = (
                self.departures.departure(state, after.with_clearance(i, KEPT), (CLEARANCE, i), order)[0] < 0
            )
            after = after.with_clearance(i, VIOLATED if closes else KEPT)
            known[CLEARANCE, i] = order
            if status.clearances[i] != after.clearances[i]:
                happened.append(("violation_begin" if closes else "violation_end", i))
        return after, happened

    def left(
        self, state: State[N], status: Status, stops: Iterable[int], first: int = 1
    ) -> tuple[Status, dict[int, int]]:
        """The status with some elastic stops whose ends just touch as the motion leaves that, and the orders
        of their zeros, from `first`. Those that are left first are decided first: the force of a stop begins
        at zero, and makes others leave at higher orders only, as in a row of bodies of which one is pushed.
        """
        orders: dict[int, int] = {}
        waiting = list(stops)
        while waiting:
            soonest = waiting
            if len(waiting) > 1:
                when = {
                    i: self.departures.order(state, status.with_stop(i, OPEN), (GAP, i), first)
                    for i in waiting
                }
                least = min(when.values())
                soonest = [i for i in waiting if when[i] == least]
            for i in soonest:
                sense, orders[i] = self.departures.departure(
                    state, status.with_stop(i, OPEN), (GAP, i), first
                )
                status = status.with_stop(i, CONTACT if sense < 0 else OPEN)
            waiting = [i for i in waiting if i not in orders]
        return status, orders


def zeros_of_touch(maker: RowMaker[N], status: Status, i: int, order: int) -> Known:
    """Orders of the zeros of elastic stop number i where its ends just touch: of its depth, and one less of
    its force, but where a formula has the sign of that by what is left of it without the depth.
    """
    known: Known = {(GAP, i): order}
    if not maker.scene.has_formulas or ("push", i) not in maker.rows(status).outputs:
        known[PUSH, i] = order - 1
    return known


def released_parts(maker: RowMaker[N], before: Status, behind: Status) -> tuple[list[int], list[int]]:
    """The numbers of the elastic stops and of the clearances whose ends are at rest on each other in the mode
    `before` and no longer tied in the one `behind`; those that a belt moves against each other are not.
    """
    bodies, loose = maker.tied(before), maker.tied(behind).groups.leader
    tied, drift, courses = bodies.groups.leader, bodies.drift, bodies.courses

    def parts(one: Stop[N] | Clearance[N]) -> bool:
        P, Q = maker.ends(one)
        at_rest = tied[P] == tied[Q] and drift[P] == drift[Q] and courses[P] == courses[Q]
        return at_rest and loose[P] != loose[Q]

    stops = [i for i, stop in maker.scene.elastic_stops if i not in maker.guarded and parts(stop)]
    return stops, [i for i, one in enumerate(maker.scene.clearances) if parts(one)]
