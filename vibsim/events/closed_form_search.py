"""Certified first event on the closed-form flow: safe steps from bounds of the event functions' curvature."""

from math import inf

from vibsim.events.certificate import Certificate, crosses, latest_zero, may_vanish_by
from vibsim.events.first_root import deflated_step, leading_order, safe_step
from vibsim.events.turning_point import extreme_of_slope, turning_point
from vibsim.events.watch import GAP, NOTHING
from vibsim.flows.event_functions import EventFunctions
from vibsim.flows.regime import JET_ORDER

STEPS_PER_CALL = 4096
POLISHING = 10  # Halley's iteration triples the right digits
NARROWER = 16  # steps shorter than this part of the reach of the bounds shorten it to that; others widen it


class ClosedFormSearch:
    """Marches a `ClosedForm` flow from event to event, and watches how close the gap function comes."""

    def __init__(self, flow):
        self.flow, self.kit, self.scene = flow, flow.kit, flow.scene
        self.functions_of = EventFunctions(flow)
        self.certificate = Certificate(flow.kit)
        self.settled = flow.kit.power_of_two(flow.kit.exponent(flow.kit.eps) / 3)  # next error: this cubed
        self.steps = 0

    def open(self, functions, known):
        """Start at the flow's anchor; known: {event function: order of its zero here}."""
        self.functions, self.known, self.leading = functions, known, True
        self.t0 = self.t = self.flow.t0
        self.reach = self.window = self.flow.regime.oscillator.window
        self.watched = (self.t0,) + (self.kit.number(0),) * 4
        self.stall = self.kit.number(1)
        self.residues = {}  # what is left of a known zero by the rounding of the segment before

    def advance(self, limit):
        """March to the first event or to `limit`; returns (time, event function or NOTHING)."""
        if self.leading:
            found = self._lead()
            if found != NOTHING:
                return self.t, found
        if not self.functions:
            self.t = limit
        for _ in range(STEPS_PER_CALL):
            found = self._step() if self.t < limit else NOTHING
            if self.t >= limit and (found == NOTHING or self.t > limit):  # at the end, or polished past it
                self.t = limit
                self._turn_before(NOTHING)
                return limit, NOTHING
            if found != NOTHING:
                self._turn_before(found)
                return self.t, found
        return self.t, NOTHING

    def _lead(self):
        """The first stretch of a segment, known zeros divided out, from the derivatives at its start."""
        self.leading = False
        self.flow.measure()
        step, of = self.window, self.functions_of
        d = self.flow.jet(JET_ORDER)
        for function in self.functions:
            known = self.known.get(function, 0)
            derivatives = [of.derivative(function, d, n) for n in range(JET_ORDER - 2)]
            order = leading_order(derivatives, known)
            self.residues[function] = abs(derivatives[0]) if known > 0 else self.kit.number(0)
            if order >= JET_ORDER - 3:  # more zeros than the motion has modes: it rests at zero
                self.functions = tuple(other for other in self.functions if other != function)
                continue
            lead, bound = derivatives[order], of.bound(function, d, order + 2, self.window)
            if order == 0:
                noise = of.noise(function)
                if lead <= noise and derivatives[1] <= 0:
                    self._certify_crossing(derivatives[1], bound, noise)
                    others = [other for other in self.functions if self.known.get(other, 0) == 0]
                    self._certify_order(function, others, d, lead, derivatives[1], noise)
                    return function
                lead = lead - noise
                if lead <= 0:  # rises from within rounding of zero: on which side it began is not proved
                    self.certificate.doubt(self.t0)
            lead = lead if lead > 0 else self.kit.number(0)
            ahead = deflated_step(self.kit, order, lead, derivatives[order + 1], bound)
            step = ahead if ahead < step else step
            if function == GAP:
                limit = of.bound(GAP, d, 2, self.window)
                self.watched = (self.t0, *derivatives[:3], limit)
        self._adapt_reach(step)
        self._move(step)
        return NOTHING

    def _step(self):
        """One certified step; returns the event function that reached zero here, or NOTHING."""
        self.steps += 1
        self.flow.evaluate(self.t - self.t0)
        self.flow.measure()
        of, step = self.functions_of, self.reach
        rival, nearest, alone = step, NOTHING, False
        d = self.flow.jet(4)
        for function in self.functions:
            value, slope = of.derivative(function, d, 0), of.derivative(function, d, 1)
            noise = of.noise(function) + self.residues[function]
            bound = of.bound(function, d, 2, self.reach)
            if value < -noise or (value <= noise and slope <= 0):
                self._certify_crossing(slope, bound, noise)
                self._certify_order(function, self.functions, d, value, slope, noise)
                return function
            if function == GAP:
                self._watch_turn(value, slope, of.derivative(GAP, d, 2), bound)
            room = value - noise
            ahead = safe_step(self.kit, room if room > 0 else self.kit.number(0), slope, bound)
            if ahead < step:
                step, rival, nearest = ahead, step, (function if slope < 0 else NOTHING)
                near = -2 * value / slope if slope < 0 else step
                alone = slope < 0 and 4 * near * bound < -slope
                course = value, slope, bound, noise
            elif ahead < rival:
                rival = ahead
        if alone and near <= rival:
            self._polish(nearest)
            return nearest
        self._adapt_reach(step)
        before = self.t
        self._move(step)
        if self.t > before:
            self.stall = self.kit.number(1)
            return NOTHING
        if nearest == NOTHING:
            self._creep(before)
        else:
            value, slope, bound, noise = course
            self._certify_crossing(slope, bound, noise)
            self._certify_order(nearest, self.functions, d, value, slope, noise)
        return nearest

    def _creep(self, before):
        """Leave a point where the certified step is shorter than the time grid's."""
        self.certificate.doubt(self.t0)
        self.t = before + (self.kit.next_after(before, inf) - before) * self.stall
        self.stall = self.stall * 2

    def _adapt_reach(self, step):
        """Let the bounds of the next step reach as far as it needs: they are the tighter the less they do."""
        wanted = NARROWER * step
        self.reach = wanted if wanted < self.window else self.window

    def _certify_crossing(self, slope, bound, noise):
        if not crosses(slope, bound, noise):
            self.certificate.doubt(self.t0)

    def _certify_order(self, first, functions, d, value, slope, noise):
        """Doubt that the zero of `first` is the first, where another of `functions` may vanish as soon as it
        does; value, slope and noise are those of `first`. Two names of one function vanish together.
        """
        if slope >= 0:  # a touch is in doubt by itself
            return
        of, latest = self.functions_of, latest_zero(self.kit, value, slope, noise, self.t)
        for function in functions:
            other, fall = of.derivative(function, d, 0), of.derivative(function, d, 1)
            blur = of.noise(function) + self.residues.get(function, self.kit.number(0))
            same = function == first or (other == value and fall == slope)
            if not same and may_vanish_by(other, fall, blur, latest):
                self.certificate.doubt(self.t0)

    def _polish(self, function):
        """Go to the one zero of `function` ahead, by Halley's iteration.

        Called where 8 f |f''| < f'^2 and f' < 0: then f falls all the way to its zero, which lies within
        -2 f / f' and is the only one there (Kantorovich), and no other event function can vanish within that.
        """
        start, of = self.t, self.functions_of
        for _ in range(POLISHING):
            d = self.flow.jet(4)
            value, slope = of.derivative(function, d, 0), of.derivative(function, d, 1)
            curvature, before = of.derivative(function, d, 2), self.t
            newton = value / slope
            step = -(2 * newton) / (2 - newton * (curvature / slope))
            self._move(step)
            self.t = self.t if self.t > start else start
            near = self.window if abs(curvature) * self.window < abs(slope) else abs(slope / curvature)
            if self.t == before or abs(step) < self.settled * near:
                return
            self.steps += 1
            self.flow.evaluate(self.t - self.t0)

    def _move(self, step):
        """Go ahead by `step` on the time grid."""
        self.t = self.kit.exact(self.t0 + ((self.t - self.t0) + step))

    def _watch_turn(self, value, slope, curvature, bound):
        """Look for a minimum of the gap function since the point watched before; then watch from here on.

        bound: on its second derivative ahead. A minimum that cannot undercut the grazing margin is not
        looked for. Between slopes of one sign there may be a maximum beside the minimum: then the slope
        itself has an extreme between, which the curvatures tell.
        """
        low, was, before, bend, limit = self.watched
        self.watched = (self.t, value, slope, curvature, bound)
        length = self.t - low
        least = was + before * length - limit * (length * length) / 2
        if (least if least < was else was) >= self.certificate.margin:
            return
        if before < 0 <= slope:
            self._turn_between(low, self.t)
        elif (before < 0) == (slope < 0) and (bend < 0 < curvature or (before < 0 and curvature < 0 < bend)):
            middle = low + extreme_of_slope(self.kit, length, before, bend, slope, curvature)
            between, _ = self._gap_slope(middle)
            if before >= 0 > between:
                self._turn_between(middle, self.t)
            elif before < 0 <= between:
                self._turn_between(low, middle)
        self.flow.evaluate(self.t - self.t0)

    def _turn_between(self, low, high):
        t, turn, depth = turning_point(self._gap_slope, low, high, self.settled * self.window)
        self.flow.evaluate(t - self.t0)
        value = self.functions_of.derivative(GAP, self.flow.jet(2), 0)
        self.certificate.keep_turn(value - depth, turn)

    def _gap_slope(self, t):
        """Slope and curvature of the gap function at time t."""
        self.flow.evaluate(t - self.t0)
        d = self.flow.jet(4)
        return self.functions_of.derivative(GAP, d, 1), self.functions_of.derivative(GAP, d, 2)

    def _turn_before(self, function):
        """Look for a minimum of the gap function between the point watched last and an event of another
        kind, or the end of the run.
        """
        if self.scene.has_stop and function != GAP:
            self.flow.evaluate(self.t - self.t0)
            d = self.flow.jet(4)
            value, slope, curvature = (self.functions_of.derivative(GAP, d, n) for n in range(3))
            self._watch_turn(value, slope, curvature, self.kit.number(0))
