"""How a volume of small disturbances grows within a mode: what Liouville's theorem says, for a check.

With momenta p = M v only damping changes a volume of (x, p), by exp(-int tr(C M^-1) dt); one of (x, v)
differs from it by det M, which depends on the angle of a rotor. The disturbances themselves are not used.
"""

from collections.abc import Callable, Iterator

from vibsim.engine.flows.closed.closed_form import ClosedForm
from vibsim.engine.flows.series.taylor import Taylor
from vibsim.engine.modes.rows import Falling
from vibsim.physics.arithmetic.gauss_nodes import TWELVE
from vibsim.physics.arithmetic.numbers import Kit, N, horner
from vibsim.physics.parts import Motor, Scene


def log_volume(scene: Scene[N], kit: Kit[N], flow: Taylor[N] | ClosedForm[N], t: N, end: N) -> N:
    """Logarithm of the growth from t to `end` [s], within the stretch that `flow` has just done, of a volume
    that fills the tangent space of its mode.
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
    if isinstance(flow, Taylor) and rows.falls:
        series = flow
        fixed = fixed - tau * _mean(kit, lambda at: _slowed(series, (t - series.t0) + at, on), tau)
    if motor is None or on is None:
        return fixed
    assert isinstance(flow, Taylor)  # no closed form moves a rotor
    drag, inertia = motor.drag, motor.inertia
    carried = rows.mass[on]
    if carried is None:
        return fixed - drag / inertia * tau
    return fixed + _with_rotor(kit, flow, motor, (carried + motor.m3, inertia, damping, drag), t, tau)


def _mean(kit: Kit[N], value: Callable[[N], N], tau: N) -> N:
    """Mean over a piece of length tau."""
    total = kit.number(0)
    for node, weight in zip(*TWELVE, strict=True):
        total = total + weight * value(node * tau)
    return total


def _dampings(flow: Taylor[N], at: N) -> Iterator[tuple[Falling[N], N]]:
    """(falling friction, its force by the rate v_P' - v_Q' [N s/m], negative) at a time within the step."""
    for one, f in zip(flow.rows.falls, flow.falls, strict=True):
        if flow.rows.leader[one.P] != flow.rows.leader[one.Q]:
            yield one, -(one.on_P * one.rate * one.law.slope(horner(f, at)))


def _slowed(flow: Taylor[N], at: N, on: int | None) -> N:
    """Sum of falling frictions' damping by mass, of all groups but `on` [1/s]."""
    total = 0 * at
    for one, damping in _dampings(flow, at):
        for column in (flow.rows.leader[one.P], flow.rows.leader[one.Q]):
            if column != on:
                total = total + damping * flow.rows.mobility[column]
    return total


def _with_rotor(kit: Kit[N], flow: Taylor[N], motor: Motor[N], numbers: tuple[N, N, N, N], t: N, tau: N) -> N:
    """The share of the motor's group and its rotor; numbers: mass, inertia, damping, drag."""
    mass, inertia, damping, drag = numbers

    def determinant(at: N) -> N:
        """det M = (m + m3)(J + m3 e^2) - (m3 e sin phi)^2."""
        coupling = motor.unbalance * kit.sin(flow.state_after((t - flow.t0) + at).phase)
        return mass * inertia - coupling * coupling

    def falling(at: N) -> N:
        """What falling frictions on the motor's group add to its damping, by det M."""
        total, on = kit.number(0), flow.rows.leader[motor.on]
        for one, extra in _dampings(flow, (t - flow.t0) + at):
            if on in (flow.rows.leader[one.P], flow.rows.leader[one.Q]):
                total = total + extra
        return total / determinant(at)

    share = kit.number(0)
    for node, weight in zip(*TWELVE, strict=True):
        share = share + weight / determinant(node * tau)
    damped = (damping * inertia + drag * mass) * (tau * share)
    if flow.rows.falls:
        damped = damped + inertia * (tau * _mean(kit, falling, tau))
    return -damped - kit.log(determinant(tau) / determinant(kit.number(0)))
