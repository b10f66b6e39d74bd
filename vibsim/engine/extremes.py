"""Least and greatest displacements of a run, period by period, and the smallest gaps at turns without
contact, read off the flow as it passes.

Between two nodes a displacement d = x_P - x_Q is greatest or least where its rate turns. The nodes lie so
close that a cubic through displacements and rates tells whether it turns; the turn itself is found on the
flow, to the rounding of d. The speed of a rotor is taken like a displacement.

Reading them changes no trajectory.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Generic

from vibsim.engine.flows.base_motion import base_motion
from vibsim.engine.flows.flow import Flow
from vibsim.engine.modes.status import OPEN, Status
from vibsim.engine.modes.ties import Edge
from vibsim.physics.numbers import Kit, N, abs
from vibsim.physics.parts import Scene

Gap = tuple[int, int, int, float]  # stop, its place among the pairs, sense, gap [m]
Knot = tuple[N, N, N]  # time, value, rate

NODES_OF_CLOSED_FORM = 4  # in a piece of 2.25 rad of the fastest rate
ORDERS_TO_A_NODE = 10  # of a Taylor step, which spans 1.3 rad with order 20
NEARLY = 0.2  # share of the rates at both ends below which the one between them is taken to come near 0
HALVINGS = 4  # of an interval in which a displacement may turn twice
ITERATIONS = 8
ROUNDING = 2.0**-55


class Extremes(Generic[N]):
    """Gathers extremes over the stretches of a run, from the time `since` [s] on.

    pairs : columns (P, Q) of the displacements; a rotor's speed follows on them
    gaps : (stop, its place among the pairs, sense, gap [m]) of the stops whose gaps are watched
    rows : at each call of `close`, least and greatest since the one before, one after another
    least, greatest, margins : of everything so far; inf where there was nothing
    """

    def __init__(
        self,
        scene: Scene[N],
        kit: Kit[N],
        flow: Flow[N],
        pairs: Sequence[Edge],
        gaps: Sequence[Gap],
        since: float,
    ) -> None:
        self.scene, self.kit, self.flow = scene, kit, flow
        self.pairs, self.gaps, self.since = pairs, gaps, kit.number(since)
        self.spins = scene.motor is not None
        self.count = len(pairs) + self.spins
        self.based = any(len(scene.bodies) + 1 in pair for pair in pairs)
        self.low, self.high = [kit.inf] * self.count, [-kit.inf] * self.count
        self.least, self.greatest = list(self.low), list(self.high)
        self.margins = [kit.inf] * len(gaps)
        self.rows: list[tuple[N, ...]] = []
        self.at = kit.number(0)
        self.node: list[tuple[N, N]] | None = None

    def open(self, t: N, status: Status) -> None:
        """Begin a stretch at t [s] in the mode `status`."""
        self.at, self.node, self.status = t, None, status

    def until(self, end: N) -> Iterator[None]:
        """Take the stretch up to `end` [s]; a generator, which yields now and then."""
        if end < self.since:
            return
        if self.node is None:
            self.at = self.since if self.at < self.since else self.at
            self.node = self.measure(self.at)
            self._take_all(self.node)
        while self.at < end:
            step = self._step()
            ahead = self.at + step if step < end - self.at else end
            left, right = self.node, self.measure(ahead)
            for q in range(self.count):
                self._span(q, (self.at, *left[q]), (ahead, *right[q]), HALVINGS)
            self._take_all(right)
            self.at, self.node = ahead, right
            yield

    def close(self) -> None:
        """End a period where the last call of `until` ended; the next one begins there."""
        self.rows.append((*self.low, *self.high))
        if self.node is not None:
            self.low, self.high = ([value for value, _ in self.node] for _ in range(2))

    def _step(self) -> N:
        """Distance of the nodes [s]."""
        piece = self.flow.longest_piece(self.at - self.flow.t0)
        closed = self.flow.now is self.flow.closed
        return piece / (NODES_OF_CLOSED_FORM if closed else 1 + self.flow.taylor.order // ORDERS_TO_A_NODE)

    def measure(self, t: N) -> list[tuple[N, N]]:
        """Displacements and their rates at t, by pair; then the speed of the rotor and its rate."""
        state, zero = self.flow.state_at(t), self.kit.number(0)
        X, V = base_motion(self.scene, self.kit, t, self.flow.rows) if self.based else (zero, zero)
        x, v = (*state.x, zero, X), (*state.v, zero, V)
        motions = [(x[P] - x[Q], v[P] - v[Q]) for P, Q in self.pairs]
        if self.spins:
            motions.append((state.w, self.flow.spin_rate(t - self.flow.t0)))
        return motions

    def _take_all(self, node: Sequence[tuple[N, N]]) -> None:
        for q, (value, _) in enumerate(node):
            self._take(q, value)

    def _take(self, q: int, value: N) -> None:
        if value < self.low[q]:
            self.low[q] = value
        if value > self.high[q]:
            self.high[q] = value
        if value < self.least[q]:
            self.least[q] = value
        if value > self.greatest[q]:
            self.greatest[q] = value

    def _span(self, q: int, left: Knot[N], right: Knot[N], halvings: int) -> None:
        """Find what turns between two nodes (t, value, rate)."""
        if left[2] * right[2] < 0:
            self._turn(q, left, right)
        elif halvings > 0 and may_turn_twice(left, right):
            t = left[0] + (right[0] - left[0]) / 2
            if left[0] < t < right[0]:
                middle = (t, *self.measure(t)[q])
                self._take(q, middle[1])
                self._span(q, left, middle, halvings - 1)
                self._span(q, middle, right, halvings - 1)

    def _turn(self, q: int, left: Knot[N], right: Knot[N]) -> None:
        """Take the value at the zero of a rate that changes sign between two nodes."""
        falling = left[2] < 0
        for _ in range(ITERATIONS):
            (t0, x0, v0), (t1, x1, v1) = left, right
            length = t1 - t0
            t = t0 + turn_of_cubic(self.kit, length, x1 - x0, v0, v1) * length
            if not t0 < t < t1:
                return
            value, rate = self.measure(t)[q]
            self._take(q, value)
            self._note_gaps(q, value, falling)
            slope = (v1 - v0) / length
            if rate * rate <= ROUNDING * (abs(slope) * abs(value)):
                return
            if (rate < 0) == falling:
                left = t, value, rate
            else:
                right = t, value, rate

    def _note_gaps(self, q: int, value: N, falling: bool) -> None:
        """Keep the gaps of open stops that are smallest here."""
        for i, (stop, pair, sense, gap) in enumerate(self.gaps):
            if pair == q and (sense > 0) == falling and self.status.stops[stop] == OPEN:
                left = gap + sense * value
                if left < self.margins[i]:
                    self.margins[i] = left


def may_turn_twice(left: Knot[N], right: Knot[N]) -> bool:
    """Whether the rate comes near 0 between two nodes (t, value, rate) at which it has one sign.

    Judged by the rate of the cubic half-way; errs on the side of yes.
    """
    halfway = 1.5 * ((right[1] - left[1]) / (right[0] - left[0])) - 0.25 * (left[2] + right[2])
    return (
        left[2] * right[2] > 0
        and halfway * left[2] < NEARLY * (left[2] * left[2])
        and halfway * right[2] < NEARLY * (right[2] * right[2])
    )


def turn_of_cubic(kit: Kit[N], length: N, rise: N, rate0: N, rate1: N) -> N:
    """Place in [0, 1] at which a cubic turns whose rates at both ends of an interval have opposite signs."""
    d0, d1 = length * rate0, length * rate1
    a, b = d0 + d1 - 2 * rise, 3 * rise - 2 * d0 - d1
    square = b * b - 3 * (a * d0)
    root = kit.sqrt(square) if square > 0 else kit.number(0)
    q = -(b + root) if b > 0 else root - b
    place = d0 / q if q != 0 else kit.number(0)
    if not 0 < place < 1:
        place = q / (3 * a) if a != 0 else kit.number(0)
    return place if 0 < place < 1 else d0 / (d0 - d1)
