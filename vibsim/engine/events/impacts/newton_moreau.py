"""The law of rigid impacts (Newton, Moreau): impulses of all rigid stops that touch at one instant.

With the rates g' of their depths before and after, restitutions e and impulses L,

    L_j >= 0,    w_j = g'_j(after) + e_j g'_j(before) <= 0,    L_j w_j = 0,    g'(after) = g'(before) - G L

G = N M^-1 N' from the gradients N of the rates and the mass matrix M (Moreau 1988; Glocker 2001). It is the
condition of a minimum: L is the solution of non-negative least squares that the active-set method of Lawson
and Hanson (1974) finds exactly, in a fixed order. What is not tied to a stop goes on: friction, springs and
elastic stops have finite forces and give no impulse.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic

from vibsim.physics.numbers import Kit, N, abs
from vibsim.physics.parts import Motor, Scene

ROUNDING = 8  # roundings of a sum of a few products, in units of eps
NEAR = 64  # units in the last place of the time or of displacements, below which zeros may be one or none
MOST_IMPACTS = 1000  # one after the other at one instant; behind them the rest is taken as plastic


@dataclass(frozen=True)
class Contact(Generic[N]):
    """A rigid stop that touches: number of the stop, columns of its ends, sense and restitution."""

    stop: int
    P: int
    Q: int
    sense: int
    e: N

    def push_on(self, column: int) -> int:
        """1 or -1 where an impulse at the stop pushes a column forwards or backwards, 0 where it does not."""
        return {self.P: self.sense, self.Q: -self.sense}.get(column, 0)


@dataclass(frozen=True)
class Impulse(Generic[N]):
    """Impulse that passed a stop in an impact [N s], and the rates of its depth before and after it [m/s]."""

    stop: int
    impulse: N
    before: N
    after: N


@dataclass
class Masses(Generic[N]):
    """Mobility that impulses meet: 1 / mass by column, 0 for ground and base; with a motor the body it is on,
    and the speed that its rotor gains per unit of impulse on that body.
    """

    mobility: list[N]
    on: int = -1
    turning: N | int = 0
    rotors: tuple[tuple[int, int, N], ...] = ()


def masses(scene: Scene[N], kit: Kit[N], phase: N, x: Sequence[N] = ()) -> Masses[N]:
    """The `Masses` of a scene whose rotor stands at the angle `phase` [rad], other rotors where x,
    displacements of all bodies, says; of every body by itself.
    """
    zero = kit.number(0)
    if scene.rotors:
        own, turned = effective_masses(scene, kit, x)
        return Masses([1 / m for m in own] + [zero, zero], rotors=turned)
    mobility = [1 / body.m for body in scene.bodies] + [zero, zero]
    motor = scene.motor
    if motor is None:
        return Masses(mobility)
    inertia, coupling = motor.inertia, motor.unbalance * kit.sin(phase)
    determinant = (scene.bodies[motor.on].m + motor.m3) * inertia - coupling * coupling
    mobility[motor.on] = inertia / determinant
    return Masses(mobility, motor.on, coupling / determinant)


def effective_masses(
    scene: Scene[N], kit: Kit[N], x: Sequence[N]
) -> tuple[list[N], tuple[tuple[int, int, N], ...]]:
    """Mass that impulses meet on each body [kg], less what its rotors keep of theirs; and of each rotor its
    column, that of its body, and the speed that it gains per speed that the body gains [1/m].
    """
    own = [body.m for body in scene.bodies]
    turned = []
    for one in scene.rotors:
        coupling, inertia = one.unbalance * kit.sin(x[one.column]), scene.bodies[one.column].m
        own[one.on] = own[one.on] - coupling * coupling / inertia
        turned.append((one.column, one.on, coupling / inertia))
    return own, tuple(turned)


def motor_body(motor: Motor[N], m: N, kit: Kit[N], phase: N) -> tuple[N, N]:
    """Mass that an impact meets on the body, of mass m, that the motor is on, while its rotor stands at the
    angle `phase`: (mass [kg], speed that the rotor gains per speed that the body gains [1/m]).
    """
    inertia, coupling = motor.inertia, motor.unbalance * kit.sin(phase)
    return m + motor.m3 - coupling * coupling / inertia, coupling / inertia


def rate_of(kit: Kit[N], contact: Contact[N], v: Sequence[N], size: N | int = 0) -> N:
    """Rate of the depth of a stop [m/s], from the velocities of all columns; 0 where rounding cannot tell it
    from that.

    size : of the velocities that these were computed from, where that is larger than they are [m/s]
    """
    rate = -(contact.sense * (v[contact.P] - v[contact.Q]))
    own = abs(v[contact.P]) + abs(v[contact.Q])
    noise = ROUNDING * kit.eps * (own if own > size else size)
    return rate if abs(rate) > noise else 0 * rate


def size_of(contacts: Sequence[Contact[N]], v: Sequence[N]) -> N:
    """Sum of the speeds of the ends of stops [m/s]."""
    columns = sorted({end for c in contacts for end in (c.P, c.Q)})
    total = abs(v[columns[0]])
    for column in columns[1:]:
        total = total + abs(v[column])
    return total


def unmet(kit: Kit[N], contacts: Sequence[Contact[N]], before: Sequence[N], after: Sequence[N]) -> bool:
    """Whether velocities `after` an impact break its law beyond rounding: where no impulse can part the ends
    of all stops, since ground and base hold them from both sides.
    """
    noise = 8 * ROUNDING * kit.eps * (size_of(contacts, before) + size_of(contacts, after))
    return any(rate_of(kit, c, after) + c.e * rate_of(kit, c, before) > noise for c in contacts)


def impact(
    kit: Kit[N], bodies: Masses[N], contacts: Sequence[Contact[N]], v: Sequence[N], w: N
) -> tuple[list[N], N, list[Impulse[N]]]:
    """One impact: (velocities of all columns behind it, speed of the rotor, [`Impulse`]).

    bodies: `Masses`; contacts: the stops that touch; v: velocities of all columns, w: speed of the rotor.
    The rate that the law gives a stop is exact in its `Impulse`, where those of the velocities are rounded.
    What these lack of it behind impulses of several stops is passed on in a second step: the impulses of a
    light body between heavy ones are large and cancel, and would leave speeds 50 roundings off.
    """
    before = [rate_of(kit, contact, v) for contact in contacts]
    demands = [(1 + c.e) * rate for c, rate in zip(contacts, before, strict=True)]
    couplings = [[coupling(bodies, a, b) for b in contacts] for a in contacts]
    alone = len(contacts) == 1 and demands[0] > 0 and couplings[0][0] > 0
    active, impulses = ([0], demands) if alone else _least(kit, couplings, demands)
    if len(active) == 1:
        after, speed, only = _single(bodies, contacts[active[0]], v, w)
        return _with_rotors(bodies, v, after), speed, only
    struck = [contacts[j] for j in active]
    after, moved = _passed_on(kit, bodies, struck, impulses, v)
    lacking = [
        c.e * rate - c.sense * (after[c.P] - after[c.Q]) for c, rate in zip(contacts, before, strict=True)
    ]
    more = solved(kit, couplings, lacking, active) or []
    after, turning = _passed_on(kit, bodies, struck, more, after)
    impulses = [impulse + rest for impulse, rest in zip(impulses, more, strict=True)]
    passed = [
        Impulse(contacts[j].stop, impulse, before[j], -(contacts[j].e * before[j]))
        for j, impulse in zip(active, impulses, strict=True)
    ]
    return _with_rotors(bodies, v, after), w + bodies.turning * (moved + turning), passed


def _with_rotors(bodies: Masses[N], before: Sequence[N], after: list[N]) -> list[N]:
    """The velocities with the speeds that rotors gain with those of their bodies."""
    for column, on, turning in bodies.rotors:
        after[column] = after[column] + turning * (after[on] - before[on])
    return after


def _passed_on(
    kit: Kit[N], bodies: Masses[N], struck: Sequence[Contact[N]], impulses: Sequence[N], v: Sequence[N]
) -> tuple[list[N], N]:
    """Velocities of all columns behind impulses at the stops `struck`, and the sum of those on the body of
    the rotor.
    """
    after, moved = list(v), kit.number(0)
    for c, impulse in zip(struck, impulses, strict=True):
        for column, sign in ((c.P, c.sense), (c.Q, -c.sense)):
            after[column] = after[column] + sign * impulse * bodies.mobility[column]
            if column == bodies.on:
                moved = moved + sign * impulse
    return after, moved


def _single(bodies: Masses[N], c: Contact[N], v: Sequence[N], w: N) -> tuple[list[N], N, list[Impulse[N]]]:
    """An impact at one stop: both ends go on with what they have in common, and part with e times what they
    had not. So the speed of a body before a wall is turned round to the bit where e = 1.
    """
    own, other = bodies.mobility[c.P], bodies.mobility[c.Q]
    between, together = v[c.P] - v[c.Q], own + other
    after = list(v)
    if other == 0:
        after[c.P] = v[c.Q] - c.e * between
    elif own == 0:
        after[c.Q] = v[c.P] + c.e * between
    else:
        common = (other * v[c.P] + own * v[c.Q]) / together
        after[c.P] = common - c.e * (own / together * between)
        after[c.Q] = common + c.e * (other / together * between)
    rate = -(c.sense * between)
    impulse = (1 + c.e) * rate / together
    if bodies.on in (c.P, c.Q):
        on_body = c.sense * impulse if bodies.on == c.P else -(c.sense * impulse)
        w = w + bodies.turning * on_body
    return after, w, [Impulse(c.stop, impulse, rate, -(c.e * rate))]


def coupling(bodies: Masses[N], a: Contact[N], b: Contact[N]) -> N:
    """By how much an impulse 1 at stop b slows the depth of stop a [1/kg]."""
    total = 0 * bodies.mobility[a.P]
    for column, sign in ((a.P, -a.sense), (a.Q, a.sense)):
        for other, factor in ((b.P, -b.sense), (b.Q, b.sense)):
            if column == other:
                total = total + sign * factor * bodies.mobility[column]
    return total


def _least(kit: Kit[N], couplings: Sequence[Sequence[N]], demands: Sequence[N]) -> tuple[list[int], list[N]]:
    """Active stops and their impulses: L >= 0, z = G L - demand >= 0, L z = 0."""
    active: list[int] = []
    impulses: list[N] = []
    barred: set[int] = set()
    for _ in range(3 * len(demands) + 1):
        lacking = {
            j: _lack(kit, couplings[j], demands[j], active, impulses)
            for j in range(len(demands))
            if j not in active and j not in barred
        }
        needy = [j for j, lack in lacking.items() if lack > 0]
        if not needy:
            break
        joining = max(needy, key=lambda j: (lacking[j], -j))
        solution = solved(kit, couplings, demands, [*active, joining])
        if solution is None:  # that stop is held by the others already
            barred.add(joining)
            continue
        impulses.append(kit.number(0))
        active.append(joining)
        while any(value <= 0 for value in solution):
            active, impulses = _step_back(active, impulses, solution)
            solution = solved(kit, couplings, demands, active)
            assert solution is not None  # part of an independent set is independent
        impulses = solution
        barred.clear()
    least = ROUNDING * kit.eps * max(impulses, default=kit.number(0))  # below, a stop passes nothing
    order = sorted((k for k in range(len(active)) if impulses[k] > least), key=lambda k: active[k])
    return [active[k] for k in order], [impulses[k] for k in order]


def _lack(kit: Kit[N], row: Sequence[N], demand: N, active: Sequence[int], impulses: Sequence[N]) -> N:
    """How much of its demand a stop lacks; 0 where that is rounding."""
    lack, size = demand, abs(demand)
    for j, impulse in zip(active, impulses, strict=True):
        lack = lack - row[j] * impulse
        size = size + abs(row[j] * impulse)
    return lack if lack > ROUNDING * kit.eps * size else 0 * lack


def _step_back(
    active: Sequence[int], impulses: Sequence[N], solution: Sequence[N]
) -> tuple[list[int], list[N]]:
    """As far towards the solution as no impulse becomes negative; those that become zero leave."""
    reach: N | None = None
    leaving = -1
    for k, (now, then) in enumerate(zip(impulses, solution, strict=True)):
        if then <= 0:
            share = now / (now - then) if now > then else 0 * now
            if reach is None or share < reach:
                reach, leaving = share, k
    assert reach is not None
    moved = [now + reach * (then - now) for now, then in zip(impulses, solution, strict=True)]
    remaining = [k for k in range(len(active)) if k != leaving and moved[k] >= 0]
    return [active[k] for k in remaining], [moved[k] for k in remaining]


def solved(
    kit: Kit[N], couplings: Sequence[Sequence[N]], demands: Sequence[N], active: Sequence[int]
) -> list[N] | None:
    """Impulses with G L = demand on the active stops; None where those depend on each other. Cholesky's
    factorisation without square roots.
    """
    n = len(active)
    lower: list[list[N]] = []
    pivots: list[N] = []
    for i in range(n):
        row: list[N] = []
        pivot = couplings[active[i]][active[i]]
        for k in range(i):
            value = couplings[active[i]][active[k]]
            for m in range(k):
                value = value - row[m] * lower[k][m] * pivots[m]
            row.append(value / pivots[k])
        for k in range(i):
            pivot = pivot - row[k] * row[k] * pivots[k]
        if not pivot > ROUNDING * n * kit.eps * couplings[active[i]][active[i]]:
            return None
        lower.append(row)
        pivots.append(pivot)
    solution: list[N] = []
    for i in range(n):
        value = demands[active[i]]
        for k in range(i):
            value = value - lower[i][k] * solution[k]
        solution.append(value)
    solution = [value / pivot for value, pivot in zip(solution, pivots, strict=True)]
    for i in reversed(range(n)):
        for k in range(i + 1, n):
            solution[i] = solution[i] - lower[k][i] * solution[k]
    return solution
