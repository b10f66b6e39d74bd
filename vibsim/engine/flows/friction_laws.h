/* Laws by which friction falls with speed; twin of vibsim/physics/friction_laws. */
#ifndef VIBSIM_FRICTION_LAWS_H
#define VIBSIM_FRICTION_LAWS_H

#include "numbers.h"

enum { HYPERBOLIC, EXPONENTIAL, LAWS };

static inline double law_start(int law, double s)
{
    return law == HYPERBOLIC ? 1 / (1 + s) : decay(s);
}

/* From coefficient n > 0 of s, what the products of the recurrence take. */
static inline double law_argument(int law, int n, double s)
{
    return law == HYPERBOLIC ? s : n * s;
}

/* Coefficient n > 0 of f from the sum of the products; inverse = 1 / n. */
static inline double law_following(int law, double total, const double *f, double inverse)
{
    return law == HYPERBOLIC ? -(f[0] * total) : -(total * inverse);
}

static inline double law_slope(int law, double f)
{
    return law == HYPERBOLIC ? -(f * f) : -f;
}

/* Series of df/ds from that of f. */
static inline void law_slopes(int law, const double *f, int count, double *slopes)
{
    int n, i;
    for (n = 0; n < count; n++) {
        double total = f[0] * f[n];
        for (i = 1; law == HYPERBOLIC && i <= n; i++)
            total = total + f[i] * f[n - i];
        slopes[n] = law == HYPERBOLIC ? -total : -f[n];
    }
}

#endif
