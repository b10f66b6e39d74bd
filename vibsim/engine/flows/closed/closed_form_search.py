"""Certified first event on the closed-form flow: safe steps from bounds of the event functions' curvature."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, Generic

from vibsim.engine.events.event_functions import EventFunctions, reaches
from vibsim.engine.events.records import crosses, latest_zero, may_vanish_by
from vibsim.engine.events.root_finding import (
    deflated_step,
    extreme_of_slope,
    leading_order,
    safe_step,
    turning_point,
)
from vibsim.engine.flows.closed.rounding import Scales, close_scales, plain_scales
from vibsim.engine.flows.motion import Advance
from vibsim.engine.modes.rows import STRIKE, Event, EventKey, Known
from vibsim.physics.numbers import N, abs

if TYPE_CHECKING:
    from vibsim.engine.flows.closed.closed_form import ClosedForm

JET_ORDER = 9  # derivatives taken at the start of a segment: enough for a zero of order FLAT_ORDER - 1
FLAT_ORDER = JET_ORDER - 3
STEPS_PER_CALL = 4096
POLISHING = 10  # Halley's iteration triples the right digits
NEAR = 128  # roundings: nearer to zero than that they are measured closely
NARROWER = 16  # steps shorter than this part of the reach of the bounds shorten it to that; others widen it


class ClosedFormSearch(Generic[N]):
    """Marches a `ClosedForm` flow from event to event, and watches how close the gap functions come."""

    def __init__(self, flow: ClosedForm[N]) -> None:
        self.flow, self.kit = flow, flow.kit
        self.functions_of = EventFunctions(flow)
        self.certificate = flow.certificate
        self.settled = flow.kit.power_of_two(flow.kit.exponent(flow.kit.eps) / 3)  # next error: this cubed
        self.steps = 0

    def open(self, events: list[Event[N]], known: Known) -> None:
        """Start at the flow's anchor; known: {event key: order of its zero here}."""
        self.events, self.known, self.leading = events, known, True
        self.more = max((reaches(event) for event in events), default=0)
        self.t0 = self.t = self.flow.t0
        self.reach = self.window = self.flow.modal.window
        self.watched = {event.key: (self.t0,) + (self.kit.number(0),) * 4 for event in events if event.turns}
        self.stall = self.kit.number(1)
        self.residues: dict[
            EventKey, N
        ] = {}  # what is left of a known zero by the rounding of the segment before
        self.close: Scales[N] | None = None  # at the point evaluated last, where anything asked for it

    def advance(self, limit: N) -> Advance[N]:
        """March to the first event or to `limit`; returns (time, event or None)."""
        if self.leading:
            first = self._lead()
            if first is not None:
                return self.t, first
        if not self.events:
            self.t = limit
        for _ in range(STEPS_PER_CALL):
            first = self._step() if self.t < limit else None
            if self.t >= limit and (first is None or self.t > limit):  # at the end, or polished past it
                self.t = limit
                self._turn_before(None)
                return limit, None
            if first is not None:
                self._turn_before(first)
                return self.t, first
        return self.t, None

    def _lead(self) -> Event[N] | None:
        """The first stretch of a segment, known zeros divided out, from the derivatives at its start."""
        self.leading = False
        plain = plain_scales(self.flow)
        step, of = self.window, self.functions_of
        of.here(JET_ORDER + (1 if self.more > 1 else 0))
        self._set_reaches()
        for event in self.events:
            known = self.known.get(event.key, 0)
            derivatives = [of.derivative(event, n) for n in range(JET_ORDER - 2)]
            order = leading_order(derivatives, known)
            self.residues[event.key] = abs(derivatives[0]) if known > 0 else self.kit.number(0)
            if order >= FLAT_ORDER:  # it rests, surely where that are more zeros than the motion has modes
                if self.flow.dimension(self.flow.rows) > FLAT_ORDER:
                    self.certificate.doubt(self.t0)
                self.events = [other for other in self.events if other is not event]
                continue
            lead, bound = derivatives[order], of.bound(event, order + 2, self.window)
            if event.kind == STRIKE and order > known and lead < 0:  # closes from exactly zero
                return event
            if known == 0 < order and lead < 0:  # zero, by no event, and on its way below
                self.certificate.doubt(self.t0)
                return event
            if order == 0:
                noise = self._noise(event, lead, plain)
                if lead <= noise and derivatives[1] <= 0:
                    self._certify_crossing(lead, derivatives[1], bound, noise)
                    others = [other for other in self.events if self.known.get(other.key, 0) == 0]
                    self._certify_order(event, others, lead, derivatives[1], noise)
                    return event
                lead = lead - noise
                if lead <= 0:  # rises from within rounding of zero: on which side it began is not proved
                    self.certificate.doubt(self.t0)
            lead = lead if lead > 0 else self.kit.number(0)
            ahead = deflated_step(self.kit, order, lead, derivatives[order + 1], bound)
            step = ahead if ahead < step else step
            if event.turns:
                limit, zero = of.bound(event, 2, self.window), self.kit.number(0)
                parted = order if order >= 2 else 0  # as rest ends: what rounding left of zeros is no turn
                value, slope, curvature = (zero if n < parted else derivatives[n] for n in range(3))
                self.watched[event.key] = (self.t0, value, slope, curvature, limit)
        self._adapt_reach(step)
        self._move(step)
        return None

    def _set_reaches(self) -> None:
        X = V = self.kit.number(0)
        for place, speed in zip(self.flow.x0, self.flow.v0, strict=True):
            X, V = X + abs(place), V + abs(speed)
        reaches = [(event.key, self.flow.modal.reaches[event.key]) for event in self.events]
        self.cancelling = {key: reach.place * X + reach.speed * V + reach.rest for key, reach in reaches}

    def _here(self) -> None:
        self.functions_of.here(3 + max(self.more, 1))

    def _step(self) -> Event[N] | None:
        """One certified step; returns the event whose function reached zero here, or None."""
        self.steps += 1
        self.flow.evaluate(self.t - self.t0)
        of, step, plain = self.functions_of, self.reach, plain_scales(self.flow)
        self.close = None
        rival, nearest, alone = step, None, False
        held, free = False, step
        self._here()
        for event in self.events:
            value, slope = of.derivative(event, 0), of.derivative(event, 1)
            noise = self._noise(event, value, plain) + self.residues[event.key]
            bound = of.bound(event, 2, self.reach)
            if value < -noise or (value <= noise and slope <= 0):
                if self.t == self.t0 and self.known.get(event.key, 0) > 0:  # the zero of before
                    continue
                self._certify_crossing(value, slope, bound, noise)
                self._certify_order(event, self.events, value, slope, noise)
                return event
            if event.turns:
                self._watch_turn(event, value, slope, of.derivative(event, 2), bound)
            room = value - noise
            ahead = safe_step(self.kit, room if room > 0 else self.kit.number(0), slope, bound)
            if room <= 0:
                held = True
            elif ahead < free:
                free = ahead
            if ahead < step:
                step, rival, nearest = ahead, step, (event if slope < 0 else None)
                near = -2 * value / slope if slope < 0 else step
                alone = slope < 0 and 4 * near * bound < -slope
                course = value, slope, bound
            elif ahead < rival:
                rival = ahead
        if nearest is not None and alone and near <= rival:
            self._polish(nearest)
            return nearest
        if held:
            step = self._leap(step, free)
        self._adapt_reach(step)
        before = self.t
        self._move(step)
        if self.t > before:
            self.stall = self.stall if held else self.kit.number(1)
            return None
        if nearest is None:
            self._creep(before)
        else:
            value, slope, bound = course
            noise = self._close_noise(nearest) + self.residues[nearest.key]
            self._certify_crossing(value, slope, bound, noise)
            self._certify_order(nearest, self.events, value, slope, noise)
        return nearest

    def _noise(self, event: Event[N], value: N, plain: Scales[N]) -> N:
        """Rounding bound of the value of an event function, by the plain measure where it is far from zero.

        There a step that keeps the value above the plain bound can bring it below the close one at its very
        end only, and only where it still falls there: so the next step sees it.
        """
        of = self.functions_of
        noise = of.unit * of.scale(event, plain)
        near = value <= NEAR * (noise + of.unit * self.cancelling[event.key])
        return self._close_noise(event) if near else noise

    def _close_noise(self, event: Event[N]) -> N:
        """Rounding bound of an event function by the close measure."""
        if self.close is None:
            self.close = close_scales(self.flow)
        return self.functions_of.unit * self.functions_of.scale(event, self.close)

    def _leap(self, step: N, free: N) -> N:
        """Length of a step while a function rises within its rounding of zero: one that leaves zero as slowly
        as t^4 does so for long, and certified steps grow too little. So each is at least twice the one
        before, as far as the others allow, `free`.
        """
        unit = self.kit.next_after(self.t, inf) - self.t
        least, self.stall = unit * self.stall, self.stall * 2
        least = least if least < free else free
        if step >= least:
            return step
        self.certificate.doubt(self.t0)
        return least

    def _creep(self, before: N) -> None:
        """Leave a point where the certified step is shorter than the time grid's."""
        self.certificate.doubt(self.t0)
        self.t = before + (self.kit.next_after(before, inf) - before) * self.stall
        self.stall = self.stall * 2
        if self.reach == 0:  # a step near t = 0 was too short to be a number: bounds have to reach further
            self.reach = self.window

    def _adapt_reach(self, step: N) -> None:
        """Let the bounds of the next step reach as far as it needs: they are the tighter the less they do."""
        needed = NARROWER * step
        self.reach = needed if needed < self.window else self.window

    def _certify_crossing(self, value: N, slope: N, bound: N, noise: N) -> None:
        """Doubt that a function taken for zero at `value` falls below zero: it may be higher by `noise`."""
        if not crosses(slope, bound, noise + value if value > 0 else noise):
            self.certificate.doubt(self.t0)

    def _certify_order(self, first: Event[N], events: list[Event[N]], value: N, slope: N, noise: N) -> None:
        """Doubt that the zero of `first` is the first, where that of another of `events` may come as soon;
        value, slope and noise are those of `first`. Two names of one function vanish together.
        """
        if slope >= 0:  # a touch is in doubt by itself
            return
        of, latest = self.functions_of, latest_zero(self.kit, value, slope, noise, self.t)
        for event in events:
            other, fall = of.derivative(event, 0), of.derivative(event, 1)
            blur = self._close_noise(event) + self.residues.get(event.key, self.kit.number(0))
            same = event is first or (other == value and fall == slope)
            if not same and may_vanish_by(other, fall, blur, latest):
                self.certificate.doubt(self.t0)

    def _polish(self, event: Event[N]) -> None:
        """Go to the one zero of the event function ahead, by Halley's iteration.

        Called where 8 f |f''| < f'^2 and f' < 0: then f falls all the way to its zero, which lies within
        -2 f / f' and is the only one there (Kantorovich), and no other event function can vanish within that.
        """
        start, of = self.t, self.functions_of
        for _ in range(POLISHING):
            self._here()
            value, slope = of.derivative(event, 0), of.derivative(event, 1)
            curvature, before = of.derivative(event, 2), self.t
            newton = value / slope
            step = -(2 * newton) / (2 - newton * (curvature / slope))
            self._move(step)
            self.t = self.t if self.t > start else start
            near = self.window if abs(curvature) * self.window < abs(slope) else abs(slope / curvature)
            if self.t == before or abs(step) < self.settled * near:
                return
            self.steps += 1
            self.flow.evaluate(self.t - self.t0)

    def _move(self, step: N) -> None:
        """Go ahead by `step` on the time grid."""
        self.t = self.kit.exact(self.t0 + ((self.t - self.t0) + step))

    def _watch_turn(self, event: Event[N], value: N, slope: N, curvature: N, bound: N) -> None:
        """Look for a minimum of a gap function since the point watched before; then watch from here on.

        bound: on its second derivative ahead. A minimum that cannot undercut the grazing margin is not looked
        for. Between slopes of one sign there may be a maximum beside the minimum: then the slope itself has
        an extreme between, which the curvatures tell.
        """
        low, was, before, bend, limit = self.watched[event.key]
        self.watched[event.key] = (self.t, value, slope, curvature, bound)
        length = self.t - low
        least = was + before * length - limit * (length * length) / 2
        if (least if least < was else was) >= self.certificate.margin:
            return
        if before < 0 <= slope:
            self._turn_between(event, low, self.t)
        elif (before < 0) == (slope < 0) and (bend < 0 < curvature or (before < 0 and curvature < 0 < bend)):
            middle = low + extreme_of_slope(self.kit, length, before, bend, slope, curvature)
            between, _ = self._gap_slope(event, middle)
            if before >= 0 > between:
                self._turn_between(event, middle, self.t)
            elif before < 0 <= between:
                self._turn_between(event, low, middle)
        self.flow.evaluate(self.t - self.t0)
        self._here()

    def _turn_between(self, event: Event[N], low: N, high: N) -> None:
        def slope_at(t: N) -> tuple[N, N]:
            return self._gap_slope(event, t)

        t, turn, depth = turning_point(slope_at, low, high, self.settled * self.window)
        self.flow.evaluate(t - self.t0)
        self.functions_of.here(2)
        value = self.functions_of.derivative(event, 0)
        self.certificate.keep_turn(value - depth, turn)

    def _gap_slope(self, event: Event[N], t: N) -> tuple[N, N]:
        """Slope and curvature of a gap function at time t."""
        self.flow.evaluate(t - self.t0)
        self._here()
        return self.functions_of.derivative(event, 1), self.functions_of.derivative(event, 2)

    def _turn_before(self, first: Event[N] | None) -> None:
        """Look for minima of the gap functions between the points watched last and an event of another kind,
        or the end of the run.
        """
        for event in self.flow.rows.events:
            if event.turns and event is not first:
                self.flow.evaluate(self.t - self.t0)
                self._here()
                value, slope, curvature = (self.functions_of.derivative(event, n) for n in range(3))
                self._watch_turn(event, value, slope, curvature, self.kit.number(0))
