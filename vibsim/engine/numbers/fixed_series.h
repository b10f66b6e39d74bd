/* Series over a step in whole numbers: coefficient n times H^n, H a power of 2 that is longer than the step, in units of what
 * bounds all of them. Sums of their products and their values need no exponents then, and are rounded once.
 */
#ifndef VIBSIM_FIXED_SERIES_H
#define VIBSIM_FIXED_SERIES_H

#include <stddef.h>

#include "limbs_functions.h"

enum { DIGIT = 60, MOST_DIGITS = LIMBS + 1 };
enum { COSINES, SINES, SPEEDS, THRUSTS, BLOCKS }; /* series of a rotor whose products are summed */

/* Sum of digit[i] 2^(-DIGIT i): digit[0] is 2^59 where the number is 1; the others may have either sign. */
typedef struct {
    int64_t digit[MOST_DIGITS];
} Digits;

/* How series of a rotor are taken as digits; by mode, since steps differ. `power`: binary exponent of H; `bound`: of what bounds a
 * series. Sums of order n take `digits[n]` of `most` digits, which suffices where the step is no longer than 2^-gap H and bounds
 * exceed the first coefficients by no more than `slack` bits, both series of a product together. 0 of them: not known yet.
 */
template <int ORDERS> struct Scales {
    double gap;
    int most, power, slack, bound[BLOCKS], words;
    unsigned char digits[ORDERS];
};

/* Of series of a small scene whose last orders are in doubles: the first of these, and the sizes of all that is summed in it. */
enum { OF_COSINE, OF_SINE, OF_SPEED, OF_RATE, OF_RATE_FAR, RESTS };
typedef struct {
    double terms[RESTS];
    int first;
} Rest;

/* x 2^up in `count` digits; false where it is 1 or more. */
bool digits_of(const Real &x, long up, int count, Digits *out);

/* Sum of a[i] b[i], i from 0 below count, by their highest `digits` digits; 1 stands for 2^exponent. */
Real sum_of_products(const Digits *a, const Digits *b, int count, int digits, long exponent);

/* cos x and (sin x) / x of |x| < 0.8, by x^2 that is not 0. */
void wave_sums(const Real &square, Real *cosine, Real *sine);

/* The columns of a Taylor table as fractions of LIMBS words, two's complement: coefficient n of column c at word[(c * rows + n) LIMBS]. */
typedef struct {
    uint64_t *word;
    long *bound; /* binary exponent of what bounds four times all terms of a column; ENDLESS where all are 0 */
    long power;  /* H is 2^power */
    int made;
} FixedTable;

FixedTable *fixed_table_new(int rows, size_t columns); /* room for so many coefficients; NULL without memory */
void fixed_table_free(FixedTable *f);

/* Makes it of `rows` rows of `columns` coefficients for values up to h. */
void fixed_table_make(FixedTable *f, const Real *table, int rows, int columns, const Real &h);

/* Values of columns c and c + apart at `time` H; returns for each (bit 0, bit 1) whether rounding leaves of it what counts. */
int fixed_values(const FixedTable *f, const uint64_t *time, int rows, int c, int apart, Real *first, Real *second);

/* tau / H as a fraction of LIMBS words; false where it is below 0, or above 1/2. */
bool fixed_time(const FixedTable *f, const Real &tau, uint64_t *time);

#endif
