/* Elementary operations in a fixed order; twin of vibsim/physics/numbers.py. */
#ifndef VIBSIM_NUMBERS_H
#define VIBSIM_NUMBERS_H

#include <math.h>

#define TWO_PI 6.283185307179586
#define TWO_PI_LO 2.4492935982947064e-16
#define VELTKAMP 134217729.0

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

static inline int binary_exponent(double x)
{
    int e = -2000;
    if (x != 0.0)
        (void)frexp(x, &e);
    return e;
}

static inline double power_of_two(double y)
{
    return exp(y * 0.6931471805599453);
}

static inline int sign_of(double x)
{
    return x > 0 ? 1 : x < 0 ? -1 : 0;
}

#endif
