/* Steps that no root can hide in. */
#ifndef VIBSIM_FIRST_ROOT_H
#define VIBSIM_FIRST_ROOT_H

#include <math.h>

static const Real TINY = 1.0261342003245941e-289; /* 2^-960: squares below it have lost digits to underflow */
static const Real FACTORIALS[] = {1, 1, 2, 6, 24, 120, 720, 5040, 40320, 362880, 3628800};

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

static inline Real deflated_step(int order, Real leading, Real following, Real bound)
{
    return safe_step(leading / FACTORIALS[order], following / FACTORIALS[order + 1], 2 * bound / FACTORIALS[order + 2]);
}

#endif
