"""How small disturbances feel the formulas of a mode and the rotors on its bodies.

A formula passes df = sum of its partial derivatives times the disturbances of what it reads; the derivatives
are formulas themselves, made once for a mode, whose series along the motion come from a tape of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Generic, NamedTuple

from vibsim.engine.flows.tape import Inputs, Tape, TapeMaker, TapeSeries, TapeValues
from vibsim.engine.flows.taylor import digits_beyond, shortened
from vibsim.physics.formulas import Node, derivative, resolved, walk
from vibsim.physics.numbers import Kit, N, abs, horner, sizes_at

if TYPE_CHECKING:
    from vibsim.engine.flows.taylor import Taylor
    from vibsim.engine.modes.rows import ModeRows

SHORTENINGS = 200  # of a stretch
LEAST_SHARE = 2.0**-36  # of it, below which it is not shortened: where a derivative begins at infinity
ROUNDING = 4  # of displacements and velocities at its end, in units of eps
READ = ("x", "v", "phi", "w")


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
            node = resolved(node, rows.sides)
            found[k] = [
                Slope(k, of[0], of[1] if len(of) > 1 else -1, maker.output(slope))
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
        self.series.start(flow.t0, flow.order, flow.x, flow.v, turning)
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
            at = flow.state_after(tau)
            n = len(at.x)
            x = [*at.x, *(horner(flow.x[c], tau) for c in (n, n + 1))]
            v = [*at.v, *(horner(flow.v[c], tau) for c in (n, n + 1))]
            lost = ROUNDING * kit.eps
            phi = kit.unwind(at.phase, at.turns)
            blur = Inputs(
                lost * abs(at.t),
                [lost * abs(a) for a in x],
                [lost * abs(a) for a in v],
                lost * abs(phi),
                lost * abs(at.w),
            )
            values = TapeValues(kit, self.slopes.tape, Inputs(at.t, x, v, phi, at.w), blur)
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

    def divergence(self, tau: N) -> N:
        """Trace of the derivatives of accelerations with respect to velocities, rotors on bodies left out
        [1/s].
        """
        total = 0 * tau
        for i, row in self._rows("v", tau).items():
            total = total + row.get(i, 0 * tau)
        return total


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
