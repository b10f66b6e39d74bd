/* Elementary functions with the same bits on every machine; twin of vibsim/physics/elementary.py. */
#ifndef VIBSIM_ELEMENTARY_H
#define VIBSIM_ELEMENTARY_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#define WHOLE 6755399441055744.0
#define QUARTERS 0.6366197723675814
#define FIRST_OF_HALF_PI 1.5707963267341256
#define SECOND_OF_HALF_PI 6.077100506303966e-11
#define THIRD_OF_HALF_PI 2.0222662487959506e-21
#define LARGEST_ANGLE 1.6e6
#define TWO_PI 6.283185307179586
#define PER_LN_2 1.4426950408889634
#define LN_2 0.6931471803691238
#define LN_2_LO 1.9082149292705877e-10
#define FLAT_EXPONENT 1400.0
#define UNIT_ROUNDING 0x1p-53
#define ROOT_HALF 0.7071067811865476

static inline uint64_t bits_of(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline double double_of(uint64_t bits)
{
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* Of an angle below LARGEST_ANGLE; without a branch, so that a compiler makes vectors of a loop of it. */
static inline void moderate_sine_cosine(double angle, double *sine, double *cosine)
{
    double shifted = angle * QUARTERS + WHOLE, quarters = shifted - WHOLE;
    double r = ((angle - quarters * FIRST_OF_HALF_PI) - quarters * SECOND_OF_HALF_PI) - quarters * THIRD_OF_HALF_PI;
    double z = r * r, z2 = z * z, z4 = z2 * z2, half = 0.5 * z, near = 1 - half;
    double s = ((-1 / 6.0 + 1 / 120.0 * z) + (-1 / 5040.0 + 1 / 362880.0 * z) * z2)
               + ((-1 / 39916800.0 + 1 / 6227020800.0 * z) + (-1 / 1307674368000.0 + 1 / 355687428096000.0 * z) * z2) * z4;
    double c = ((1 / 24.0 + -1 / 720.0 * z) + (1 / 40320.0 + -1 / 3628800.0 * z) * z2)
               + ((1 / 479001600.0 + -1 / 87178291200.0 * z) + 1 / 20922789888000.0 * z2) * z4;
    uint64_t quadrant = bits_of(shifted), odd = 0 - (quadrant & 1);
    uint64_t one = bits_of(r + r * (z * s)), other = bits_of(near + (((1 - near) - half) + z2 * c));
    *sine = double_of(((one & ~odd) | (other & odd)) ^ (quadrant & 2) << 62);
    *cosine = double_of(((other & ~odd) | (one & odd)) ^ ((quadrant + 1) & 2) << 62);
}

static inline void sine_cosine(double angle, double *sine, double *cosine)
{
    if (!(-LARGEST_ANGLE < angle && angle < LARGEST_ANGLE))
        angle = isfinite(angle) ? fmod(angle, TWO_PI) : NAN;
    moderate_sine_cosine(angle, sine, cosine);
}

/* Of an angle that is rounded: 0 where rounding hides them, as at quarter turns, which are none of the numbers. */
static inline void rounded_sine_cosine(double angle, double *sine, double *cosine)
{
    double lost = UNIT_ROUNDING * fabs(angle);
    sine_cosine(angle, sine, cosine);
    *sine = fabs(*sine) > lost ? *sine : 0.0;
    *cosine = fabs(*cosine) > lost ? *cosine : 0.0;
}

static inline double sine_of(double angle)
{
    double sine, cosine;
    sine_cosine(angle, &sine, &cosine);
    return sine;
}

static inline double cosine_of(double angle)
{
    double sine, cosine;
    sine_cosine(angle, &sine, &cosine);
    return cosine;
}

/* 2^n of a whole number within the exponents of normal numbers. */
static inline double whole_power_of_two(double n)
{
    return double_of((bits_of(n + WHOLE) + 1023) << 52);
}

/* c[0] + c[1] x + ... + c[11] x^11. */
static inline double sum_of_twelve(const double *c, double x)
{
    double x2 = x * x, x4 = x2 * x2;
    double low = (c[0] + c[1] * x) + (c[2] + c[3] * x) * x2;
    double middle = (c[4] + c[5] * x) + (c[6] + c[7] * x) * x2;
    double high = (c[8] + c[9] * x) + (c[10] + c[11] * x) * x2;
    return low + (middle + high * x4) * x4;
}

static inline double reduced_exponential(double x, double *rise)
{
    static const double exponential[] = {
        1 / 2.0, 1 / 6.0, 1 / 24.0, 1 / 120.0, 1 / 720.0, 1 / 5040.0, 1 / 40320.0, 1 / 362880.0, 1 / 3628800.0, 1 / 39916800.0,
        1 / 479001600.0, 1 / 6227020800.0,
    };
    double n = (x * PER_LN_2 + WHOLE) - WHOLE, r = (x - n * LN_2) - n * LN_2_LO;
    *rise = r + r * r * sum_of_twelve(exponential, r);
    return n;
}

/* Without a branch, too. */
static inline double exponential(double x)
{
    double above = x < -FLAT_EXPONENT ? -FLAT_EXPONENT : x, within = above > FLAT_EXPONENT ? FLAT_EXPONENT : above;
    double rise, n = reduced_exponential(within, &rise);
    double first = (n * 0.5 + WHOLE) - WHOLE;
    return ((1 + rise) * whole_power_of_two(first)) * whole_power_of_two(n - first);
}

static inline double exponential_less_1(double x)
{
    double n, rise, scale;
    if (!(-40.0 < x && x < 700.0))
        return exponential(x) - 1;
    n = reduced_exponential(x, &rise);
    if (n == 0)
        return rise;
    scale = whole_power_of_two(n);
    return scale * rise + (scale - 1);
}

static inline double hyperbolic_sine(double x)
{
    double rise;
    if (!(-1.0 < x && x < 1.0))
        return (exponential(x) - exponential(-x)) / 2;
    rise = exponential_less_1(x);
    return (rise + rise / (1 + rise)) / 2;
}

static inline double hyperbolic_cosine(double x)
{
    return (exponential(x) + exponential(-x)) / 2;
}

static inline double logarithm(double x)
{
    static const double logarithm[] = {
        2 / 3.0, 2 / 5.0, 2 / 7.0, 2 / 9.0, 2 / 11.0, 2 / 13.0, 2 / 15.0, 2 / 17.0, 2 / 19.0, 2 / 21.0, 2 / 23.0, 2 / 25.0,
    };
    double m, f, s, z, rest, half;
    int e;
    if (!(0.0 < x && x < INFINITY))
        return x == 0 ? -INFINITY : x > 0 ? x : NAN;
    m = frexp(x, &e);
    if (m < ROOT_HALF) {
        m = m + m;
        e = e - 1;
    }
    f = m - 1;
    s = f / (2 + f);
    z = s * s;
    rest = z * sum_of_twelve(logarithm, z);
    half = 0.5 * f * f;
    return e * LN_2 - ((half - (s * (half + rest) + e * LN_2_LO)) - f);
}

#endif
