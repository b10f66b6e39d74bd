/* Laws by which friction falls with speed; twin of vibsim/engine/flows/friction_laws.py. */
#ifndef VIBSIM_FRICTION_LAWS_H
#define VIBSIM_FRICTION_LAWS_H

#include "engine.h"
#include "numbers.h"

enum { HYPERBOLIC, EXPONENTIAL, LAWS };

static inline Real law_start(int law, Real s)
{
    return law == HYPERBOLIC ? 1 / (1 + s) : exponential(-s);
}

/* From coefficient n > 0 of s, what the products of the recurrence take. */
static inline Real law_argument(int law, int n, Real s)
{
    return law == HYPERBOLIC ? s : n * s;
}

/* Coefficient n > 0 of f from the sum of the products; inverse = 1 / n. */
static inline Real law_following(int law, Real total, const Real *f, Real inverse)
{
    return law == HYPERBOLIC ? -(f[0] * total) : -(total * inverse);
}

static inline Real law_slope(int law, Real f)
{
    return law == HYPERBOLIC ? -(f * f) : -f;
}

/* Series of df/ds from that of f. */
static inline void law_slopes(int law, const Real *f, int count, Real *slopes)
{
    int n, i;
    for (n = 0; n < count; n++) {
        Real total = f[0] * f[n];
        for (i = 1; law == HYPERBOLIC && i <= n; i++)
            total = total + f[i] * f[n - i];
        slopes[n] = law == HYPERBOLIC ? -total : -f[n];
    }
}

#define CIRCLES 9
#define LN2 0.6875
#define ALLOWANCE 4.0
#define HALVINGS 256

static const int circle_exponents[CIRCLES] = {4, 3, 2, 5, 1, 6, 8, 12, 16};

/* Whether the growth g(2^k h) is within its room on one of the circles. */
static inline int series_converges(const Real *sizes, int count, const Real *room, Real h)
{
    int i, n;
    for (i = 0; i < CIRCLES; i++) {
        Real radius = (Real)(1 << circle_exponents[i]) * h, growth = 0.0;
        for (n = count - 1; n >= 0; n--)
            growth = growth * radius + sizes[n];
        if (growth <= room[i])
            return 1;
    }
    return 0;
}

/* Binary exponent of the longest step behind which what the series of exp(-s) leaves out stays small. */
static inline double law_reach(int law, const Real *s, int count, double tolerance_exponent, double longest)
{
    Real sizes[SERIES], room[CIRCLES];
    int n, most;
    if (law == HYPERBOLIC)
        return longest;
    sizes[0] = 0.0;
    for (n = 1; n < count; n++)
        sizes[n] = fabs(s[n]) / n;
    for (n = 0; n < CIRCLES; n++)
        room[n] = s[0] + LN2 * (count * circle_exponents[n] + (tolerance_exponent + ALLOWANCE));
    most = binary_exponent(room[CIRCLES - 1]);
    for (n = 1; n < count; n++)
        if (sizes[n] != 0.0) {
            double alone = (double)(most + 1 - binary_exponent(sizes[n])) / n - 1.0;
            longest = alone < longest ? alone : longest;
        }
    for (n = 0; n < HALVINGS; n++) {
        if (longest >= 1000.0 || series_converges(sizes, count, room, power_of_two(longest)))
            break;
        longest = longest - 0.5;
    }
    return longest;
}

#endif
