/* Certified first roots: steps that no root can hide in.
 *
 * If f > 0 at a point and |f''| <= B on the window ahead, then f stays positive for as long as its lower parabola q0 + q1 t - B
 * t^2 / 2 does. Marching by that step never jumps over a root or a tangency and converges quadratically to a simple root. A zero
 * known to be at the start of a window (the event that opened it) is divided out first.
 */
#ifndef VIBSIM_FIRST_ROOT_H
#define VIBSIM_FIRST_ROOT_H

#include <math.h>

static const Real TINY = 1.0261342003245941e-289; /* 2^-960: squares below it have lost digits to underflow */
static const Real FACTORIALS[] = {1, 1, 2, 6, 24, 120, 720, 5040, 40320, 362880, 3628800};

/* Length of the stretch on which q0 + q1 t - bound t^2 / 2 is certainly positive; q0 >= 0: value; q1: slope; bound >= 0: on the
 * absolute second derivative, all at the start of the stretch. For q1 < 0 the form without cancellation is used. Infinite where
 * the parabola never comes down. The step does not depend on the unit of f, so one that keeps squares from underflow is chosen
 * where they would.
 */
static inline Real safe_step(Real q0, Real q1, Real bound)
{
    Real square = q1 * q1 + 2 * bound * q0, root;
    if (square < TINY) {
        Real unit = q0;
        if (fabs(q1) > unit)
            unit = fabs(q1);
        if (bound > unit)
            unit = bound;
        if (unit == 0)
            return INFINITY;
        q0 = q0 / unit;
        q1 = q1 / unit;
        bound = bound / unit;
        square = q1 * q1 + 2 * bound * q0;
    }
    root = sqrt(square);
    if (q1 < 0)
        return 2 * q0 / (root - q1);
    if (bound == 0)
        return INFINITY;
    return (q1 + root) / bound;
}

/* The safe step behind a zero of the given order at t = 0, from f / t^order; leading, following: derivatives of f at 0 of that
 * order and of the next; bound: on the absolute derivative of order + 2. With f / t^m = int_0^1 (1 - s)^(m-1) / (m-1)! f^(m)(s t)
 * ds, the second derivative of the quotient is at most 2 bound / (m + 2)!.
 */
static inline Real deflated_step(int order, Real leading, Real following, Real bound)
{
    return safe_step(leading / FACTORIALS[order], following / FACTORIALS[order + 1], 2 * bound / FACTORIALS[order + 2]);
}

#endif
