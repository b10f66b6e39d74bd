/* What depends on how many words of a number the run in hand uses; limbs.cpp has the same where that is a constant.
 *
 * Pi by Machin's formula, ln 2 by one of its kind; sine, cosine and exponential by power series of an argument that is halved often.
 * Numbers of terms and halvings go with the square root of the digits, where the products are fewest: Brent and Zimmermann, Modern
 * Computer Arithmetic (2010), 4.3 and 4.4. Series are summed in rows by divisions by small numbers (Smith 1989, Efficient
 * multiple-precision evaluation of elementary functions), and terms have no more words than count.
 */
#ifdef WORDS_BY_RUN
#include <stdlib.h>

#include "limbs_functions.h"

#include "elementary.h"
#include "real.h"
#include "words.h"

enum { FEWEST_WORDS = 2, LEAST_ORDER = 20 };

constinit thread_local int words_in_use = FEWEST_WORDS, most_order = LEAST_ORDER, series_terms = 2;
static constinit thread_local int bits_in_use = 0, halvings_of_sine, terms_of_sine, halvings_of_rise, terms_of_rise;
thread_local Real unit_roundoff, HALF_TURN, half_pi, ln_2;

Series::Series() : at((Real *)malloc((size_t)SERIES * sizeof(Real)))
{
    if (!at)
        abort(); /* half a megabyte at most, which every system grants or ends the process for */
}

Series::~Series()
{
    free(at);
}

/* Have numbers `words` words; the words of x that come into use are 0. */
static void use_words(int words, Real *x)
{
    for (int i = LIMBS - words; i < LIMBS - words_in_use; i++)
        x->m[i] = 0;
    words_in_use = words;
}

Precision::Precision(int words, Real *x) : before(words_in_use), of(x)
{
    words_in_use = words < FEWEST_WORDS ? FEWEST_WORDS : words < before ? words : before;
}

Precision::~Precision()
{
    use_words(before, of);
}

/* Sum of s^k / ((2 k + 1) n^(2 k + 1)), k from 0: the inverse tangent of 1 / n with s = -1, the hyperbolic one with s = 1. */
static Real inverse_tangent(int n, int s)
{
    Real power = Real(1) / n, sum = power;
    int k;
    for (k = 1; power.exponent > -LIMB_BITS; k++) {
        power = power / (n * n);
        sum = k % 2 && s < 0 ? sum - power / (2 * k + 1) : sum + power / (2 * k + 1);
    }
    return sum;
}

/* A number of one word more than are in use, rounded. */
static Real shortened(const Real &x)
{
    uint64_t w[LIMBS];
    memcpy(w, x.words() - 1, sizeof *w * (size_t)(WORDS + 1));
    return normal(w, WORDS + 1, x.exponent, x.sign);
}

static double log2_of(double x)
{
    return logarithm(x) * PER_LN_2;
}

/* Terms of a power series at 2^-halvings until they are below the last word: after n of them stands `step` n factorial below. */
static int terms_after(int halvings, int step)
{
    double size = 0;
    int n;
    for (n = 1; size < LIMB_BITS; n++)
        for (int i = 0; i < step; i++)
            size += halvings + log2_of(n * step - i);
    return n;
}

void set_precision(int bits)
{
    double size = 1;
    if (bits == bits_in_use)
        return;
    words_in_use = (bits + SPARE_BITS + WORD - 1) / WORD + 1;
    {
        const Real pi = 16 * inverse_tangent(5, -1) - 4 * inverse_tangent(239, -1);
        const Real two = 18 * inverse_tangent(26, 1) - 2 * inverse_tangent(4801, 1) + 8 * inverse_tangent(8749, 1);
        words_in_use -= 1;
        HALF_TURN = shortened(pi);
        ln_2 = shortened(two);
    }
    half_pi = scaled(HALF_TURN, -1);
    unit_roundoff = scaled(Real(1), -bits);
    most_order = (int)(0.36 * bits) > LEAST_ORDER ? (int)(0.36 * bits) : LEAST_ORDER; /* as `DigitsKit.order` in Python */
    for (series_terms = 1; size > -bits - 4; size += 1 - log2_of(series_terms))
        series_terms++;
    halvings_of_sine = (int)(0.45 * sqrt((double)LIMB_BITS));
    terms_of_sine = terms_after(halvings_of_sine, 2);
    halvings_of_rise = (int)(0.65 * sqrt((double)LIMB_BITS));
    terms_of_rise = terms_after(halvings_of_rise, 1);
    bits_in_use = bits;
}

static int highest_bit(int n)
{
    return 31 - __builtin_clz((unsigned)n);
}

/* Sum of x^k / (d_1 d_2 ... d_k), k from 1 to `terms`, |x| < 2^-small, d_k = k or with `step` 2 the product of 2 k - 1 and 2 k: in rows
 * of terms that differ by a power of x below the first of a row, of which there are at most MOST_ROWS.
 */
static Real power_sum(const Real &x, int terms, int step, int small)
{
    enum { MOST_ROWS = 16 };
    const int bits = LIMB_BITS;
    Real power[MOST_ROWS + 1], sum = 0;
    int rows = 2, size = 0, k; /* size: 2^size is no more than d_1 d_2 ... d_k */
    while (rows * rows < terms / 2 && rows < MOST_ROWS)
        rows++;
    power[0] = 1;
    power[1] = x;
    for (k = 2; k <= rows; k++)
        power[k] = power[k - k / 2] * power[k / 2];
    for (k = 1; k <= terms; k++)
        size += highest_bit(step == 1 ? k : 2 * k * (2 * k - 1));
    for (k = terms; k > 0; k--) {
        const int divisor = step == 1 ? k : 2 * k * (2 * k - 1);
        const Precision words((bits - size - small * (k - k % rows - 1)) / WORD + 2, &sum);
        if (k % rows == rows - 1)
            sum = sum * power[rows];
        sum = (sum + power[k % rows]) / divisor;
        size -= highest_bit(divisor);
    }
    return sum;
}

/* Sine and cosine of |r| < 0.8: v = 1 - cos of r / 2^k by its series, then as often 1 - cos 2 x = 2 v (2 - v), which keeps its relative
 * error; sin^2 = v (2 - v).
 */
void small_sine_cosine(const Real &r, Real *sine, Real *cosine)
{
    const Real x = scaled(r, -halvings_of_sine);
    Real v = -power_sum(-(x * x), terms_of_sine, 2, 2 * halvings_of_sine);
    int n;
    for (n = 0; n < halvings_of_sine; n++)
        v = scaled(v * (2 - v), 1);
    *cosine = 1 - v;
    *sine = copysign(sqrt(v * (2 - v)), r);
}

/* exp(r) - 1 of |r| < 0.4: of r / 2^k by its series, then as often (1 + u)^2 - 1 = u (2 + u). */
Real small_rise(const Real &r)
{
    Real u = power_sum(scaled(r, -halvings_of_rise), terms_of_rise, 1, halvings_of_rise);
    int n;
    for (n = 0; n < halvings_of_rise; n++)
        u = u * (2 + u);
    return u;
}
#endif
