"""Certified first roots: steps that no root can hide in.

If f > 0 at a point and |f''| <= B on the window ahead, then f stays positive for as long as its lower
parabola q0 + q1 t - B t^2 / 2 does. Marching by that step never jumps over a root or a tangency and
converges quadratically to a simple root. A zero known to be at the start of a window (the event that opened
it) is divided out first.
"""

from collections.abc import Sequence

from vibsim.physics.arithmetic.numbers import Kit, N, abs

TINY = 2.0**-960  # squares below it have lost digits to underflow
FACTORIALS = (1, 1, 2, 6, 24, 120, 720, 5040, 40320, 362880, 3628800)


def safe_step(kit: Kit[N], q0: N, q1: N, bound: N) -> N:
    """Length of the stretch on which q0 + q1 t - bound t^2 / 2 is certainly positive.

    q0 >= 0: value; q1: slope; bound >= 0 on the absolute second derivative, all at the start of the stretch.
    For q1 < 0 the cancellation-free form is used. Infinite where the parabola never comes down. The step does
    not depend on the unit of f, so one that keeps squares from underflow is chosen where they would.
    """
    square = q1 * q1 + 2 * bound * q0
    if square < TINY:
        unit = max(q0, abs(q1), bound)
        if unit == 0:
            return kit.inf
        q0, q1, bound = q0 / unit, q1 / unit, bound / unit
        square = q1 * q1 + 2 * bound * q0
    root = kit.sqrt(square)
    if q1 < 0:
        return 2 * q0 / (root - q1)
    if bound == 0:
        return kit.inf
    return (q1 + root) / bound


def deflated_step(kit: Kit[N], order: int, leading: N, following: N, bound: N) -> N:
    """The safe step behind a zero of the given order at t = 0, from f / t^order.

    leading, following: derivatives of f at 0 of that order and of the next; bound: on the absolute
    derivative of order + 2. With f / t^m = int_0^1 (1 - s)^(m-1) / (m-1)! f^(m)(s t) ds, the second
    derivative of the quotient is at most 2 bound / (m + 2)!.
    """
    return safe_step(
        kit,
        leading / FACTORIALS[order],
        following / FACTORIALS[order + 1],
        2 * bound / FACTORIALS[order + 2],
    )


def leading_order(derivatives: Sequence[N], known: int) -> int:
    """Order of the first derivative that is not zero, the first `known` of them being zero by the event that
    led here.

    Returns len(derivatives) where all are zero: the function rests at zero.
    """
    order = min(known, len(derivatives))
    while order < len(derivatives) and derivatives[order] == 0:
        order += 1
    return order
