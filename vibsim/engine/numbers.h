/* Elementary operations in a fixed order; twin of vibsim/physics/numbers.py. */
#ifndef VIBSIM_NUMBERS_H
#define VIBSIM_NUMBERS_H

#include "elementary.h"

#define TWO_PI_LO 2.4492935982947064e-16

static inline double turn_angle(double cycles, double cycles_lo, double t)
{
    double product = cycles * t;
    double wide = VELTKAMP * cycles;
    double f1 = wide - (wide - cycles), f2 = cycles - f1;
    double t1, t2, error, turns;
    wide = VELTKAMP * t;
    t1 = wide - (wide - t);
    t2 = t - t1;
    error = ((f1 * t1 - product) + f1 * t2 + f2 * t1) + f2 * t2;
    turns = (product - floor(product + 0.5)) + (error + cycles_lo * t);
    return TWO_PI * turns;
}

static inline double reduce_angle(double angle, double *turns)
{
    *turns = floor(angle / TWO_PI + 0.5);
    return (angle - *turns * TWO_PI) - *turns * TWO_PI_LO;
}

static inline double unwind(double angle, double turns)
{
    return angle + turns * TWO_PI;
}

/* Binary exponent as frexp gives it, read off the bits for normal numbers. */
static inline int binary_exponent(double x)
{
    uint64_t bits;
    int e = -2000;
    memcpy(&bits, &x, sizeof bits);
    bits = bits >> 52 & 0x7ff;
    if (bits != 0 && bits != 0x7ff)
        return (int)bits - 1022;
    if (x != 0.0)
        (void)frexp(x, &e);
    return e;
}

/* Polynomial of count >= 2 coefficients, lowest first: even and odd powers in two chains. */
static inline double horner(const double *c, int count, double t)
{
    double square = t * t, high = c[count - 1], low = c[count - 2];
    int n;
    for (n = count - 3; n > 0; n -= 2) {
        high = high * square + c[n];
        low = low * square + c[n - 1];
    }
    if (count % 2 == 0)
        return low + t * high;
    return (high * square + c[0]) + t * low;
}

static inline double power_of_two(double y)
{
    return exponential(y * 0.6931471805599453);
}

static inline int sign_of(double x)
{
    return x > 0 ? 1 : x < 0 ? -1 : 0;
}

#endif
