/* Floating-point numbers of LIMBS words of 64 bits, for runs of many digits: the type Real of the engine where it is built for
 * them, in C++. A sum, product or quotient is right to half a unit in the last of 64 LIMBS bits but for a part in 2^60 of one;
 * exponents go to 2^29. All is done in whole numbers, so bits are the same everywhere.
 *
 * Quotients: Knuth, The Art of Computer Programming 2 (1998), 4.3.1, algorithm D. Sums with a guard word: Goldberg (1991), What every
 * computer scientist should know about floating-point arithmetic.
 */
#ifndef VIBSIM_LIMBS_H
#define VIBSIM_LIMBS_H

#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

typedef unsigned __int128 Wide;

#define UNROLLED _Pragma("GCC unroll 8")
#define STEP static inline __attribute__((always_inline))
#define HEAVY __attribute__((noinline)) inline /* once in the program, whoever calls */

enum { WORD = 64, LIMB_BITS = WORD * LIMBS, ENDLESS = INT_MAX, FURTHEST = 1 << 29 }; /* FURTHEST: of exponents */

/* sign m 2^(exponent - LIMB_BITS), m from its lowest word, whose highest bit is 1; 0: sign 0. Infinite, or no number: exponent
 * ENDLESS and a sign, or none. All bytes zero are 0.
 */
struct Real {
    uint64_t m[LIMBS];
    int32_t exponent, sign;
    Real() = default;
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

/* The value without sign of words that need not begin with a 1, rounded to LIMBS of them: `count` > LIMBS, lowest first. */
HEAVY Real normal(uint64_t *w, int count, long exponent, int sign)
{
    Real x;
    int lead, i, top = count - 1;
    while (top >= 0 && w[top] == 0)
        top--;
    if (top < 0)
        return Real{};
    exponent -= (long)WORD * (count - 1 - top);
    lead = __builtin_clzll(w[top]);
    exponent -= lead;
    if (exponent > FURTHEST)
        return endless(sign);
    if (exponent < -FURTHEST)
        return Real{};
    for (i = 0; i < LIMBS; i++) {
        int from = top - (LIMBS - 1) + i;
        uint64_t high = from >= 0 ? w[from] : 0, low = from >= 1 ? w[from - 1] : 0;
        x.m[i] = lead ? high << lead | low >> (WORD - lead) : high;
    }
    {
        int below = top - LIMBS;
        uint64_t rest = below >= 0 ? w[below] << lead : 0;
        if (lead && below >= 1)
            rest |= w[below - 1] >> (WORD - lead);
        if (rest >> 63) {
            for (i = 0; i < LIMBS && ++x.m[i] == 0; i++)
                ;
            if (i == LIMBS) {
                x.m[LIMBS - 1] = 1ULL << 63;
                exponent += 1;
            }
        }
    }
    x.exponent = (int32_t)exponent;
    x.sign = sign;
    return x;
}

inline Real::Real(long long x)
{
    uint64_t size = x < 0 ? 0 - (uint64_t)x : (uint64_t)x;
    int i, lead;
    for (i = 0; i < LIMBS; i++)
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
    for (i = 0; i < LIMBS; i++)
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
    for (i = 0; i < LIMBS - 1; i++)
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
    for (i = LIMBS - 1; i >= 0; i--)
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

/* The words m rounded by the first bit of what is behind them. */
STEP void round_by(Real *x, uint64_t rest)
{
    unsigned char up = rest >> 63;
    int i;
    UNROLLED for (i = 0; i < LIMBS; i++)
        up = __builtin_add_overflow(x->m[i], (uint64_t)up, &x->m[i]);
    if (__builtin_expect(up, 0)) {
        x->m[LIMBS - 1] = 1ULL << 63;
        x->exponent += 1;
    }
}

/* Sums of what is zero or endless. */
HEAVY Real special_sum(const Real &a, const Real &b, int flip)
{
    Real only = b;
    only.sign = b.sign * flip;
    if (a.exponent != ENDLESS && b.exponent != ENDLESS)
        return only.sign == 0 ? a : only;
    if (is_no_number(a) || is_no_number(b))
        return NAN;
    if (a.exponent != ENDLESS)
        return only;
    return b.exponent != ENDLESS || a.sign == only.sign ? a : Real(NAN);
}

/* a + b, b times `flip`. */
HEAVY Real added(const Real &a, const Real &b, int flip)
{
    uint64_t big[LIMBS + 1], small[LIMBS + 1], shifted[2 * LIMBS + 2] = {0};
    const Real *x = &a, *y = &b;
    int sign = a.sign, i, words, bits;
    const int alike = sign == b.sign * flip;
    long apart;
    Real sum;
    unsigned char carry = 0;
    if (__builtin_expect(a.sign == 0 || b.sign == 0 || a.exponent == ENDLESS || b.exponent == ENDLESS, 0))
        return special_sum(a, b, flip);
    if (a.exponent < b.exponent || (!alike && a.exponent == b.exponent && compare_sizes(a, b) < 0)) {
        x = &b;
        y = &a;
        sign = b.sign * flip;
    }
    apart = (long)x->exponent - y->exponent;
    if (apart > LIMB_BITS) {
        sum = *x;
        sum.sign = sign;
        return sum;
    }
    words = (int)(apart / WORD);
    bits = (int)(apart % WORD);
    UNROLLED for (i = 0; i < LIMBS; i++)
        shifted[i + 1] = y->m[i];
    UNROLLED for (i = 0; i < LIMBS + 1; i++) /* y below x, with a guard word */
        small[i] = shifted[i + words] >> bits | shifted[i + words + 1] << 1 << (WORD - 1 - bits);
    big[0] = 0;
    UNROLLED for (i = 0; i < LIMBS; i++)
        big[i + 1] = x->m[i];
    sum.sign = sign;
    sum.exponent = x->exponent;
    if (alike) {
        UNROLLED for (i = 0; i < LIMBS + 1; i++) {
            unsigned char over = __builtin_add_overflow(big[i], small[i], &big[i]);
            carry = over | __builtin_add_overflow(big[i], (uint64_t)carry, &big[i]);
        }
        UNROLLED for (i = 0; i < LIMBS; i++)
            sum.m[i] = big[i + 1];
        if (carry) {
            uint64_t rest = sum.m[0] << 63;
            UNROLLED for (i = 0; i < LIMBS - 1; i++)
                sum.m[i] = sum.m[i] >> 1 | sum.m[i + 1] << 63;
            sum.m[LIMBS - 1] = sum.m[LIMBS - 1] >> 1 | 1ULL << 63;
            sum.exponent += 1;
            round_by(&sum, rest);
        } else {
            round_by(&sum, big[0]);
        }
        return sum;
    }
    UNROLLED for (i = 0; i < LIMBS + 1; i++) {
        unsigned char under = __builtin_sub_overflow(big[i], small[i], &big[i]);
        carry = under | __builtin_sub_overflow(big[i], (uint64_t)carry, &big[i]);
    }
    if (__builtin_expect(big[LIMBS] == 0, 0))
        return normal(big, LIMBS + 1, sum.exponent, sign);
    bits = __builtin_clzll(big[LIMBS]);
    UNROLLED for (i = 0; i < LIMBS; i++)
        sum.m[i] = big[i + 1] << bits | big[i] >> 1 >> (WORD - 1 - bits);
    sum.exponent -= bits;
    round_by(&sum, big[0] << bits);
    return sum;
}

static inline Real operator+(const Real &a, const Real &b) { return added(a, b, 1); }
static inline Real operator-(const Real &a, const Real &b) { return added(a, b, -1); }

HEAVY Real operator*(const Real &a, const Real &b)
{
    uint64_t w[2 * LIMBS] = {0};
    Real x;
    int i, j, lead;
    if (__builtin_expect(a.sign == 0 || b.sign == 0 || a.exponent == ENDLESS || b.exponent == ENDLESS, 0))
        return a.exponent == ENDLESS || b.exponent == ENDLESS ? endless(a.sign * b.sign) : Real{};
    UNROLLED for (i = 0; i < LIMBS; i++) {
        uint64_t carry = 0;
        UNROLLED for (j = 0; j < LIMBS; j++) {
            Wide product = (Wide)a.m[i] * b.m[j] + w[i + j] + carry;
            w[i + j] = (uint64_t)product;
            carry = (uint64_t)(product >> 64);
        }
        w[i + LIMBS] = carry;
    }
    x.sign = a.sign * b.sign;
    lead = !(w[2 * LIMBS - 1] >> 63);
    x.exponent = a.exponent + b.exponent - lead;
    UNROLLED for (i = 0; i < LIMBS; i++)
        x.m[i] = w[i + LIMBS] << lead | (w[i + LIMBS - 1] >> 63 & (uint64_t)lead);
    round_by(&x, w[LIMBS - 1] << lead);
    if (__builtin_expect(x.exponent > FURTHEST || x.exponent < -FURTHEST, 0))
        return x.exponent > 0 ? endless(x.sign) : Real{};
    return x;
}

/* By a whole number of one word. */
HEAVY Real operator*(const Real &a, int n)
{
    uint64_t w[LIMBS + 1], size = n < 0 ? 0 - (uint64_t)n : (uint64_t)n, carry = 0;
    int i;
    if (a.exponent == ENDLESS)
        return endless(n == 0 ? 0 : n < 0 ? -a.sign : a.sign);
    if (a.sign == 0 || n == 0)
        return Real{};
    for (i = 0; i < LIMBS; i++) {
        Wide product = (Wide)a.m[i] * size + carry;
        w[i] = (uint64_t)product;
        carry = (uint64_t)(product >> 64);
    }
    w[LIMBS] = carry;
    return normal(w, LIMBS + 1, (long)a.exponent + WORD, n < 0 ? -a.sign : a.sign);
}

static inline Real operator*(int n, const Real &a) { return a * n; }

/* Quotient of finite numbers that are not zero, by schoolbook division of words. */
HEAVY Real divided(const Real &a, const Real &b)
{
    enum { QUOTIENT = LIMBS + 1, NUMERATOR = 2 * LIMBS + 1 };
    uint64_t u[NUMERATOR + 1] = {0}, q[QUOTIENT] = {0};
    const uint64_t lead = b.m[LIMBS - 1], next = LIMBS > 1 ? b.m[LIMBS - 2] : 0;
    int i, j;
    for (i = 0; i < LIMBS; i++) /* half of a, below b */
        u[LIMBS + 1 + i] = a.m[i] >> 1 | (i + 1 < LIMBS ? a.m[i + 1] << 63 : 0);
    u[LIMBS] = a.m[0] << 63;
    for (j = LIMBS; j >= 0; j--) {
        Wide top = (Wide)u[j + LIMBS] << 64 | u[j + LIMBS - 1], guess, rest;
        uint64_t carry = 0, borrow = 0;
        if (u[j + LIMBS] >= lead) {
            guess = ~(uint64_t)0;
            rest = top - guess * lead;
        } else {
            guess = top / lead;
            rest = top % lead;
        }
        while (rest >> 64 == 0 && guess * next > (rest << 64 | u[j + LIMBS - 2])) {
            guess -= 1;
            rest += lead;
        }
        for (i = 0; i < LIMBS; i++) {
            Wide product = (Wide)(uint64_t)guess * b.m[i] + carry, left = (Wide)u[i + j] - (uint64_t)product - borrow;
            carry = (uint64_t)(product >> 64);
            u[i + j] = (uint64_t)left;
            borrow = (uint64_t)(left >> 64) & 1;
        }
        {
            Wide left = (Wide)u[j + LIMBS] - carry - borrow;
            u[j + LIMBS] = (uint64_t)left;
            borrow = (uint64_t)(left >> 64) & 1;
        }
        if (borrow) {
            uint64_t over = 0;
            guess -= 1;
            for (i = 0; i < LIMBS; i++) {
                Wide sum = (Wide)u[i + j] + b.m[i] + over;
                u[i + j] = (uint64_t)sum;
                over = (uint64_t)(sum >> 64);
            }
            u[j + LIMBS] += over;
        }
        q[j] = (uint64_t)guess;
    }
    return normal(q, QUOTIENT, (long)a.exponent - b.exponent + 1, a.sign * b.sign);
}

static inline Real operator/(const Real &a, const Real &b)
{
    if (is_no_number(a) || is_no_number(b) || (a.sign == 0 && b.sign == 0))
        return NAN;
    if (a.exponent == ENDLESS)
        return b.exponent == ENDLESS ? NAN : endless(b.sign < 0 ? -a.sign : a.sign);
    if (b.sign == 0)
        return endless(a.sign);
    if (b.exponent == ENDLESS || a.sign == 0)
        return Real{};
    return divided(a, b);
}

/* By a whole number from 1 on: of one word, so that halves are exact and cheap. */
HEAVY Real operator/(const Real &a, int n)
{
    uint64_t w[LIMBS + 1];
    Wide rest = 0;
    int i;
    if (n < 1 || a.exponent == ENDLESS || a.sign == 0)
        return a / Real(n);
    for (i = LIMBS; i >= 0; i--) {
        Wide part = rest << 64 | (i > 0 ? a.m[i - 1] : 0);
        w[i] = (uint64_t)(part / (unsigned)n);
        rest = part % (unsigned)n;
    }
    return normal(w, LIMBS + 1, a.exponent, a.sign);
}

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

/* The largest whole number not above x. */
HEAVY Real floor(const Real &x)
{
    Real whole = x;
    int below = LIMB_BITS - x.exponent, i; /* bits behind the point */
    if (x.sign == 0 || x.exponent == ENDLESS || below <= 0)
        return x;
    if (x.exponent <= 0)
        return x.sign < 0 ? Real(-1) : Real{};
    for (i = 0; i < below / WORD; i++)
        whole.m[i] = 0;
    whole.m[i] = whole.m[i] >> below % WORD << below % WORD;
    return x.sign < 0 && compare_sizes(whole, x) != 0 ? whole - 1 : whole;
}

HEAVY Real sqrt(const Real &x)
{
    Real part, inverse, root;
    int odd, bits;
    if (x.sign <= 0 || x.exponent == ENDLESS)
        return x.sign < 0 ? NAN : x;
    odd = x.exponent & 1;
    part = x;
    part.exponent = odd; /* from 1/2 to 2 */
    inverse = Real(1 / sqrt((double)part));
    for (bits = 50; bits < LIMB_BITS / 2; bits *= 2)
        inverse = inverse + scaled(inverse * (1 - part * (inverse * inverse)), -1);
    root = part * inverse;
    root = root + scaled(inverse * (part - root * root), -1);
    return scaled(root, ((long)x.exponent - odd) / 2);
}

/* total + word, or total - word where `flip` is all ones: COUNT words from the lowest on, and what is carried above them. */
template <int COUNT> STEP void accumulate(uint64_t *total, const uint64_t *word, uint64_t flip)
{
#if defined(__x86_64__)
    uint64_t carry = flip, a = word[0] ^ flip, b = word[1] ^ flip, c, d, e;
    if constexpr (COUNT == 2) {
        __asm__("addq %[carry], %[carry]\n\tadcq %[a], %[s]\n\tadcq %[b], %[t]\n\tadcq %[flip], %[u]"
                : [carry] "+&r"(carry), [s] "+&r"(total[0]), [t] "+&r"(total[1]), [u] "+&r"(total[2])
                : [a] "r"(a), [b] "r"(b), [flip] "r"(flip)
                : "cc");
        return;
    }
    if constexpr (COUNT == 3) {
        c = word[2] ^ flip;
        __asm__("addq %[carry], %[carry]\n\tadcq %[a], %[s]\n\tadcq %[b], %[t]\n\tadcq %[c], %[u]\n\tadcq %[flip], %[v]"
                : [carry] "+&r"(carry), [s] "+&r"(total[0]), [t] "+&r"(total[1]), [u] "+&r"(total[2]), [v] "+&r"(total[3])
                : [a] "r"(a), [b] "r"(b), [c] "r"(c), [flip] "r"(flip)
                : "cc");
        return;
    }
    if constexpr (COUNT == 4) {
        c = word[2] ^ flip;
        d = word[3] ^ flip;
        __asm__("addq %[carry], %[carry]\n\tadcq %[a], %[s]\n\tadcq %[b], %[t]\n\tadcq %[c], %[u]\n\tadcq %[d], %[v]\n\t"
                "adcq %[flip], %[x]"
                : [carry] "+&r"(carry), [s] "+m"(total[0]), [t] "+m"(total[1]), [u] "+m"(total[2]), [v] "+m"(total[3]), [x] "+m"(total[4])
                : [a] "r"(a), [b] "r"(b), [c] "r"(c), [d] "r"(d), [flip] "r"(flip)
                : "cc");
        return;
    }
    if constexpr (COUNT == 5) {
        c = word[2] ^ flip;
        d = word[3] ^ flip;
        e = word[4] ^ flip;
        __asm__("addq %[carry], %[carry]\n\tadcq %[a], %[s]\n\tadcq %[b], %[t]\n\tadcq %[c], %[u]\n\tadcq %[d], %[v]\n\t"
                "adcq %[e], %[w]\n\tadcq %[flip], %[x]"
                : [carry] "+&r"(carry), [s] "+m"(total[0]), [t] "+m"(total[1]), [u] "+m"(total[2]), [v] "+m"(total[3]),
                  [w] "+m"(total[4]), [x] "+m"(total[5])
                : [a] "r"(a), [b] "r"(b), [c] "r"(c), [d] "r"(d), [e] "r"(e), [flip] "r"(flip)
                : "cc");
        return;
    }
#endif
    unsigned char over = flip & 1;
    for (int j = 0; j <= COUNT; j++) {
        unsigned char more = __builtin_add_overflow(total[j], j < COUNT ? word[j] ^ flip : flip, &total[j]);
        over = more | __builtin_add_overflow(total[j], (uint64_t)over, &total[j]);
    }
}

/* `sum_of_products` of the highest WORDS words of each factor. */
template <int WORDS> Real leading_products(const Real *a, const Real *b, int count, long *largest)
{
    enum { KEPT = WORDS + 1, LOW = LIMBS - WORDS };
    uint64_t total[KEPT + 1] = {0}, w[WORDS - 1 + 2 * KEPT + 1] = {0};
    int i, j, k;
    *largest = LONG_MIN;
    for (i = 0; i < count; i++) {
        long exponent = (long)a[i].exponent + b[i].exponent;
        if (__builtin_expect(a[i].exponent == ENDLESS || b[i].exponent == ENDLESS, 0))
            return NAN;
        exponent = a[i].sign != 0 && b[i].sign != 0 ? exponent : LONG_MIN;
        *largest = exponent > *largest ? exponent : *largest;
    }
    for (i = 0; i < count; i++) {
        const long below = *largest - ((long)a[i].exponent + b[i].exponent);
        const uint64_t flip = (uint64_t)((long)(a[i].sign ^ b[i].sign) >> 63); /* all ones where the signs differ */
        uint64_t word[KEPT];
        const uint64_t *from;
        int bits;
        if (a[i].sign == 0 || b[i].sign == 0 || below >= (long)WORD * KEPT)
            continue;
        UNROLLED for (j = 0; j < WORDS; j++) {
            uint64_t over = 0;
            UNROLLED for (k = 0; k < WORDS; k++) {
                Wide product = (Wide)a[i].m[LOW + j] * b[i].m[LOW + k] + (j ? w[j + k] : 0) + over;
                w[j + k] = (uint64_t)product;
                over = (uint64_t)(product >> 64);
            }
            w[j + WORDS] = over;
        }
        from = w + WORDS - 1 + below / WORD; /* zeros stand above the product */
        bits = (int)(below % WORD);
        UNROLLED for (j = 0; j < KEPT; j++)
            word[j] = from[j] >> bits | from[j + 1] << 1 << (WORD - 1 - bits);
        accumulate<KEPT>(total, word, flip);
    }
    i = total[KEPT] >> 63 ? -1 : 1;
    if (i < 0) {
        unsigned char carry = 1;
        for (j = 0; j < KEPT + 1; j++)
            carry = __builtin_add_overflow(~total[j], (uint64_t)carry, &total[j]);
    }
    return *largest == LONG_MIN ? Real{} : normal(total, KEPT + 1, *largest + WORD, i);
}

/* Sum of a[i] b[i], i from 0 below count, in whole numbers that begin where the largest product does, at the binary exponent
 * `largest`, and end a word below the last one of `words` words; rounded once.
 */
HEAVY Real sum_of_products(const Real *a, const Real *b, int count, int words, long *largest)
{
    switch (words) {
    case 1: return leading_products<1>(a, b, count, largest);
    case 2: return leading_products<2>(a, b, count, largest);
#if LIMBS > 2
    case 3: return leading_products<3>(a, b, count, largest);
#endif
    default: return leading_products<LIMBS>(a, b, count, largest);
    }
}

static inline Real copysign(const Real &size, const Real &sign)
{
    Real x = fabs(size);
    return sign.sign < 0 ? -x : x;
}

#endif
