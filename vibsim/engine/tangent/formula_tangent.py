"""How small disturbances feel the formulas of a mode and the rotors on its bodies.

A formula passes df = sum of its partial derivatives times the disturbances of what it reads; the derivatives
are formulas themselves, made once for a mode, whose series along the motion come from a tape of their own.

Where the base u of a power u^p comes to zero there is no series, and with p < 1 its derivative is infinite
there, though its integral is not. The piece next to the zero is so short that u is linear in time in it, and
disturbances feel nothing but the means of the derivatives over it, which are taken by quadrature from the
zero itself on: the next pieces begin or end where there are series. So nothing of the integral is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Generic, NamedTuple

from vibsim.engine.flows.tape import (
    INPUTS,
    POWER,
    Inputs,
    Tape,
    TapeMaker,
    TapeSeries,
    TapeValues,
    input_value,
    start_value,
)
from vibsim.engine.flows.taylor import digits_beyond, shortened
from vibsim.physics.formulas import Node, derivative, resolved, walk
from vibsim.physics.numbers import TWO_PI, Kit, N, abs, horner, sizes_at

if TYPE_CHECKING:
    from vibsim.engine.flows.taylor import Taylor
    from vibsim.engine.modes.rows import ModeRows

SHORTENINGS = 200  # of a stretch
LEAST_SHARE = 2.0**-36  # of it, below which it is not shortened: where a derivative begins at infinity
ROUNDING = 4  # of displacements and velocities at its end, in units of eps
READ = ("x", "v", "phi", "w")
MOST_ZEROS = 8  # bases of powers that come to zero in one piece
LINEAR = 2.0**-30  # the most that a base may bend over the piece at its zero, as a share of its rate
TOGETHER = 2.0**-47  # the most of a disturbance that depends on when within the piece its derivatives act
NODE, NODES = 0.2, 27  # of the quadrature: between two; on either side of the middle
ENDS = 2.0**-30  # of an integral: the most that its outermost nodes may have


class Zero(NamedTuple, Generic[N]):
    """A base of powers that is zero where a piece begins or ends: its place on the tape of derivatives, its
    values there, its rate [1/s], its bend [1/s^2], and whether its powers have exponents above 0 only.
    """

    place: int
    first: N
    last: N
    rate: N
    bend: N
    mild: bool


class Slope(NamedTuple):
    """A partial derivative of output `of` of the tape of a mode: with respect to x or v of a column, or phi
    or w of the motor; `output` is its number on the tape of derivatives.
    """

    of: int
    kind: str
    column: int
    output: int


class Slopes(NamedTuple):
    """The partial derivatives of all outputs of a mode, by number of the output."""

    tape: Tape
    of: dict[int, list[Slope]]


def slopes_of(kit: Kit[N], rows: ModeRows[N]) -> Slopes:
    """The derivatives of the formulas of a mode, made when they are first asked for."""
    if rows.slopes is None:
        n = len(rows.leader) - 2
        maker = TapeMaker(kit, {}, rows.columns)
        found: dict[int, list[Slope]] = {}
        for k, node in rows.nodes.items():
            node, factor = resolved(node, rows.sides), rows.factors.get(k, kit.number(1))
            found[k] = [
                Slope(
                    k,
                    of[0],
                    of[1] if len(of) > 1 else -1,
                    maker.scaled_output(slope, factor, ""),
                )
                for of in _inputs(node, n)
                if (slope := derivative(node, of))[:2] != ("num", 0)
            ]
        rows.slopes = Slopes(maker.tape, found)
    slopes: Slopes = rows.slopes
    return slopes


def _inputs(node: Node, bodies: int) -> list[Node]:
    """Parts of the state that a formula reads; ground and base are not disturbed."""
    return [one for one in walk([node]) if one[0] in READ and (len(one) < 2 or 0 <= one[1] < bodies)]


class SlopeShare(NamedTuple):
    """Share of derivative number `output` of force number `force` in the derivative of the acceleration of
    the column `row` with respect to x or v of `column`, both by their leaders; end: 0 for what acts on P, 1
    on Q.
    """

    row: int
    column: int
    force: int
    end: int
    output: int


def shares_of(rows: ModeRows[N], kind: str, slopes: Slopes) -> list[SlopeShare]:
    """All shares of derivatives with respect to x or v, by `kind`."""
    leader = rows.leader
    return [
        SlopeShare(leader[end], leader[one.column], force, place, one.output)
        for force, law in enumerate(rows.formulas)
        for one in slopes.of.get(law.output, ())
        if one.kind == kind
        for place, end in enumerate((law.P, law.Q))
        if end >= 0 and rows.mobility[leader[end]] > 0
    ]


class FormulaTangent(Generic[N]):
    """Disturbed forces of formulas along an expansion of a flow."""

    def __init__(self, kit: Kit[N], flow: Taylor[N]) -> None:
        self.kit, self.flow, self.slopes = kit, flow, slopes_of(kit, flow.rows)
        tape = self.slopes.tape
        self.series = TapeSeries(kit, tape, flow.inverse)
        turning = (flow.rotor.phi, flow.rotor.w) if flow.rotor else None
        self.series.start(flow.t0, flow.order, flow.x, flow.v, turning, flow.nearest)
        for n in range(flow.order):
            self.series.advance(n)

    def disturbed(self, k: int, n: int, vectors: dict[str, Sequence[Sequence[N]]]) -> N:
        """Coefficient n of the disturbance of output k; vectors: series of the disturbances, by kind and
        column.
        """
        total = self.kit.number(0)
        for one in self.slopes.of.get(k, ()):
            slope, moved = self.series.output(one.output), vectors[one.kind][one.column]
            for i in range(n + 1):
                total = total + slope[i] * moved[n - i]
        return total

    def sound_step(self, tau: N) -> N:
        """The stretch tau [s], or a shorter one, at the end of which the derivatives have the values that
        their series say.
        """
        kit, flow = self.kit, self.flow
        tolerance, shortest = kit.power_of_two(flow.tolerance_exponent), tau * LEAST_SHARE
        for _ in range(SHORTENINGS):
            values = self._evaluated(tau)
            excess = 0.0
            for k in range(len(self.slopes.tape.outputs)):
                value, bound = values.output(k)
                series = self.series.output(k)[: flow.order]
                allowed = 2 * bound + flow.order * tolerance * sizes_at(series, tau)
                excess = max(excess, digits_beyond(kit, abs(value - horner(series, tau)), allowed))
            if excess <= 0 or tau <= shortest:
                return tau
            tau = shortened(kit, tau, excess, flow.order)
        return tau

    def zeros(self, tau: N, behind_event: bool, at_event: bool) -> list[Zero[N]]:
        """The bases of powers that are zero at the start or the end of the stretch tau [s].

        behind_event, at_event : whether it begins behind an event and ends at one, which is at the zero
            itself; elsewhere a base that is near zero has the value it has
        """
        found: dict[int, Zero[N]] = {}
        nothing = self.kit.number(0)
        powers = [op for op in self.slopes.tape.ops if op.code == POWER]
        bounds = self._evaluated(tau).bounds if powers else []
        for op in powers:
            base = self.series.series[op.a][: self.flow.order]
            first, last = base[0], horner(base, tau)
            least = self.series.least * abs(base[1]) + bounds[op.a]
            opens, closes = not first > least, at_event and not last > least
            if not (opens or closes):
                continue
            first = nothing if (opens and behind_event) or first < 0 else first
            last = nothing if closes or last < 0 else last
            mild = op.value > 0 and (op.a not in found or found[op.a].mild)
            found[op.a] = Zero(op.a, first, last, abs(base[1]), abs(base[2]), mild)
        return list(found.values())

    def take_means(self, zeros: list[Zero[N]], tau: N) -> bool:
        """Replace the series of the derivatives by their means over the stretch tau [s]; False, and nothing
        is replaced, where bases are not linear in it, or a derivative has no integral.
        """
        straight = all(one.first != one.last and one.bend * tau < LINEAR * one.rate for one in zeros)
        if not straight or len(zeros) > MOST_ZEROS:
            return False
        ops, zero = self.slopes.tape.ops, self.kit.number(0)
        means, sizes, ends = [zero] * len(ops), [zero] * len(ops), [zero] * len(ops)
        start, end = self._inputs(zero), self._inputs(tau)
        share = abs(zeros[0].last - zeros[0].first) / (
            zeros[0].rate * tau
        )  # of tau, in which the base moves so
        total = zero
        for j in range(-NODES, NODES + 1):
            before, after, weight = quadrature_node(self.kit, j)
            total = total + weight
            bases = {one.place: one.first * before + one.last * after for one in zeros}
            values = self._values(_between(start, end, before, after), bases)
            for i, value in enumerate(values):
                part = weight * value
                means[i] = means[i] + part
                sizes[i] = sizes[i] + abs(part)
                if j in (-NODES, NODES):
                    ends[i] = ends[i] + abs(part)
        if not all(self.kit.finite(sizes[i]) and ends[i] <= ENDS * sizes[i] for i in self._felt()):
            return False
        rest = [zero] * (self.flow.order + 1)
        self.series.series = [[mean / total * share, *rest] for mean in means]
        return True

    def _felt(self) -> set[int]:
        """Places on the tape of derivatives of those that move anything."""
        rows = self.flow.rows
        return {
            self.slopes.tape.outputs[one.output]
            for law in rows.formulas
            if any(end >= 0 and rows.mobility[rows.leader[end]] > 0 for end in (law.P, law.Q))
            for one in self.slopes.of.get(law.output, ())
        }

    def _inputs(self, tau: N) -> Inputs[N]:
        """What formulas read a time tau [s] after the expansion point."""
        flow = self.flow
        at = flow.state_after(tau)
        n = len(at.x)
        x = [*at.x, *(horner(flow.x[c], tau) for c in (n, n + 1))]
        v = [*at.v, *(horner(flow.v[c], tau) for c in (n, n + 1))]
        return Inputs(at.t, x, v, self.kit.unwind(at.phase, at.turns), at.w)

    def _evaluated(self, tau: N) -> TapeValues[N]:
        """Values of the derivatives a time tau [s] after the expansion point, from the state there."""
        at, lost = self._inputs(tau), ROUNDING * self.kit.eps
        blur = Inputs(
            lost * abs(at.t),
            [lost * abs(a) for a in at.x],
            [lost * abs(a) for a in at.v],
            lost * abs(at.phi),
            lost * abs(at.w),
        )
        return TapeValues(self.kit, self.slopes.tape, at, blur)

    def _values(self, at: Inputs[N], bases: dict[int, N]) -> list[N]:
        """Values along the tape of derivatives, of which `bases` are given."""
        values: list[N] = []
        for i, op in enumerate(self.slopes.tape.ops):
            if i in bases:
                values.append(bases[i])
            elif op.code in INPUTS:
                values.append(input_value(op, at))
            else:
                values.append(start_value(self.kit, op, values))
        return values

    def rates(self, tau: N) -> tuple[N, N]:
        """Bounds of the rates at which formulas move disturbances at the expansion point or `tau` behind it:
        of stiffness [1/s^2] and of damping [1/s], by sums over rows in which what two columns do to each
        other is measured together.
        """
        largest = [self.kit.number(0), self.kit.number(0)]
        for at in (0 * tau, tau):
            for place, kind in enumerate(("x", "v")):
                rows = self._rows(kind, at)
                for i, row in rows.items():
                    total = abs(row.get(i, 0 * tau))
                    for j, value in row.items():
                        if j != i:
                            back = rows.get(j, {}).get(i, 0 * tau)
                            total = total + self.kit.sqrt(abs(value * back))
                    largest[place] = total if total > largest[place] else largest[place]
        return largest[0], largest[1]

    def _rows(self, kind: str, tau: N) -> dict[int, dict[int, N]]:
        """Derivatives of accelerations of columns with respect to x or v of columns, both by their
        leaders.
        """
        rows, zero = self.flow.rows, 0 * tau
        found: dict[int, dict[int, N]] = {}
        for one in shares_of(rows, kind, self.slopes):
            value = rows.formulas[one.force].sign * horner(self.series.output(one.output), tau)
            row = found.setdefault(one.row, {})
            share = (-1 if one.end else 1) * rows.mobility[one.row] * value
            row[one.column] = row.get(one.column, zero) + share
        return found

    def divergence(self, tau: N, on: int | None) -> tuple[N, N]:
        """Trace of the derivatives of accelerations with respect to velocities, rotors on bodies and the
        group `on` of a motor left out [1/s]; derivative of the force on that group by its velocity [N s/m].
        """
        total, own = 0 * tau, 0 * tau
        for i, row in self._rows("v", tau).items():
            value = row.get(i, 0 * tau)
            if i == on:
                own = value / self.flow.rows.mobility[i]
            else:
                total = total + value
        return total, own


def _between(start: Inputs[N], end: Inputs[N], before: N, after: N) -> Inputs[N]:
    """What is read between two instants, by shares of the first and of the second."""
    return Inputs(
        start.t * before + end.t * after,
        [a * before + b * after for a, b in zip(start.x, end.x, strict=True)],
        [a * before + b * after for a, b in zip(start.v, end.v, strict=True)],
        start.phi * before + end.phi * after,
        start.w * before + end.w * after,
    )


def quadrature_node(kit: Kit[N], j: int) -> tuple[N, N, N]:
    """Node number j, from -NODES to NODES, of a quadrature from 0 to 1 of what may have a power above -0.9 at
    either end, to the rounding of doubles: (1 - node, node, its weight, of which the sum is not 1); the
    double exponential formula of Takahasi and Mori (1974).
    """
    z = kit.number(j * NODE)
    y = TWO_PI / 2 * kit.sinh(z)
    before, after = 1 / (1 + kit.exp(y)), 1 / (1 + kit.exp(-y))
    return before, after, kit.cosh(z) * (before * after)


class RotorTangent(Generic[N]):
    """Disturbances of rotors on bodies, see `flows.rotors_on_bodies`: with q = c w dphi + s dw

    M A - sum u s dw' = dF + sum u (q' - s dw'),     I dw' - u s A = dT + u c a dphi
    """

    def __init__(self, kit: Kit[N], flow: Taylor[N]) -> None:
        assert flow.rotors is not None
        self.kit, self.flow, self.rotors = kit, flow, flow.rotors
        self.turning: list[list[N]] = []  # c w = s'
        self.pull: list[list[N]] = []  # c a
        for i, one in enumerate(flow.rows.rotors):
            s, c, a = self.rotors.s[i], self.rotors.c[i], self.rotors.a[flow.rows.leader[one.on]]
            self.turning.append([(n + 1) * s[n + 1] for n in range(flow.order)])
            self.pull.append([self._sum(c, a, 0, n, n) for n in range(flow.order)])
        self.A: dict[int, list[N]] = {leader: [] for leader in self.rotors.groups}

    def begin(self) -> None:
        """Begin with another disturbance."""
        self.A = {leader: [] for leader in self.rotors.groups}

    def _sum(self, a: Sequence[N], b: Sequence[N], first: int, last: int, n: int) -> N:
        total = self.kit.number(0)
        for i in range(first, last + 1):
            total = total + a[i] * b[n - i]
        return total

    def turn(
        self, n: int, F: list[N], acceleration: list[N], x: Sequence[list[N]], v: Sequence[list[N]]
    ) -> None:
        """Disturbed accelerations of order n of the rotors and of their groups, from disturbed forces F."""
        rows, inverse = self.flow.rows, self.flow.inverse[n + 1]
        for leader in self.rotors.groups:
            mine = [(i, one) for i, one in enumerate(rows.rotors) if rows.leader[one.on] == leader]
            torques: list[N] = []
            force = F[leader]
            for i, one in mine:
                phi, w, s = x[one.column], v[one.column], self.rotors.s[i]
                back = self._sum(self.pull[i], phi, 0, n, n) + self._sum(s, self.A[leader], 1, n, n)
                torques.append(F[one.column] + one.unbalance * back)
                ahead = [*phi, w[n] * inverse]
                tail = self._sum(self.turning[i], ahead, 0, n + 1, n + 1) if n + 1 < self.flow.order else None
                if tail is None:
                    tail = self._sum(self.turning[i], ahead, 0, n, n + 1)
                tail = tail + self._sum(s, w, 1, n + 1, n + 1)
                force = force + one.unbalance * ((n + 1) * tail)
                force = force + one.unbalance * s[0] * torques[-1] / one.inertia
            mass = self.rotors.mass[leader]
            a = self.kit.number(0) if mass is None else force / mass
            self.A[leader].append(a)
            acceleration[leader] = a
            for (i, one), torque in zip(mine, torques, strict=True):
                acceleration[one.column] = (torque + one.unbalance * self.rotors.s[i][0] * a) / one.inertia

    def thrust(self, column: int, x: Sequence[list[N]], v: Sequence[list[N]]) -> N:
        """Disturbed force of the rotors on a column at the expansion point."""
        total = self.kit.number(0)
        for i, one in enumerate(self.flow.rows.rotors):
            if one.on == column:
                phi, w = x[one.column], v[one.column]
                slope = (
                    self.turning[i][1] * phi[0]
                    + self.turning[i][0] * phi[1]
                    + self.rotors.s[i][1] * w[0]
                    + self.rotors.s[i][0] * w[1]
                )
                total = total + one.unbalance * slope
        return total
