/* Elementary functions of doubles with the same bits on every machine.
 *
 * Additions, products, quotients and square roots only: the C library's functions differ in last bits between libraries, and
 * between processors with and without fused products; a chaotic motion makes another motion of that. The operations stand in a
 * fixed order. Each is right to one or two units in the last place.
 *
 * An argument is reduced by whole multiples of pi/2 or ln 2, which are split so that the products are exact, and the Taylor
 * series of what is left is summed in pairs of pairs, which shortens the chain of operations.
 */
#ifndef VIBSIM_ELEMENTARY_H
#define VIBSIM_ELEMENTARY_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#define WHOLE 6755399441055744.0 /* 1.5 * 2^52: adding it rounds to a whole number, which the last bits then hold */
#define QUARTERS 0.6366197723675814 /* quarter turns to a radian */
/* pi/2 in three parts; a whole number below 2^20 times one of the first two is exact */
#define FIRST_OF_HALF_PI 1.5707963267341256
#define SECOND_OF_HALF_PI 6.077100506303966e-11
#define THIRD_OF_HALF_PI 2.0222662487959506e-21
#define LARGEST_ANGLE 1.6e6 /* [rad], below 2^20 quarter turns */
#define TWO_PI 6.283185307179586
#define PER_LN_2 1.4426950408889634
/* ln 2 is the sum of these two; of the first, the last 21 bits are 0 */
#define LN_2 0.6931471803691238
#define LN_2_LO 1.9082149292705877e-10
#define FLAT_EXPONENT 1400.0 /* beyond which exp is 0 or infinite */
#define UNIT_ROUNDING 0x1p-53
#define ROOT_HALF 0.7071067811865476
/* pi/2 is the sum of these two; likewise of the following pairs */
#define HALF_PI 1.5707963267948966
#define HALF_PI_LO 6.123233995736766e-17
#define VELTKAMP 134217729.0 /* 2^27 + 1: splits a double into two halves of 26 bits */
#define ONE_THIRD 0.3333333333333333
#define ONE_THIRD_LO 1.850371707708594e-17
#define ONE_FIFTH 0.2
#define ONE_FIFTH_LO -1.1102230246251566e-17

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

/* Of an angle below LARGEST_ANGLE; without a branch, so that a compiler makes vectors of a loop of it. Whole quarter turns are
 * taken out; what is left is at most pi/4. Left out of the series: (pi/4)^18 / 19! < 2e-19 of the sine, (pi/4)^18 / 18! < 3e-18 of
 * the cosine.
 */
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

/* Sine and cosine of an angle [rad]; beyond a million radians with the error that n eps in it makes. NAN of what is not finite. */
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

/* n, and in `rise` exp(r) - 1, of x = n ln 2 + r, |r| < 0.35; left out of the series: 0.35^14 / 14! < 5e-18. */
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

/* (1 + rise) 2^n, in two products: infinite or rounded to what is below normal numbers where that is nearest. */
static inline double scaled_exponential(double n, double rise)
{
    double first = (n * 0.5 + WHOLE) - WHOLE;
    return ((1 + rise) * whole_power_of_two(first)) * whole_power_of_two(n - first);
}

/* exp(x); 0 or infinite where that is what is nearest. Without a branch, too. */
static inline double exponential(double x)
{
    double above = x < -FLAT_EXPONENT ? -FLAT_EXPONENT : x, within = above > FLAT_EXPONENT ? FLAT_EXPONENT : above;
    double rise, n = reduced_exponential(within, &rise);
    return scaled_exponential(n, rise);
}

/* exp(x) - 1, to its own last places near 0. */
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

static inline double hyperbolic_tangent(double x)
{
    double rise = exponential_less_1(2 * fabs(x));
    if (rise > 1.0)
        return copysign(1 - 2 / (rise + 2), x);
    return copysign(rise / (rise + 2), x);
}

/* Angle [rad] from -pi/2 to pi/2 of a tangent: atan(c) + atan((x - c) / (1 + c x)), c near x. angles: (up to |x|, c, atan(c) in
 * two parts); between such borders x - c is exact and |x - c| / (1 + c x) at most 1/4. Left out of the series: 0.25^26 / 27 <
 * 9e-18.
 */
static inline double arctangent(double x)
{
    static const double arctangent[] = {
        -1 / 3.0, 1 / 5.0, -1 / 7.0, 1 / 9.0, -1 / 11.0, 1 / 13.0, -1 / 15.0, 1 / 17.0, -1 / 19.0, 1 / 21.0, -1 / 23.0, 1 / 25.0,
    };
    static const double angles[][4] = {
        {0.75, 0.5, 0.4636476090008061, 2.2698777452961687e-17},
        {1.5, 1.0, 0.7853981633974483, 3.061616997868383e-17},
        {4.0, 2.0, 1.1071487177940904, 9.40447137356638e-17},
    };
    double size = fabs(x), r, z, at = HALF_PI, at_lo = HALF_PI_LO;
    int k;
    if (size <= 0.25)
        return x + x * (x * x * sum_of_twelve(arctangent, x * x));
    r = -1 / size;
    for (k = 0; k < 3; k++)
        if (size <= angles[k][0]) {
            r = (size - angles[k][1]) / (1 + angles[k][1] * size);
            at = angles[k][2];
            at_lo = angles[k][3];
            break;
        }
    z = r * r;
    return copysign(at + (r + (r * (z * sum_of_twelve(arctangent, z)) + at_lo)), x);
}

/* Of |x| <= ROOT_HALF, by Newton's method on the sine, from an angle that is wrong by 0.02 at most. */
static inline double moderate_arcsine(double x)
{
    double square = x * x, sine, cosine;
    double angle = x * (1 + square * (1 / 6.0 + square * (3 / 40.0 + square * (15 / 336.0 + square * (105 / 3456.0)))));
    int k;
    for (k = 0; k < 3; k++) {
        sine_cosine(angle, &sine, &cosine);
        angle = angle + (x - sine) / cosine;
    }
    return angle;
}

/* Angle [rad] from -pi/2 to pi/2 of a sine; NAN beyond 1. */
static inline double arcsine(double x)
{
    if (!(fabs(x) <= 1.0))
        return NAN;
    if (fabs(x) > ROOT_HALF)
        return copysign(TWO_PI / 4 - 2 * moderate_arcsine(sqrt((1 - fabs(x)) / 2)), x);
    return moderate_arcsine(x);
}

/* Angle [rad] from 0 to pi of a cosine; NAN beyond 1. */
static inline double arccosine(double x)
{
    if (!(fabs(x) <= 1.0))
        return NAN;
    if (x > 0.5)
        return 2 * moderate_arcsine(sqrt((1 - x) / 2));
    if (x < -0.5)
        return 2 * HALF_PI - (2 * moderate_arcsine(sqrt((1 + x) / 2)) - 2 * HALF_PI_LO);
    return HALF_PI - (moderate_arcsine(x) - HALF_PI_LO);
}

/* Natural logarithm; -INFINITY of 0, NAN of what is below it. ln(2^e m) = e ln 2 + 2 artanh s, s = f / (2 + f), f = m - 1; left
 * out of the series: 0.03^13 / 27 < 1e-21.
 */
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

/* Sums of two doubles, the second below the rounding of the first (Dekker 1971). */
typedef struct {
    double high, low;
} LongDouble;

/* a b - product, product = a b rounded: exactly, as long as it is a normal number. */
static inline double product_error(double a, double b, double product)
{
    double wide = VELTKAMP * a, a1 = wide - (wide - a), a2 = a - a1, b1, b2;
    wide = VELTKAMP * b;
    b1 = wide - (wide - b);
    b2 = b - b1;
    return ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2;
}

/* a + b + low, |a| >= |b| or a = 0, low of the size of rounding. */
static inline LongDouble long_sum(double a, double b, double low)
{
    double total = a + b, rest = (b - (total - a)) + low;
    LongDouble result;
    result.high = total + rest;
    result.low = rest - (result.high - total);
    return result;
}

static inline LongDouble long_product(LongDouble a, LongDouble b)
{
    double product = a.high * b.high, rest = product_error(a.high, b.high, product) + (a.high * b.low + a.low * b.high);
    LongDouble result;
    result.high = product + rest;
    result.low = rest - (result.high - product);
    return result;
}

/* Natural logarithm of a finite a > 0 to 2^-66 of itself: as `logarithm`, artanh s = s (1 + z/3 + z^2/5 + ...), z = s^2; left out:
 * 0.03^15 / 31 < 1e-24.
 */
static inline LongDouble long_logarithm(double a)
{
    static const double area_tangent[] = {
        1 / 7.0, 1 / 9.0, 1 / 11.0, 1 / 13.0, 1 / 15.0, 1 / 17.0, 1 / 19.0, 1 / 21.0, 1 / 23.0, 1 / 25.0, 1 / 27.0, 1 / 29.0,
    };
    LongDouble s, z, sum;
    int e;
    double m = frexp(a, &e), f, under, product;
    if (m < ROOT_HALF) {
        m = m + m;
        e = e - 1;
    }
    f = m - 1;
    under = 2 + f;
    s.high = f / under;
    product = s.high * under;
    s.low = (((f - product) - product_error(s.high, under, product)) - s.high * (f - (under - 2))) / under;
    z = long_product(s, s);
    sum = long_sum(ONE_FIFTH, z.high * sum_of_twelve(area_tangent, z.high), ONE_FIFTH_LO);
    sum = long_product(z, sum);
    sum = long_sum(ONE_THIRD, sum.high, sum.low + ONE_THIRD_LO);
    sum = long_product(s, long_product(z, sum));
    sum = long_sum(s.high, sum.high, sum.low + s.low);
    sum = long_sum(e * LN_2, 2 * sum.high, 2 * sum.low);
    return long_sum(sum.high, e * LN_2_LO, sum.low);
}

/* exp(p log a) of a finite a > 0, the logarithm as a sum of two doubles: p log a is up to 745, and a relative error of eps in it
 * would be 745 eps in the power.
 */
static inline double general_power(double a, double p)
{
    LongDouble logarithm = long_logarithm(a);
    double y = p * logarithm.high, y_lo, n, rise;
    if (!(-FLAT_EXPONENT < y && y < FLAT_EXPONENT))
        return exponential(y);
    y_lo = product_error(p, logarithm.high, y) + p * logarithm.low;
    n = reduced_exponential(y, &rise);
    return scaled_exponential(n, rise + (y_lo + y_lo * rise));
}

/* a^p of a >= 0, NAN of a below 0; 1 for p = 0. By roots and products where |p| is 1/2, 3/2 or 5/2. */
static inline double real_power(double a, double p)
{
    if (!(0.0 < a && a < INFINITY)) {
        if (p == 0 || !(a >= 0))
            return p == 0 ? 1.0 : NAN;
        return p != p ? p : (a == 0) == (p > 0) ? 0.0 : INFINITY;
    }
    if (p == 0.5)
        return sqrt(a);
    if (p == 1.5)
        return a * sqrt(a);
    if (p == 2.5)
        return a * a * sqrt(a);
    if (p == -0.5)
        return 1 / sqrt(a);
    if (p == -1.5)
        return 1 / a / sqrt(a);
    if (p == -2.5)
        return 1 / a / a / sqrt(a);
    return general_power(a, p);
}

#endif
