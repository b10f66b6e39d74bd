"""The tangent bundle of a run: disturbances kept apart, how fast they grow, and its check by volume."""

from collections.abc import Callable, Sequence
from math import inf, nan
from typing import Any

import numpy as np

from vibsim.engine.errors import State
from vibsim.engine.flows.closed.closed_form import ClosedForm
from vibsim.engine.flows.flow import Flow
from vibsim.engine.flows.taylor import Taylor
from vibsim.engine.modes.rows import ModeRows
from vibsim.engine.tangent.disturbances import Disturbances
from vibsim.engine.tangent.formula_tangent import FormulaTangent
from vibsim.engine.tangent.saltation import Jump
from vibsim.engine.tangent.tangencies import CLOSE
from vibsim.engine.tangent.tangent_space import (
    Gauge,
    TangentSpace,
    components,
    dimension,
    length,
    natural_rate,
    weights,
)
from vibsim.engine.tangent.tangent_taylor import TaylorTangent
from vibsim.physics.elementary import TWELVE
from vibsim.physics.numbers import Kit, N, abs
from vibsim.physics.parts import Motor, Scene

# The tangent bundle of a run: K disturbances carried through modes and events, and how fast they grow.
#
# Disturbances are orthonormalised (modified Gram-Schmidt) at every step and every event that changes them;
# what they grow by there adds up to the exponents (Benettin et al. 1980), the largest first. Event times lie
# on the grid of doubles, while the saltation matrices are those of the exact event: the difference is of the
# size of rounding.
#
# Each tie takes a direction from the tangent space, a rigid stop at rest two, and an impact without
# restitution one: a rank loss, counted. Disturbances that do not fit into it any longer are replaced: by
# possible ones as far as there is room, by some that wait outside, unmoved, until ties let go. A direction
# that was replaced has the exponent minus infinity over the span.
#
# A complete bundle checks itself (Liouville, V10): the logarithm of its volume must grow by the integral of
# the trace of the equations of motion and by the logarithms of the determinants at the events. Sticking,
# where the determinant is 0, reversals that all but stick and slow impacts, which press a volume flat, are
# left out on both sides.


SPANS = 100  # that the growth is recorded in
# Determinant of a jump, and share of the longest disturbance that it leaves of the flattest, below which
# their rounding, eps / FLAT, would drown the check.
FLAT = 2.0**-7
LOST = 2.0**-40  # of the length of a disturbance in a rank loss: what is left is rounding


class TangentBundle(Disturbances[N]):
    """Carries `count` disturbances over the stretches of a run.

    begin : time [s] from which growth counts. `rows` holds (t, logarithm of each one's growth since then) at
    `begin`, at the ends of SPANS equal spans from there to t_end, each at the next event or step behind it.

    vectors : the first `possible` of them lie in the tangent space of the mode, the others wait outside
    columns : of `rows`, by vector; lost : whether a vector has replaced a direction since `begin`
    """

    def __init__(
        self, scene: Scene[N], kit: Kit[N], flow: Flow[N], count: int, begin: N | float = 0.0
    ) -> None:
        super().__init__(scene, kit, flow)
        self.count = count
        self.complete = count == dimension(scene)
        self.begin = kit.number(begin)
        self.weights, self.gauge = weights(scene, kit), Gauge(scene)
        self.residual = kit.number(0)  # growth of the logarithm of the volume that nothing explains
        self.shortest = kit.number(1)  # length that the last orthogonalisation left
        self.rows: list[tuple[N, ...]] = []
        self.next_row = self.losses = 0
        self._start_to_count()

    def _start_to_count(self) -> None:
        self.sums = [self.kit.number(0)] * self.count
        self.columns, self.lost = list(range(self.count)), [False] * self.count

    def open(self, state: State[N], rows: ModeRows[N]) -> None:
        """Disturbances at the start: a general one, then one component each."""
        self.tangencies.pass_by(state, rows)
        zero, one, size = self.kit.number(0), self.kit.number(1), length(self.scene)
        present = components(self.scene)
        general = [one if k in present else zero for k in range(size)]
        units = [[one if k == other else zero for k in range(size)] for other in present[1:]]
        self.vectors, self.possible = [general, *units][: self.count], self.count
        self.renormalise()
        self.space = TangentSpace(self.scene, self.kit, rows)
        self.losses = len(self.space.outside)
        if self.space.outside:
            self._join(state, rows)
            self._shift()
            self._fit()
        self._start_to_count()
        self._mark_waiting()
        self._record(state.t)

    def _moved(self, t: N, ahead: N) -> None:
        self._shift()
        volume = self.renormalise()
        if self.complete:
            tangent = self.tangents[self.flow.now.method]
            formulas = tangent.formulas if isinstance(tangent, TaylorTangent) else None
            grown = log_volume(self.scene, self.kit, self.flow.now, t, ahead, formulas)
            self.residual = self.residual + (volume - grown)
        self._record(ahead)

    def _shift(self) -> None:
        """Measure displacements from the references."""
        for i in range(self.possible):
            self.vectors[i] = self.gauge.apply(self.kit, self.vectors[i])

    def _jumped(self, jump: Jump[N]) -> None:
        self._shift()
        if jump.determinant == 0:
            self.losses += 1
            self._fit()
            return
        lengths = [self.kit.sqrt(self._product(one, one)) for one in self.vectors[: self.possible]]
        longest = max(lengths, default=self.kit.number(0))
        volume, determinant = self.renormalise(), abs(jump.determinant)
        flat = self.shortest <= FLAT * longest
        if flat:  # what is left of nearly parallel vectors is not orthogonal to rounding
            self.renormalise()
        if self.complete and determinant > FLAT and not flat:
            self.residual = self.residual + (volume - self.kit.log(determinant))

    def _change_ties(self, state: State[N], after: ModeRows[N]) -> None:
        outside = len(self.space.outside)
        self.space = TangentSpace(self.scene, self.kit, after)
        self.losses += max(len(self.space.outside) - outside, 0)
        self._join(state, after)
        self._shift()
        self._fit()

    def _fit(self) -> None:
        """Orthonormalise the possible disturbances in the new tangent space; replace those that are lost, and
        those that waited.
        """
        room = len(self.space.inside)
        tried = [(self.vectors[i], self.sums[i], self.columns[i], self.lost[i]) for i in range(self.possible)]
        over = [(self.sums[i], self.columns[i]) for i in range(self.possible, self.count)]
        fitting: list[tuple[list[N], N, int, bool]] = []
        for carried, total, column, lost in tried:
            vector, size = self._orthonormal(carried, [one for one, *_ in fitting])
            if size > LOST and len(fitting) < room:
                fitting.append((vector, total + self.kit.log(size), column, lost))
            else:
                over.append((total, column))
        self.vectors = [vector for vector, *_ in fitting]
        missing = self.count - len(fitting)
        self.possible = min(room, self.count)
        self._fill(self.space.inside, self.possible)
        self._fill(self.space.outside, self.count)
        self.sums = [total for _, total, *_ in fitting] + [total for total, _ in over]
        self.columns = [column for *_, column, _ in fitting] + [column for _, column in over]
        self.lost = [lost for *_, lost in fitting] + [True] * missing

    def _fill(self, candidates: Sequence[Sequence[N]], count: int) -> None:
        """Add from the candidates, each time that which is least like the others, up to `count` vectors."""
        while len(self.vectors) < count:
            tried = [self._orthonormal(vector, self.vectors, scaled=True) for vector in candidates]
            self.vectors.append(max(tried, key=lambda one: one[1])[0])

    def _mark_waiting(self) -> None:
        """Directions that wait outside when counting begins are lost already."""
        for i in range(self.possible, self.count):
            self.lost[i] = True

    def renormalise(self) -> N:
        """Orthonormalise the possible disturbances, add to the growth; returns the logarithm of the volume
        that they spanned.
        """
        volume = self.kit.number(0)
        self.shortest = self.kit.inf
        for i in range(self.possible):
            self.vectors[i], size = self._orthonormal(self.vectors[i], self.vectors[:i])
            self.shortest = size if size < self.shortest else self.shortest
            growth = self.kit.log(size) if size > 0 else -self.kit.inf
            self.sums[i] = self.sums[i] + growth
            volume = volume + growth
        return volume

    def _orthonormal(
        self, vector: Sequence[N], others: Sequence[Sequence[N]], scaled: bool = False
    ) -> tuple[list[N], N]:
        """Remainder of a vector beside orthonormal others, of length 1, and how long it was.

        scaled: in units of the length of the vector.
        """
        kit = self.kit
        whole = kit.sqrt(self._product(vector, vector)) if scaled else kit.number(1)
        left = list(vector)
        for other in others:
            overlap = self._product(other, left)
            left = [a - overlap * b for a, b in zip(left, other, strict=True)]
        size = kit.sqrt(self._product(left, left))
        if size > 0:
            left = [kit.exact(a / size) for a in left]
        return left, size / whole

    def _product(self, a: Sequence[N], b: Sequence[N]) -> N:
        total = self.weights[0] * (a[0] * b[0])
        for k in range(1, len(a)):
            total = total + self.weights[k] * (a[k] * b[k])
        return total

    def _mark(self, end: N) -> N:
        return self._next_mark()

    def _next_mark(self) -> N:
        """Time [s] of the next row."""
        if self.next_row >= SPANS:
            return self.scene.t_end
        return self.begin + (self.scene.t_end - self.begin) * self.next_row / SPANS

    def _record(self, t: N) -> None:
        """Keep a row where one is due at t [s]."""
        if self.next_row > SPANS or t < self._next_mark():
            return
        if self.next_row == 0:
            self._start_to_count()
            self._mark_waiting()
            self.losses = len(self.space.outside)
            self.tangencies.forget()
        row = [self.kit.number(0)] * self.count
        for column, total in zip(self.columns, self.sums, strict=True):
            row[column] = total
        self.rows.append((t, *row))
        while self.next_row <= SPANS and self._next_mark() <= t:
            self.next_row += 1

    def entries(self) -> dict[str, Any]:
        """Values that `tangent_totals` needs, by name."""
        near = self.tangencies
        return {
            "complete": self.complete,
            "rows": self.rows,
            "columns": self.columns,
            "lost": self.lost,
            "losses": self.losses,
            "pieces": self.pieces,
            "residual": self.residual,
            "near": (near.count, near.closest, near.time, max(near.fastest, default=0)),
            "undefined": (near.undefined, near.undefined_time),
        }


# What the tangent bundle of a run came to, by name.


def tangent_totals(
    scene: Scene[N], kit: Kit[N], entries: dict[str, Any], margin: float, margin_time: float
) -> dict[str, Any]:
    """Totals from `TangentBundle.entries()`.

    margin, margin_time: smallest gap at a turn without contact [m] (inf without any) and when [s].

    exponents : growth rates [1/s] over the recorded span, the largest first; NaN where there is no span yet
    and where there is no derivative, -inf where ties took the direction
    growth : rows (t [s], logarithm of the growth of each disturbance since the first row)
    rank_losses : directions that ties took within the span, and those that they held at its start
    tangent_pieces : stretches after which it was orthonormalised
    volume_residual : what is missing in the identity of Liouville [-]; NaN unless the bundle is complete
    tangencies, closest_tangency [-], closest_tangency_time [s] : events crossed almost tangentially, turns
    almost in contact; see `vibsim.engine.tangent.tangencies`
    undefined_time : time [s] of the first event in the span that has no derivative; NaN without any
    """
    columns, lost = entries["columns"], np.array(entries["lost"])
    table = np.array(entries["rows"], dtype="f8").reshape(-1, 1 + len(columns))
    growth = np.ascontiguousarray(table[:, [0, *(1 + column for column in columns)]])
    growth[1:, 1:][:, lost] = -inf
    known = len(growth) > 1
    count, undefined_time = entries["undefined"]
    if count:
        growth[growth[:, 0] > undefined_time, 1:] = nan
    exponents = growth[-1, 1:] / (growth[-1, 0] - growth[0, 0]) if known else np.full(len(columns), nan)
    return {
        "exponents": exponents,
        "undefined_time": float(undefined_time) if count else nan,
        "growth": growth,
        "rank_losses": int(entries["losses"]),
        "tangent_pieces": int(entries["pieces"]),
        "volume_residual": float(entries["residual"]) if entries["complete"] and not count else nan,
        **_tangencies(scene, kit, entries["near"], growth[0, 0] if known else inf, margin, margin_time),
    }


def _tangencies(
    scene: Scene[N],
    kit: Kit[N],
    near: tuple[int, float, float, float],
    begin: float,
    margin: float,
    margin_time: float,
) -> dict[str, Any]:
    """Crossings and the closest turn. A turn as far from contact as the deepest crossing at the natural rate
    counts 1, as that crossing does.
    """
    count, closest, time, fastest = near
    if begin <= margin_time and margin < inf and fastest > 0:
        share = 2 * margin * float(natural_rate(scene, kit)) / fastest
        count += share < CLOSE
        closest, time = min((closest, time), (share, margin_time))
    return {
        "tangencies": int(count),
        "closest_tangency": float(closest),
        "closest_tangency_time": float(time) if closest < 1 else nan,
    }


# How a volume of small disturbances grows within a mode: what Liouville's theorem says, for a check.
#
# With momenta p = M v only damping changes a volume of (x, p), by exp(-int tr(C M^-1) dt); one of (x, v)
# differs from it by det M, which depends on the angle of a rotor. The disturbances themselves are not used.


def log_volume(
    scene: Scene[N],
    kit: Kit[N],
    flow: Taylor[N] | ClosedForm[N],
    t: N,
    end: N,
    formulas: FormulaTangent[N] | None = None,
) -> N:
    """Logarithm of the growth from t to `end` [s], within the stretch that `flow` has just done, of a volume
    that fills the tangent space of its mode; formulas: how disturbances feel them from t on, where there are
    some.
    """
    rows, motor, tau = flow.rows, scene.motor, end - t
    on = None if motor is None else rows.leader[motor.on]
    rate = damping = kit.number(0)
    for q in rows.couplings:
        P, Q = rows.leader[q.P], rows.leader[q.Q]
        for end_column in (P, Q) if P != Q else ():
            if end_column == on:
                damping = damping + q.c
            else:
                rate = rate + q.c * rows.mobility[end_column]
    fixed = -(rate * tau)
    if formulas is not None:
        by_formulas = formulas
        fixed = fixed + tau * _mean(kit, lambda at: by_formulas.divergence(at, on)[0], tau)
    if motor is None or on is None:
        return fixed
    assert isinstance(flow, Taylor)  # no closed form moves a rotor
    drag, inertia = motor.drag, motor.inertia
    carried = rows.mass[on]
    if carried is None:
        return fixed - drag / inertia * tau
    numbers = carried + motor.m3, inertia, damping, drag
    return fixed + _with_rotor(kit, flow, motor, numbers, t, tau, formulas)


def _mean(kit: Kit[N], value: Callable[[N], N], tau: N) -> N:
    """Mean over a piece of length tau."""
    total = kit.number(0)
    for node, weight in zip(*TWELVE, strict=True):
        total = total + weight * value(node * tau)
    return total


def _with_rotor(
    kit: Kit[N],
    flow: Taylor[N],
    motor: Motor[N],
    numbers: tuple[N, N, N, N],
    t: N,
    tau: N,
    formulas: FormulaTangent[N] | None,
) -> N:
    """The share of the motor's group and its rotor; numbers: mass, inertia, damping, drag."""
    mass, inertia, damping, drag = numbers

    def determinant(at: N) -> N:
        """det M = (m + m3)(J + m3 e^2) - (m3 e sin phi)^2."""
        coupling = motor.unbalance * kit.sin(flow.state_after((t - flow.t0) + at).phase)
        return mass * inertia - coupling * coupling

    share = kit.number(0)
    for node, weight in zip(*TWELVE, strict=True):
        share = share + weight / determinant(node * tau)
    damped = (damping * inertia + drag * mass) * (tau * share)
    if formulas is not None:
        by_formulas, on = formulas, flow.rows.leader[motor.on]
        driven = _mean(kit, lambda at: by_formulas.divergence(at, on)[1] / determinant(at), tau)
        damped = damped - inertia * (tau * driven)
    return -damped - kit.log(determinant(tau) / determinant(kit.number(0)))
