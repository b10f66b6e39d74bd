/* The operations of numbers of WORDS words; limbs.h says how right they are.
 *
 * Quotients: Knuth, The Art of Computer Programming 2 (1998), 4.3.1, algorithm D. Sums with a guard word: Goldberg (1991), What every
 * computer scientist should know about floating-point arithmetic.
 */
#ifndef __clang__
#pragma GCC optimize("O2") /* few functions, of which most of the time of a run is made */
#endif
#include "words.h"

/* The value without sign of words that need not begin with a 1, rounded to WORDS of them: `count` > WORDS, lowest first. */
Real normal(uint64_t *w, int count, long exponent, int sign)
{
    const int words = WORDS;
    Real x;
    uint64_t *const m = x.words();
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
    for (i = 0; i < words; i++) {
        int from = top - (words - 1) + i;
        uint64_t high = from >= 0 ? w[from] : 0, low = from >= 1 ? w[from - 1] : 0;
        m[i] = lead ? high << lead | low >> (WORD - lead) : high;
    }
    {
        int below = top - words;
        uint64_t rest = below >= 0 ? w[below] << lead : 0;
        if (lead && below >= 1)
            rest |= w[below - 1] >> (WORD - lead);
        if (rest >> 63) {
            for (i = 0; i < words && ++m[i] == 0; i++)
                ;
            if (i == words) {
                m[words - 1] = 1ULL << 63;
                exponent += 1;
            }
        }
    }
    x.exponent = (int32_t)exponent;
    x.sign = sign;
    return x;
}

/* Sums of what is zero or endless. */
static Real special_sum(const Real &a, const Real &b, int flip)
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

/* a + b, b times `flip`, where the smaller one begins a word or more below the larger; both finite and not zero. */
static Real far_sum(const Real &a, const Real &b, int flip)
{
    const bool behind = a.exponent < b.exponent;
    const Real &x = behind ? b : a, &y = behind ? a : b;
    const long apart = (long)x.exponent - y.exponent, words = apart / WORD, bits = apart % WORD;
    const int sign = behind ? b.sign * flip : a.sign, alike = a.sign == b.sign * flip, count = WORDS;
    const uint64_t *const larger = x.words(), *const smaller = y.words();
    uint64_t sum[LIMBS + 2], small[LIMBS + 1];
    unsigned char carry = 0;
    int i;
    if (apart > LIMB_BITS) {
        Real only = x;
        only.sign = sign;
        return only;
    }
    sum[0] = sum[count + 1] = 0;
    for (i = 0; i < count; i++)
        sum[i + 1] = larger[i];
    for (i = 0; i + words < count + 1; i++) {
        uint64_t low = i + words > 0 ? smaller[i + words - 1] : 0, high = i + words < count ? smaller[i + words] : 0;
        small[i] = bits ? low >> bits | high << (WORD - bits) : low;
    }
    for (; i < count + 1; i++)
        small[i] = 0;
    for (i = 0; i < count + 2; i++) {
        uint64_t part = i < count + 1 ? small[i] : 0;
        unsigned char over = alike ? __builtin_add_overflow(sum[i], part, &sum[i]) : __builtin_sub_overflow(sum[i], part, &sum[i]);
        carry = over | (alike ? __builtin_add_overflow(sum[i], (uint64_t)carry, &sum[i])
                              : __builtin_sub_overflow(sum[i], (uint64_t)carry, &sum[i]));
    }
    return normal(sum, count + 2, (long)x.exponent + WORD, sign);
}

/* a + b, b times `flip`. */
Real added(const Real &a, const Real &b, int flip)
{
    const long ahead = (long)a.exponent - b.exponent, apart = ahead < 0 ? -ahead : ahead;
    const int other = b.sign * flip, words = WORDS;
    const Real *x = ahead < 0 ? &b : &a, *y = ahead < 0 ? &a : &b;
    const uint64_t *const larger = x->words(), *const smaller = y->words();
    uint64_t w[LIMBS + 1], small[LIMBS + 1];
    Real sum;
    uint64_t *const m = sum.words();
    int i, bits;
    if (__builtin_expect(a.sign == 0 || b.sign == 0 || a.exponent == ENDLESS || b.exponent == ENDLESS, 0))
        return special_sum(a, b, flip);
    if (__builtin_expect(apart >= WORD, 0))
        return far_sum(a, b, flip);
    sum.exponent = x->exponent;
    sum.sign = ahead < 0 ? other : a.sign;
    bits = (int)apart;
    UNROLLED for (i = 0; i < words - 1; i++)
        small[i + 1] = smaller[i] >> bits | smaller[i + 1] << 1 << (WORD - 1 - bits);
    small[words] = smaller[words - 1] >> bits;
    UNROLLED for (i = 0; i < words; i++)
        w[i + 1] = larger[i];
    if (a.sign == other) {
        const uint64_t over = ADD_WORDS(WORDS, w + 1, small + 1);
        UNROLLED for (i = 0; i < words - 1; i++)
            m[i] = w[i + 1] >> over | w[i + 2] << 1 << (WORD - 1 - (int)over);
        m[words - 1] = w[words] >> over | over << (WORD - 1);
        sum.exponent += (int32_t)over;
        return sum;
    }
    w[0] = 0;
    small[0] = smaller[0] << 1 << (WORD - 1 - bits);
    if (SUBTRACT_WORDS(WORDS + 1, w, small)) { /* of one exponent, and y is the larger: what stands there less 2^LIMB_BITS */
        UNROLLED for (i = 0; i < words + 1; i++)
            small[i] = w[i];
        UNROLLED for (i = 0; i < words + 1; i++)
            w[i] = 0;
        SUBTRACT_WORDS(WORDS + 1, w, small);
        sum.sign = -sum.sign;
    }
    if (__builtin_expect(w[words] == 0, 0))
        return normal(w, words + 1, sum.exponent, sum.sign);
    bits = __builtin_clzll(w[words]);
    UNROLLED for (i = 0; i < words; i++)
        m[i] = w[i + 1] << bits | w[i] >> 1 >> (WORD - 1 - bits);
    sum.exponent -= bits;
    return sum;
}

Real operator*(const Real &a, const Real &b)
{
    const int words = WORDS;
    uint64_t w[LIMBS + 1];
    Real x;
    uint64_t *const m = x.words();
    int i, lead;
    if (__builtin_expect(a.sign == 0 || b.sign == 0 || a.exponent == ENDLESS || b.exponent == ENDLESS, 0))
        return a.exponent == ENDLESS || b.exponent == ENDLESS ? endless(a.sign * b.sign) : Real{};
    multiply_words(a.words(), b.words(), w);
    x.sign = a.sign * b.sign;
    lead = !(w[words] >> (WORD - 1));
    x.exponent = a.exponent + b.exponent - lead;
    UNROLLED for (i = 0; i < words; i++)
        m[i] = w[i + 1] << lead | (w[i] >> (WORD - 1) & (uint64_t)lead);
    if (__builtin_expect(x.exponent > FURTHEST || x.exponent < -FURTHEST, 0))
        return x.exponent > 0 ? endless(x.sign) : Real{};
    return x;
}

/* By a whole number of one word. */
Real operator*(const Real &a, int n)
{
    const uint64_t size = n < 0 ? 0 - (uint64_t)n : (uint64_t)n;
    const uint64_t *const factor = a.words();
    const int words = WORDS;
    uint64_t w[LIMBS + 1], over = 0;
    Real x;
    uint64_t *const m = x.words();
    int i, lead;
    if (a.exponent == ENDLESS)
        return endless(n == 0 ? 0 : n < 0 ? -a.sign : a.sign);
    if (a.sign == 0 || n == 0)
        return Real{};
    UNROLLED for (i = 0; i < words; i++) {
        Wide product = (Wide)factor[i] * size + over;
        w[i] = (uint64_t)product;
        over = (uint64_t)(product >> WORD);
    }
    w[words] = over;
    lead = over ? __builtin_clzll(over) : WORD; /* n = 1 alone leaves nothing there, and then all is there already */
    if (lead == WORD)
        return n < 0 ? -a : a;
    UNROLLED for (i = 0; i < words; i++)
        m[i] = w[i + 1] << lead | w[i] >> 1 >> (WORD - 1 - lead);
    x.exponent = a.exponent + WORD - lead;
    x.sign = n < 0 ? -a.sign : a.sign;
    return x.exponent > FURTHEST ? endless(x.sign) : x;
}

/* Quotient of finite numbers that are not zero, by schoolbook division of words. */
static Real divided(const Real &a, const Real &b)
{
    enum { QUOTIENT = LIMBS + 1, NUMERATOR = 2 * LIMBS + 1 };
    const int words = WORDS;
    const uint64_t *const numerator = a.words(), *const divisor = b.words();
    uint64_t u[NUMERATOR + 1], q[QUOTIENT];
    const uint64_t lead = divisor[words - 1], next = divisor[words - 2];
    int i, j;
    memset(u, 0, sizeof *u * (size_t)(2 * words + 2));
    for (i = 0; i < words; i++) /* half of a, below b */
        u[words + 1 + i] = numerator[i] >> 1 | (i + 1 < words ? numerator[i + 1] << 63 : 0);
    u[words] = numerator[0] << 63;
    for (j = words; j >= 0; j--) {
        Wide top = (Wide)u[j + words] << 64 | u[j + words - 1], guess, rest;
        uint64_t carry = 0, borrow = 0;
        if (u[j + words] >= lead) {
            guess = ~(uint64_t)0;
            rest = top - guess * lead;
        } else {
            guess = top / lead;
            rest = top % lead;
        }
        while (rest >> 64 == 0 && guess * next > (rest << 64 | u[j + words - 2])) {
            guess -= 1;
            rest += lead;
        }
        for (i = 0; i < words; i++) {
            Wide product = (Wide)(uint64_t)guess * divisor[i] + carry, left = (Wide)u[i + j] - (uint64_t)product - borrow;
            carry = (uint64_t)(product >> 64);
            u[i + j] = (uint64_t)left;
            borrow = (uint64_t)(left >> 64) & 1;
        }
        {
            Wide left = (Wide)u[j + words] - carry - borrow;
            u[j + words] = (uint64_t)left;
            borrow = (uint64_t)(left >> 64) & 1;
        }
        if (borrow) {
            uint64_t over = 0;
            guess -= 1;
            for (i = 0; i < words; i++) {
                Wide sum = (Wide)u[i + j] + divisor[i] + over;
                u[i + j] = (uint64_t)sum;
                over = (uint64_t)(sum >> 64);
            }
            u[j + words] += over;
        }
        q[j] = (uint64_t)guess;
    }
    return normal(q, words + 1, (long)a.exponent - b.exponent + 1, a.sign * b.sign);
}

Real operator/(const Real &a, const Real &b)
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

/* By a whole number from 1 on: of one word, so that halves are exact and cheap. Quotients of two words by one, its highest bit 1, by
 * its inverse 2^64 + `inverse` (Moeller and Granlund 2011, Improved division by invariant integers, algorithm 4): some ten times as fast
 * as a division of 128 bits.
 */
Real operator/(const Real &a, int n)
{
    const uint64_t *const numerator = a.words();
    const int words = WORDS;
    uint64_t w[LIMBS + 1];
    int i;
    if (n < 1 || a.exponent == ENDLESS || a.sign == 0)
        return a / Real(n);
    const int lead = __builtin_clzll((uint64_t)n);
    const uint64_t divisor = (uint64_t)n << lead, inverse = (uint64_t)((((Wide)~divisor << WORD) | ~(uint64_t)0) / divisor);
    uint64_t rest = numerator[words - 1] >> 1 >> (WORD - 1 - lead), next = numerator[words - 1];
    for (i = words; i >= 0; i--) { /* the numerator and a word of zeros below it, both times 2^lead */
        const uint64_t following = i > 1 ? numerator[i - 2] : 0, low = next << lead | following >> 1 >> (WORD - 1 - lead);
        const Wide guess = (Wide)inverse * rest + ((Wide)rest << WORD | low);
        uint64_t quotient = (uint64_t)(guess >> WORD) + 1, left = low - quotient * divisor;
        if (left > (uint64_t)guess) {
            quotient -= 1;
            left += divisor;
        }
        if (__builtin_expect(left >= divisor, 0)) {
            quotient += 1;
            left -= divisor;
        }
        w[i] = quotient;
        rest = left;
        next = following;
    }
    return normal(w, words + 1, a.exponent, a.sign);
}

/* The largest whole number not above x. */
Real floor(const Real &x)
{
    Real whole = x;
    uint64_t *const m = whole.words();
    int below = LIMB_BITS - x.exponent, i; /* bits behind the point */
    if (x.sign == 0 || x.exponent == ENDLESS || below <= 0)
        return x;
    if (x.exponent <= 0)
        return x.sign < 0 ? Real(-1) : Real{};
    for (i = 0; i < below / WORD; i++)
        m[i] = 0;
    m[i] = m[i] >> below % WORD << below % WORD;
    return x.sign < 0 && compare_sizes(whole, x) != 0 ? whole - 1 : whole;
}

Real sqrt(const Real &x)
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
