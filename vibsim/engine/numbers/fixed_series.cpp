/* Series over a step in whole numbers; fixed_series.h says what they are. */
#ifndef __clang__
#pragma GCC optimize("O2") /* few loops, of which most of the time of a run is made */
#endif
#include "limbs.h"

#include "real.h"

#ifdef FIXED_SERIES
#include "fixed_series.h"

#include "zalloc.h"
#include "words.h"

typedef __int128 Signed;

enum { WAVE_TERMS = LIMBS == 2 ? 18 : LIMBS == 3 ? 25 : 32 };

/* Words of a mantissa from the highest on, a word of zeros before them and two behind. */
STEP void spread(const Real &x, uint64_t *w)
{
    w[0] = w[LIMBS + 1] = w[LIMBS + 2] = 0;
    UNROLLED for (int i = 0; i < LIMBS; i++)
        w[1 + i] = x.m[LIMBS - 1 - i];
}

bool digits_of(const Real &x, long up, int count, Digits *out)
{
    const long shift = -((long)x.exponent + up);
    const int64_t flip = -(int64_t)(x.sign < 0);
    uint64_t w[LIMBS + 3];
    int64_t over = 0;
    if (x.sign == 0 || shift >= DIGIT * count) {
        for (int i = 0; i < count; i++)
            out->digit[i] = 0;
        return x.exponent != ENDLESS;
    }
    if (shift < 0)
        return false;
    spread(x, w);
    for (int i = count - 1; i >= 0; i--) {
        const long at = (long)DIGIT * i - 1 - shift + WORD; /* where the digit begins among the words */
        int64_t digit = 0;
        if (at >= 0 && at < (long)WORD * (LIMBS + 1))
            digit = (int64_t)((w[at / WORD] << at % WORD | w[at / WORD + 1] >> 1 >> (WORD - 1 - at % WORD)) >> 4); /* 60 of 64 bits */
        digit += over;
        over = i > 0 ? (digit + ((int64_t)1 << (DIGIT - 1))) >> DIGIT : 0;
        digit -= over << DIGIT;
        out->digit[i] = (digit ^ flip) - flip;
    }
    return true;
}

/* Sums of products that end at the same digit: of digits whose products are below 2^119, 86 times 5 of them at most. */
template <int DIGITS> STEP Real sum_of_leading(const Digits *a, const Digits *b, int count, long exponent)
{
    Signed s0 = 0, s1 = 0, s2 = 0, s3 = 0, s4 = 0, s[5];
    uint64_t w[DIGITS + 1] = {0};
    for (int k = 0; k < count; k++) {
        const int64_t *p = a[k].digit, *q = b[k].digit;
        s0 += (Signed)p[0] * q[0];
        if constexpr (DIGITS > 1)
            s1 += (Signed)p[0] * q[1] + (Signed)p[1] * q[0];
        if constexpr (DIGITS > 2)
            s2 += (Signed)p[0] * q[2] + (Signed)p[1] * q[1] + (Signed)p[2] * q[0];
        if constexpr (DIGITS > 3)
            s3 += (Signed)p[0] * q[3] + (Signed)p[1] * q[2] + (Signed)p[2] * q[1] + (Signed)p[3] * q[0];
        if constexpr (DIGITS > 4)
            s4 += ((Signed)p[0] * q[4] + (Signed)p[1] * q[3] + (Signed)p[2] * q[2]) + ((Signed)p[3] * q[1] + (Signed)p[4] * q[0]);
    }
    s[0] = s0, s[1] = s1, s[2] = s2, s[3] = s3, s[4] = s4;
    for (int i = DIGITS - 1; i > 0; i--)
        s[i - 1] += s[i] >> DIGIT; /* below: what is left of s[i], from 0 to 2^60 */
    const uint64_t flip = s[0] < 0 ? ~(uint64_t)0 : 0;
    const uint64_t mask = ((uint64_t)1 << DIGIT) - 1;
    w[DIGITS] = (uint64_t)(s[0] >> WORD);
    w[DIGITS - 1] = (uint64_t)s[0];
    for (int i = 1; i < DIGITS; i++) {
        const uint64_t next = i + 1 < DIGITS ? (uint64_t)s[i + 1] & mask : 0;
        w[DIGITS - 1 - i] = ((uint64_t)s[i] & mask) << 4 * i | next >> (DIGIT - 4 * i);
    }
    if (flip) {
        unsigned char carry = 1;
        for (int i = 0; i < DIGITS + 1; i++)
            carry = __builtin_add_overflow(~w[i], (uint64_t)carry, &w[i]);
    }
    exponent += 10; /* 2^128 is 2^10 times 1 */
    if (DIGITS >= LIMBS && w[DIGITS] && exponent < FURTHEST && exponent > WORD - FURTHEST) {
        Real sum;
        const int lead = __builtin_clzll(w[DIGITS]), low = DIGITS + 1 - LIMBS;
        UNROLLED for (int i = 0; i < LIMBS; i++)
            sum.m[i] = w[low + i] << lead | (low + i > 0 ? w[low + i - 1] >> 1 >> (WORD - 1 - lead) : 0);
        sum.exponent = (int32_t)(exponent - lead);
        sum.sign = flip ? -1 : 1;
        return sum;
    }
    return normal(w, DIGITS + 1, exponent, flip ? -1 : 1);
}

Real sum_of_products(const Digits *a, const Digits *b, int count, int digits, long exponent)
{
    switch (digits) {
    case 1: return sum_of_leading<1>(a, b, count, exponent);
    case 2: return sum_of_leading<2>(a, b, count, exponent);
#if LIMBS > 2
    case 3: return sum_of_leading<3>(a, b, count, exponent);
#endif
#if LIMBS > 3
    case 4: return sum_of_leading<4>(a, b, count, exponent);
#endif
    default: return sum_of_leading<MOST_DIGITS>(a, b, count, exponent);
    }
}

/* x 2^-shift of a mantissa as a fraction of LIMBS words; shift >= 0. */
STEP void fraction_of(const Real &x, long shift, uint64_t *out)
{
    if constexpr (LIMBS == 2) {
        const Wide whole = (Wide)x.m[1] << WORD | x.m[0], left = shift < LIMB_BITS ? whole >> (int)shift : 0;
        out[0] = (uint64_t)left;
        out[1] = (uint64_t)(left >> WORD);
        return;
    }
    uint64_t w[LIMBS + 3];
    spread(x, w);
    if (shift >= LIMB_BITS) {
        UNROLLED for (int i = 0; i < LIMBS; i++)
            out[i] = 0;
        return;
    }
    const int words = (int)(shift / WORD), bits = (int)(shift % WORD);
    for (int i = 0; i < LIMBS; i++) { /* from the highest word on */
        const uint64_t high = i - words >= 0 ? w[i - words] : 0, low = i + 1 - words >= 0 ? w[i + 1 - words] : 0;
        out[LIMBS - 1 - i] = low >> bits | high << 1 << (WORD - 1 - bits);
    }
}

/* The same in two's complement. Signs follow no rule: no branch looks at them. */
STEP void signed_fraction_of(const Real &x, long shift, uint64_t *out)
{
    const uint64_t below = 0 - (uint64_t)(x.sign < 0);
    unsigned char over = (unsigned char)(below & 1);
    fraction_of(x, shift, out);
    UNROLLED for (int i = 0; i < LIMBS; i++)
        over = __builtin_add_overflow(out[i] ^ below, (uint64_t)over, &out[i]);
}

FixedTable *fixed_table_new(int rows, size_t columns)
{
    FixedTable *f = zalloc(1, sizeof(FixedTable));
    if (!f)
        return NULL;
    f->word = zalloc((size_t)rows * columns, LIMBS * sizeof(uint64_t));
    f->bound = zalloc(columns, sizeof(long));
    if (f->word && f->bound)
        return f;
    fixed_table_free(f);
    return NULL;
}

void fixed_table_free(FixedTable *f)
{
    if (f) {
        free(f->word);
        free(f->bound);
        free(f);
    }
}

void fixed_table_make(FixedTable *f, const Real *table, int rows, int columns, const Real &h)
{
    const long power = (long)h.exponent + 1; /* h is at most half of it */
    f->power = power;
    f->made = 1;
    for (int c = 0; c < columns; c++) {
        long most = LONG_MIN;
        const Real *one = table + c;
        uint64_t *to = f->word + (size_t)c * rows * LIMBS;
        for (int n = 0; n < rows; n++, one += columns)
            if (one->sign != 0 || one->exponent == ENDLESS) {
                const long size = one->exponent + n * power;
                most = size > most ? size : most;
            }
        f->bound[c] = most == LONG_MIN ? (long)ENDLESS : most + 2;
        if (most == LONG_MIN)
            continue;
        one = table + c;
        for (int n = 0; n < rows; n++, one += columns, to += LIMBS) {
            signed_fraction_of(*one, one->sign ? f->bound[c] - (one->exponent + n * power) : (long)LIMB_BITS, to);
        }
    }
}

bool fixed_time(const FixedTable *f, const Real &tau, uint64_t *time)
{
    const long shift = f->power - tau.exponent;
    if (tau.sign <= 0 || shift < 1)
        return false;
    fraction_of(tau, shift, time);
    return true;
}

/* value times time, plus a coefficient: |value| < 1/2. */
STEP void add_next(uint64_t *value, const uint64_t *time, const uint64_t *coefficient)
{
    if constexpr (LIMBS == 2) { /* the same, the time below 1/2 in signed words: what is left out counts in the last place */
        const Signed one = (Signed)(int64_t)value[1] * (int64_t)time[1];
        const uint64_t two = (uint64_t)((Wide)value[0] * time[1] >> WORD);
        const int64_t three = (int64_t)((Signed)(int64_t)value[1] * (int64_t)(time[0] >> 1) >> (WORD - 1));
        const Wide next = (Wide)one + two + (Wide)(Signed)three + ((Wide)coefficient[1] << WORD | coefficient[0]);
        value[0] = (uint64_t)next;
        value[1] = (uint64_t)(next >> WORD);
        return;
    }
    const uint64_t below = 0 - (value[LIMBS - 1] >> (WORD - 1));
    uint64_t w[LIMBS + 1], part[LIMBS];
    multiply_words(value, time, w);
    UNROLLED for (int i = 0; i < LIMBS; i++) {
        value[i] = w[i + 1];
        part[i] = time[i] & below; /* taken for a whole more than it is where it is below 0 */
    }
    subtract_words<LIMBS>(value, part);
    UNROLLED for (int i = 0; i < LIMBS; i++)
        part[i] = coefficient[i];
    add_words<LIMBS>(value, part);
}

/* The number of a fraction, and whether its error of some units in the last place is below the round-off of the run. */
STEP bool number_of(const uint64_t *value, long bound, Real *out)
{
    const int sign = value[LIMBS - 1] >> (WORD - 1) ? -1 : 1, bits = 1 - unit_roundoff.exponent;
    uint64_t w[LIMBS], size[LIMBS];
    int lead;
    UNROLLED for (int i = 0; i < LIMBS; i++) {
        size[i] = value[i];
        w[i] = 0;
    }
    if (sign < 0)
        subtract_words<LIMBS>(w, size);
    else
        UNROLLED for (int i = 0; i < LIMBS; i++)
            w[i] = size[i];
    lead = w[LIMBS - 1] ? __builtin_clzll(w[LIMBS - 1]) : WORD;
    if (lead > LIMB_BITS - bits - 5 || lead == WORD)
        return false;
    UNROLLED for (int i = LIMBS - 1; i > 0; i--)
        out->m[i] = w[i] << lead | w[i - 1] >> 1 >> (WORD - 1 - lead);
    out->m[0] = w[0] << lead;
    out->exponent = (int32_t)(bound - lead);
    out->sign = sign;
    return true;
}

/* Coefficients of cos x and (sin x) / x in x^2 / 2, a quarter of them: below 1/2 are all sums of |x| < 0.8. */
static const struct Waves {
    uint64_t cosine[WAVE_TERMS][LIMBS], sine[WAVE_TERMS][LIMBS];
    Waves()
    {
        Real size = scaled(Real(1), -2);
        for (int n = 0; n < WAVE_TERMS; n++) {
            signed_fraction_of(size, -size.exponent, cosine[n]);
            signed_fraction_of(size / (2 * n + 1), -(size / (2 * n + 1)).exponent, sine[n]);
            size = -scaled(size, 1) / ((2 * n + 1) * (2 * n + 2));
        }
    }
} waves;

/* The number that a fraction above 0 is in quarters. */
STEP Real of_quarters(const uint64_t *value)
{
    uint64_t w[LIMBS + 1] = {0};
    UNROLLED for (int i = 0; i < LIMBS; i++)
        w[i + 1] = value[i];
    return normal(w, LIMBS + 1, 2, 1);
}

void wave_sums(const Real &square, Real *cosine, Real *sine)
{
    uint64_t time[LIMBS], c[LIMBS], s[LIMBS];
    fraction_of(square, 1 - square.exponent, time);
    UNROLLED for (int i = 0; i < LIMBS; i++) {
        c[i] = waves.cosine[WAVE_TERMS - 1][i];
        s[i] = waves.sine[WAVE_TERMS - 1][i];
    }
    for (int n = WAVE_TERMS - 2; n >= 0; n--) {
        add_next(c, time, waves.cosine[n]);
        add_next(s, time, waves.sine[n]);
    }
    *cosine = of_quarters(c);
    *sine = of_quarters(s);
}

int fixed_values(const FixedTable *f, const uint64_t *time, int rows, int c, int apart, Real *first, Real *second)
{
    const uint64_t *a = f->word + ((size_t)(c + 1) * rows - 1) * LIMBS, *b = a + (size_t)apart * rows * LIMBS;
    const bool no_first = f->bound[c] == (long)ENDLESS, no_second = f->bound[c + apart] == (long)ENDLESS;
    uint64_t value[LIMBS], rate[LIMBS], t[LIMBS];
    UNROLLED for (int i = 0; i < LIMBS; i++) {
        value[i] = no_first ? 0 : a[i];
        rate[i] = no_second ? 0 : b[i];
        t[i] = time[i];
    }
    if (!no_first && !no_second)
        for (int n = 1; n < rows; n++) {
            a -= LIMBS;
            b -= LIMBS;
            add_next(value, t, a);
            add_next(rate, t, b);
        }
    else
        for (int n = 1; n < rows; n++) {
            a -= LIMBS;
            b -= LIMBS;
            if (!no_first)
                add_next(value, t, a);
            if (!no_second)
                add_next(rate, t, b);
        }
    if (no_first)
        *first = Real{};
    if (no_second)
        *second = Real{};
    return (no_first || number_of(value, f->bound[c], first)) + 2 * (no_second || number_of(rate, f->bound[c + apart], second));
}
#endif
