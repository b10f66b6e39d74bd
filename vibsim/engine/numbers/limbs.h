/* Floating-point numbers of WORDS words of 64 bits, for runs of many digits: the type Real of the engine where it is built for
 * them, in C++. A sum, product or quotient is right to a unit in the last of 64 WORDS bits but for a part in 2^58 of one;
 * exponents go to 2^29. All is done in whole numbers, so bits are the same everywhere.
 *
 * WORDS is LIMBS, a constant. Where WORDS_BY_RUN is defined, LIMBS is the room for words that a number has, and the run in hand
 * says how many of them, the highest, are in use: a number of few digits costs what its words cost.
 */
#ifndef VIBSIM_LIMBS_H
#define VIBSIM_LIMBS_H

#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

/* Numbers may be copied as bytes, and all bytes zero are 0. */
#if !defined(__clang__)
#pragma GCC diagnostic ignored "-Wclass-memaccess"
#elif __has_warning("-Wnontrivial-memcall")
#pragma clang diagnostic ignored "-Wnontrivial-memcall"
#endif

typedef unsigned __int128 Wide;

#define STEP static inline __attribute__((always_inline))

enum { WORD = 64, ENDLESS = INT_MAX, FURTHEST = 1 << 29 }; /* FURTHEST: of exponents */
#ifdef WORDS_BY_RUN
#define UNROLLED
extern constinit thread_local int words_in_use;
#define WORDS words_in_use
#define LIMB_BITS (WORD * words_in_use)
#else
#define UNROLLED _Pragma("GCC unroll 8")
enum { WORDS = LIMBS, LIMB_BITS = WORD * LIMBS };
#endif

/* sign m 2^(exponent - 64 LIMBS), m from its lowest word, whose highest bit is 1; 0: sign 0. Infinite, or no number: exponent
 * ENDLESS and a sign, or none. All bytes zero are 0. Words below those in use may hold anything.
 */
struct Real {
    uint64_t m[LIMBS];
    int32_t exponent, sign;
    Real() = default;
    uint64_t *words() { return m + (LIMBS - WORDS); } /* those in use, from the lowest on */
    const uint64_t *words() const { return m + (LIMBS - WORDS); }
#ifdef WORDS_BY_RUN
    Real(const Real &x) { *this = x; }
    Real &operator=(const Real &x)
    {
        const int unused = LIMBS - WORDS;
        memmove(m + unused, x.m + unused, sizeof *this - sizeof *m * (size_t)unused);
        return *this;
    }
#else
    /* Word by word: what was just written by words is slow to read in vectors. */
    __attribute__((always_inline)) Real(const Real &x) : exponent(x.exponent), sign(x.sign)
    {
        UNROLLED for (int i = 0; i < LIMBS; i++)
            m[i] = x.m[i];
    }
    __attribute__((always_inline)) Real &operator=(const Real &x)
    {
        uint64_t w[LIMBS];
        UNROLLED for (int i = 0; i < LIMBS; i++)
            w[i] = x.m[i];
        UNROLLED for (int i = 0; i < LIMBS; i++)
            m[i] = w[i];
        exponent = x.exponent;
        sign = x.sign;
        return *this;
    }
#endif
    inline Real(double x);
    inline Real(int x) : Real((long long)x) {}
    inline Real(unsigned x) : Real((long long)x) {}
    inline Real(long x) : Real((long long)x) {}
    inline Real(long long x);
    inline explicit operator double() const;
    inline explicit operator long long() const { return (long long)(double)*this; }
    inline explicit operator int() const { return (int)(double)*this; }
    inline explicit operator bool() const { return sign != 0 || exponent == ENDLESS; }
};

static inline Real endless(int sign)
{
    Real x = {};
    x.exponent = ENDLESS;
    x.sign = sign;
    return x;
}

#undef isfinite /* a macro of C where math.h is not that of a C++ library */
static inline bool isfinite(const Real &x) { return x.exponent != ENDLESS; }
static inline bool is_no_number(const Real &x) { return x.exponent == ENDLESS && x.sign == 0; }

inline Real::Real(long long x)
{
    uint64_t size = x < 0 ? 0 - (uint64_t)x : (uint64_t)x;
    int i, lead;
    for (i = LIMBS - WORDS; i < LIMBS; i++)
        m[i] = 0;
    exponent = sign = 0;
    if (x == 0)
        return;
    lead = __builtin_clzll(size);
    m[LIMBS - 1] = size << lead;
    exponent = WORD - lead;
    sign = x < 0 ? -1 : 1;
}

inline Real::Real(double x)
{
    uint64_t bits, fraction;
    int i, power;
    for (i = LIMBS - WORDS; i < LIMBS; i++)
        m[i] = 0;
    exponent = sign = 0;
    memcpy(&bits, &x, sizeof bits);
    power = (int)(bits >> 52 & 0x7ff);
    fraction = bits << 12 >> 1;
    if (power == 0x7ff) {
        exponent = ENDLESS;
        sign = fraction ? 0 : x < 0 ? -1 : 1;
        return;
    }
    if (power == 0) {
        int lead;
        if (fraction == 0)
            return;
        lead = __builtin_clzll(fraction);
        m[LIMBS - 1] = fraction << lead;
        exponent = -1021 - lead;
    } else {
        m[LIMBS - 1] = fraction | 1ULL << 63;
        exponent = power - 1022;
    }
    sign = bits >> 63 ? -1 : 1;
}

inline Real::operator double() const
{
    uint64_t top = m[LIMBS - 1];
    int i;
    if (exponent == ENDLESS)
        return sign == 0 ? __builtin_nan("") : sign * __builtin_inf();
    for (i = LIMBS - WORDS; i < LIMBS - 1; i++)
        top |= m[i] != 0; /* decides where the rest would be half a unit */
    if (sign == 0)
        return 0.0;
    if (exponent > -900 && exponent < 1000) {
        uint64_t bits = (uint64_t)(exponent - WORD + 1023) << 52;
        double power;
        memcpy(&power, &bits, sizeof power);
        return sign * ((double)top * power);
    }
    return sign * ldexp((double)top, exponent < 0 ? (exponent < -20000 ? -20000 : exponent - WORD) : (exponent > 20000 ? 20000 : exponent - WORD));
}

/* Order of the sizes of finite numbers. */
static inline int compare_sizes(const Real &a, const Real &b)
{
    int i;
    if (a.sign == 0 || b.sign == 0)
        return (a.sign != 0) - (b.sign != 0);
    if (a.exponent != b.exponent)
        return a.exponent < b.exponent ? -1 : 1;
    for (i = LIMBS - 1; i >= LIMBS - WORDS; i--)
        if (a.m[i] != b.m[i])
            return a.m[i] < b.m[i] ? -1 : 1;
    return 0;
}

/* -1, 0, 1; 2 where one is no number. */
static inline int compare(const Real &a, const Real &b)
{
    if (is_no_number(a) || is_no_number(b))
        return 2;
    if (a.sign != b.sign)
        return a.sign < b.sign ? -1 : 1;
    if (a.exponent == ENDLESS && b.exponent == ENDLESS)
        return 0;
    return a.sign < 0 ? compare_sizes(b, a) : compare_sizes(a, b);
}

static inline bool operator<(const Real &a, const Real &b) { return compare(a, b) == -1; }
static inline bool operator>(const Real &a, const Real &b) { return compare(a, b) == 1; }
static inline bool operator<=(const Real &a, const Real &b) { return compare(a, b) <= 0; }
static inline bool operator>=(const Real &a, const Real &b) { int c = compare(a, b); return c == 0 || c == 1; }
static inline bool operator==(const Real &a, const Real &b) { return compare(a, b) == 0; }
static inline bool operator!=(const Real &a, const Real &b) { return compare(a, b) != 0; }
static inline bool operator<(const Real &a, int b) { return b == 0 ? a.sign < 0 : a < Real(b); }
static inline bool operator>(const Real &a, int b) { return b == 0 ? a.sign > 0 : a > Real(b); }
static inline bool operator==(const Real &a, int b) { return b == 0 ? a.sign == 0 && a.exponent != ENDLESS : a == Real(b); }
static inline bool operator!=(const Real &a, int b) { return !(a == b); }

static inline Real operator-(const Real &a)
{
    Real x = a;
    x.sign = -x.sign;
    return x;
}

static inline Real fabs(const Real &a)
{
    Real x = a;
    x.sign = x.sign < 0 ? 1 : x.sign;
    return x;
}

Real added(const Real &a, const Real &b, int flip); /* a + b, b times `flip` */
Real operator*(const Real &a, const Real &b);
Real operator*(const Real &a, int n); /* n of one word */
Real operator/(const Real &a, const Real &b);
Real operator/(const Real &a, int n);
Real floor(const Real &x); /* the largest whole number not above x */
Real sqrt(const Real &x);

static inline Real operator+(const Real &a, const Real &b) { return added(a, b, 1); }
static inline Real operator-(const Real &a, const Real &b) { return added(a, b, -1); }

static inline Real operator*(int n, const Real &a) { return a * n; }

#define MIXED(op, type)                                                                  \
    static inline Real operator op(const Real &a, type b) { return a op Real(b); }       \
    static inline Real operator op(type a, const Real &b) { return Real(a) op b; }
#define MIXED_TESTS(op, type)                                                            \
    static inline bool operator op(const Real &a, type b) { return a op Real(b); }       \
    static inline bool operator op(type a, const Real &b) { return Real(a) op b; }
MIXED(+, double)
MIXED(-, double)
MIXED(*, double)
MIXED(/, double)
MIXED(+, int)
MIXED(-, int)
static inline Real operator/(int a, const Real &b) { return Real(a) / b; }
MIXED_TESTS(<, double)
MIXED_TESTS(>, double)
MIXED_TESTS(<=, double)
MIXED_TESTS(>=, double)
MIXED_TESTS(==, double)
MIXED_TESTS(!=, double)
static inline bool operator<=(const Real &a, int b) { return b == 0 ? a.sign <= 0 && !is_no_number(a) : a <= Real(b); }
static inline bool operator>=(const Real &a, int b) { return b == 0 ? a.sign >= 0 && !is_no_number(a) : a >= Real(b); }
static inline bool operator<(int a, const Real &b) { return b > a; }
static inline bool operator>(int a, const Real &b) { return b < a; }
static inline bool operator<=(int a, const Real &b) { return b >= a; }
static inline bool operator>=(int a, const Real &b) { return b <= a; }
static inline bool operator==(int a, const Real &b) { return b == a; }
#undef MIXED
#undef MIXED_TESTS

static inline Real &operator+=(Real &a, const Real &b) { return a = a + b; }
static inline Real &operator-=(Real &a, const Real &b) { return a = a - b; }
static inline Real &operator*=(Real &a, const Real &b) { return a = a * b; }

/* x 2^n */
static inline Real scaled(const Real &x, long n)
{
    Real y = x;
    if (y.sign != 0 && y.exponent != ENDLESS)
        y.exponent = (int32_t)(y.exponent + n);
    return y;
}

static inline Real copysign(const Real &size, const Real &sign)
{
    Real x = fabs(size);
    return sign.sign < 0 ? -x : x;
}

#endif
