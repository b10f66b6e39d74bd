/* Elementary functions of numbers of WORDS words: reduction of the argument, also by what doubles tell, and power series. Errors are
 * a few units in the last of 64 WORDS bits, which lies 20 bits or more below the unit round-off that decisions go by.
 */
#include "limbs_functions.h"

#include "elementary.h"
#include "words.h"

#ifndef WORDS_BY_RUN /* see precision_by_run.cpp */
#include "fixed_series.h"

enum { TERMS = LIMBS == 2 ? 14 : LIMBS == 3 ? 19 : 24, HALVINGS = 8 }; /* of the power series of exp */

thread_local Real unit_roundoff;

void set_precision(int bits)
{
    unit_roundoff = scaled(Real(1), -bits);
}

/* Constants to 512 bits, lowest word first. */
static const uint64_t half_pi_words[] = {0x4fe1356d6d51c245, 0x302b0a6df25f1437, 0xef9519b3cd3a431b, 0x514a08798e3404dd,
                                         0x020bbea63b139b22, 0x29024e088a67cc74, 0xc4c6628b80dc1cd1, 0xc90fdaa22168c234};
static const uint64_t ln_2_words[] = {0x27573b291169b825, 0xed2eae35c1382144, 0x559552fb4afa1b10, 0xe7b876206debac98,
                                      0x8a0d175b8baafa2b, 0x40f343267298b62d, 0xc9e3b39803f2f6af, 0xb17217f7d1cf79ab};

static Real constant(const uint64_t *words, int exponent)
{
    uint64_t w[8];
    memcpy(w, words, sizeof w);
    return normal(w, 8, exponent, 1);
}

static const Real half_pi = constant(half_pi_words, 1), ln_2 = constant(ln_2_words, 0);
const Real HALF_TURN = scaled(half_pi, 1);

struct Factorials {
    Real inverse[TERMS + 1];
    Factorials()
    {
        int n;
        inverse[0] = 1;
        for (n = 1; n <= TERMS; n++)
            inverse[n] = inverse[n - 1] / n;
    }
};

static const Factorials factorials;

/* Sine and cosine of |r| < 0.8. */
static void small_sine_cosine(const Real &r, Real *sine, Real *cosine)
{
    const Real square = r * r;
    *cosine = *sine = 1;
    if (square.sign != 0)
        wave_sums(square, cosine, sine);
    *sine = r * *sine;
}

/* exp(r) - 1 of |r| < 0.4: of r / 2^HALVINGS by its series, then as often (1 + u)^2 - 1 = u (2 + u). */
static Real small_rise(const Real &r)
{
    Real part = scaled(r, -HALVINGS), u;
    int n = TERMS;
    u = factorials.inverse[n];
    for (n -= 1; n >= 1; n--)
        u = factorials.inverse[n] + part * u;
    u = part * u;
    for (n = 0; n < HALVINGS; n++)
        u = u * (2 + u);
    return u;
}
#endif

enum { MODERATE = 20 }; /* binary digits of an angle whose quadrant doubles tell */
static const double PER_HALF_PI = 0.6366197723675814;
enum { NEAR = 6 }; /* binary digits that a number is small by where its series alone is taken */

static Real nearest_whole(const Real &x)
{
    return floor(x + 0.5);
}

void sine_cosine(const Real &angle, Real *sine, Real *cosine)
{
    Real quarters, s, c;
    int quadrant;
    if (!isfinite(angle)) {
        *sine = *cosine = NAN;
        return;
    }
    if (angle.exponent < MODERATE) {
        const double near = floor((double)angle * PER_HALF_PI + 0.5);
        quarters = near;
        quadrant = (int)near & 3;
    } else {
        quarters = nearest_whole(angle / half_pi);
        quadrant = (int)(double)(quarters - scaled(floor(scaled(quarters, -2)), 2));
    }
    small_sine_cosine(angle - quarters * half_pi, &s, &c);
    *sine = quadrant == 0 ? s : quadrant == 1 ? c : quadrant == 2 ? -s : -c;
    *cosine = quadrant == 0 ? c : quadrant == 1 ? -s : quadrant == 2 ? -c : s;
}

void rounded_sine_cosine(const Real &angle, Real *sine, Real *cosine)
{
    Real lost = unit_roundoff * fabs(angle);
    sine_cosine(angle, sine, cosine);
    if (!(fabs(*sine) > lost))
        *sine = 0;
    if (!(fabs(*cosine) > lost))
        *cosine = 0;
}

Real sine_of(const Real &angle)
{
    Real sine, cosine;
    sine_cosine(angle, &sine, &cosine);
    return sine;
}

Real cosine_of(const Real &angle)
{
    Real sine, cosine;
    sine_cosine(angle, &sine, &cosine);
    return cosine;
}

/* exp(x) = (1 + rise) 2^n */
static long reduced(const Real &x, Real *rise)
{
    Real n = nearest_whole(x / ln_2);
    *rise = small_rise(x - n * ln_2);
    return (long)(double)n;
}

static const double FLAT = 1e8; /* beyond it exp is told as infinite, or zero */

Real exponential(const Real &x)
{
    Real rise;
    long n;
    if (!isfinite(x) || fabs(x) > FLAT)
        return is_no_number(x) ? x : x > 0 ? INFINITY : Real(0);
    n = reduced(x, &rise);
    return scaled(1 + rise, n);
}

Real exponential_less_1(const Real &x)
{
    Real rise;
    long n;
    if (!isfinite(x) || fabs(x) > FLAT)
        return exponential(x) - 1;
    n = reduced(x, &rise);
    return n == 0 ? rise : scaled(rise, n) + (scaled(Real(1), n) - 1);
}

Real hyperbolic_sine(const Real &x)
{
    Real rise = exponential_less_1(fabs(x));
    return isfinite(rise) ? copysign(scaled(rise + rise / (1 + rise), -1), x) : copysign(rise, x);
}

Real hyperbolic_cosine(const Real &x)
{
    Real e = exponential(fabs(x));
    return isfinite(e) ? scaled(e + 1 / e, -1) : e;
}

Real hyperbolic_tangent(const Real &x)
{
    Real rise = exponential_less_1(scaled(fabs(x), 1));
    if (!isfinite(rise))
        return is_no_number(rise) ? rise : copysign(Real(1), x);
    return copysign(rise / (rise + 2), x);
}

/* x - x^3/3 + x^5/5 - ... of |x| < 2^-NEAR, with `sense` -1; with 1 all terms are added. */
static Real odd_series(const Real &x, int sense)
{
    const Real square = x * x;
    Real sum = 0;
    if (square.sign == 0)
        return x;
    for (int k = LIMB_BITS / -square.exponent; k > 0; k--) {
#ifdef WORDS_BY_RUN
        const Precision words((LIMB_BITS + k * square.exponent) / WORD + 2, &sum); /* the rest of a term is below the last word */
#endif
        sum = square * (Real(1) / (2 * k + 1) + (sense < 0 ? -sum : sum));
    }
    return sense < 0 ? x - x * sum : x + x * sum;
}

/* From the angle of doubles: what is left of it by the series of its tangent. */
Real arctangent(const Real &x)
{
    Real angle, sine, cosine, t;
    bool steep = fabs(x) > 1;
    if (is_no_number(x))
        return x;
    if (!isfinite(x))
        return copysign(half_pi, x);
    t = steep ? 1 / fabs(x) : fabs(x);
    if (t.exponent <= -NEAR) {
        angle = odd_series(t, -1);
    } else {
        angle = arctangent((double)t);
        sine_cosine(angle, &sine, &cosine);
        angle = angle + odd_series((t * cosine - sine) / (cosine + t * sine), -1);
    }
    if (steep)
        angle = half_pi - angle;
    return copysign(angle, x);
}

Real arcsine(const Real &x)
{
    Real rest = (1 - x) * (1 + x);
    if (!(rest >= 0))
        return NAN;
    return rest == 0 ? copysign(half_pi, x) : arctangent(x / sqrt(rest));
}

Real arccosine(const Real &x)
{
    if (!(fabs(x) <= 1))
        return NAN;
    return x == -1 ? HALF_TURN : scaled(arctangent(sqrt((1 - x) / (1 + x))), 1);
}

/* ln(x) = y + 2 artanh((c - 1) / (c + 1)), c = x exp(-y), from the logarithm y of doubles; near 1 with y = 0, so that relative errors stay. */
Real logarithm(const Real &x)
{
    Real part, y = 0, away;
    int power;
    if (!(x > 0) || !isfinite(x))
        return x == 0 ? -INFINITY : x > 0 ? x : NAN;
    power = x.exponent;
    part = scaled(x, -(long)power); /* from 1/2 to 1 */
    if (part < ROOT_HALF) {
        part = scaled(part, 1);
        power -= 1;
    }
    away = part - 1;
    if (away.sign != 0 && away.exponent > 1 - NEAR) {
        y = logarithm((double)part);
        part = part * exponential(-y);
        away = part - 1;
    }
    return power * ln_2 + (y + scaled(odd_series(away / (part + 1), 1), 1));
}

/* a**p of a >= 0. */
Real real_power(const Real &a, const Real &p)
{
    Real twice = scaled(p, 1), power;
    int n;
    if (!(a > 0) || !isfinite(a)) {
        if (p == 0 || !(a >= 0))
            return p == 0 ? Real(1) : NAN;
        return is_no_number(p) ? p : (a == 0) == (p > 0) ? Real(0) : INFINITY;
    }
    if (!(fabs(twice) <= 16) || floor(twice) != twice)
        return exponential(p * logarithm(a));
    power = 1;
    n = (int)(double)fabs(twice);
    if (n % 2)
        power = sqrt(a);
    for (n /= 2; n > 0; n--)
        power = power * a;
    return p < 0 ? 1 / power : power;
}
