/* Elementary operations in a fixed order; those of doubles are repeated in vibsim/physics/numbers.py for what Python decides. */
#ifndef VIBSIM_NUMBERS_H
#define VIBSIM_NUMBERS_H

#include "real.h"

#define LEADING_TERMS 4 /* coefficients that set the scale of a series */

#ifdef LIMBS
/* 2 pi (cycles + cycles_lo) t reduced to [-pi, pi] [rad]. */
static inline Real turn_angle(const Real &cycles, const Real &cycles_lo, const Real &t)
{
    Real turns = (cycles + cycles_lo) * t;
    return 2 * HALF_TURN * (turns - floor(turns + 0.5));
}

/* `angle` moved into [-pi, pi] by whole turns, and the number of turns taken out. */
static inline Real reduce_angle(const Real &angle, Real *turns)
{
    if (fabs(angle) < HALF_TURN) {
        *turns = Real{};
        return angle;
    }
    *turns = floor(angle / (2 * HALF_TURN) + 0.5);
    return angle - *turns * (2 * HALF_TURN);
}

/* `turns` whole turns [rad]. */
static inline Real whole_turns_angle(const Real &turns)
{
    return turns * (2 * HALF_TURN);
}

static inline Real unwind(const Real &angle, const Real &turns)
{
    return angle + turns * (2 * HALF_TURN);
}

static inline int binary_exponent(const Real &x)
{
    return x.sign ? x.exponent : NO_EXPONENT;
}

/* What bounds of many terms are summed in, though they need no digits: doubles, of powers that go beyond their exponents. */
typedef double Magnitude;
typedef struct {
    double mantissa;
    long exponent;
} Power;

static const double INFLATED = 1 + 0x1p-40; /* more than all rounding of a sum of bounds */

static inline Power power_of(const Real &h)
{
    Power p = {ldexp((double)h.m[LIMBS - 1], -WORD), h.exponent};
    if (h.sign == 0)
        p.mantissa = 0;
    return p;
}

static inline Power next_power(Power p, Power h)
{
    const double mantissa = p.mantissa * h.mantissa;
    const int below = mantissa < 0.5; /* both are from 1/2 to 1 */
    Power next = {mantissa * (1 + below), p.exponent + h.exponent - below};
    return next;
}

/* x 2^up, by the highest word. */
static inline double in_double(const Real &x, long up)
{
    const long exponent = x.exponent + up;
    if (x.sign == 0 || exponent < -900) /* far below the exponents of doubles */
        return x.exponent == ENDLESS ? NAN : 0.0;
    return exponent > 900 ? NAN : x.sign * ((double)(int64_t)(x.m[LIMBS - 1] >> 1) * double_of((uint64_t)(exponent - WORD + 1024) << 52));
}

/* |x| p */
static inline Magnitude term_size(const Real &x, Power p)
{
    long exponent = x.exponent + p.exponent;
    if (x.sign == 0 || exponent < -900) /* far below the exponents of doubles */
        return x.exponent == ENDLESS ? NAN : 0.0;
    return exponent > 1000 ? INFINITY : (double)(int64_t)(x.m[LIMBS - 1] >> 1) * p.mantissa * double_of((uint64_t)(exponent - WORD + 1024) << 52);
}

/* 2^y, right to a double: of steps, which may be any. */
static inline Real power_of_two(double y)
{
    double whole = floor(y);
    return scaled(Real(exponential((y - whole) * 0.6931471805599453)), (long)whole);
}
#else
#define TWO_PI_LO 2.4492935982947064e-16 /* 2 pi is the sum of TWO_PI and this */

/* 2 pi (cycles + cycles_lo) t reduced to [-pi, pi] [rad], without forming the large product. cycles * t is split exactly into
 * product and error (Dekker 1971), whole turns are dropped from the product, and only then is it scaled: the phase of a forcing in
 * Hz keeps full accuracy at any t.
 */
static inline Real turn_angle(Real cycles, Real cycles_lo, Real t)
{
    Real product = cycles * t;
    Real wide = VELTKAMP * cycles;
    Real f1 = wide - (wide - cycles), f2 = cycles - f1;
    Real t1, t2, error, turns;
    wide = VELTKAMP * t;
    t1 = wide - (wide - t);
    t2 = t - t1;
    error = ((f1 * t1 - product) + f1 * t2 + f2 * t1) + f2 * t2;
    turns = (product - floor(product + 0.5)) + (error + cycles_lo * t);
    return TWO_PI * turns;
}

/* `angle` moved into [-pi, pi] by whole turns, and the number of turns taken out. */
static inline Real reduce_angle(Real angle, Real *turns)
{
    *turns = floor(angle / TWO_PI + 0.5);
    return (angle - *turns * TWO_PI) - *turns * TWO_PI_LO;
}

/* Bounds of many terms need no more than doubles here. */
typedef double Magnitude;
typedef double Power;

#define INFLATED 1

static inline Power power_of(double h)
{
    return h;
}

static inline Power next_power(Power p, Power h)
{
    return p * h;
}

static inline Magnitude term_size(double x, Power p)
{
    return fabs(x) * p;
}

/* `turns` whole turns [rad]. */
static inline Real whole_turns_angle(Real turns)
{
    return turns * TWO_PI + turns * TWO_PI_LO;
}

static inline Real unwind(Real angle, Real turns)
{
    return angle + turns * TWO_PI;
}

/* Binary exponent as frexp gives it, read off the bits for normal numbers. */
static inline int binary_exponent(Real x)
{
    uint64_t bits;
    int e = NO_EXPONENT;
    memcpy(&bits, &x, sizeof bits);
    bits = bits >> 52 & 0x7ff;
    if (bits != 0 && bits != 0x7ff)
        return (int)bits - 1022;
    if (x != 0.0)
        (void)frexp(x, &e);
    return e;
}

/* 2^y of a real y. */
static inline Real power_of_two(Real y)
{
    return exponential(y * 0.6931471805599453);
}

#endif

/* Polynomial of count >= 2 coefficients, lowest first: even and odd powers in two chains of Horner's rule in t^2, which a
 * processor takes side by side.
 */
static inline Real horner(const Real *c, int count, Real t)
{
    Real square = t * t, high = c[count - 1], low = c[count - 2];
    int n;
    for (n = count - 3; n > 0; n -= 2) {
        high = high * square + c[n];
        low = low * square + c[n - 1];
    }
    if (count % 2 == 0)
        return low + t * high;
    return (high * square + c[0]) + t * low;
}

/* Sum of the sizes of the terms of a series of `count` coefficients, lowest first, at t >= 0. */
static inline Real sizes_at(const Real *c, int count, Real t)
{
    Real total = fabs(c[count - 1]);
    int n;
    for (n = count - 2; n >= 0; n--)
        total = total * t + fabs(c[n]);
    return total;
}

#endif
