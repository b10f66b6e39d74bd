/* Elementary functions of numbers of WORDS words, by the names that elementary.h gives those of doubles. limbs.cpp says how. */
#ifndef VIBSIM_LIMBS_FUNCTIONS_H
#define VIBSIM_LIMBS_FUNCTIONS_H

#include "functions.h"
#include "limbs.h"

/* SPARE_BITS: that the words in use have beyond the unit round-off of a run, at least, as in physics/precision.py; MOST_BITS of these. */
#ifdef WORDS_BY_RUN
enum { SPARE_BITS = 20, MOST_BITS = 64 * (LIMBS - 1) - SPARE_BITS }; /* constants are computed with one word more */
#else
enum { SPARE_BITS = 20, MOST_BITS = 64 * LIMBS - SPARE_BITS };
#endif

extern thread_local Real unit_roundoff; /* 2^-bits of the run in hand */
void set_precision(int bits);

#ifdef WORDS_BY_RUN
/* All of the precision that was set last in this thread: precision_by_run.cpp */
extern constinit thread_local int most_order, series_terms; /* of the Taylor flow; terms of 2^n / n! */
extern thread_local Real HALF_TURN, half_pi, ln_2;
void small_sine_cosine(const Real &r, Real *sine, Real *cosine);
Real small_rise(const Real &r);

/* While it is, the run in hand has fewer words in use: `words`, from 2 on, where that is less. The words of `x` that come into use with
 * it, and behind it, are made 0.
 */
class Precision
{
    const int before;
    Real *const of;

  public:
    Precision(int words, Real *x);
    ~Precision();
};
#else
extern const Real HALF_TURN; /* pi */
#endif

void sine_cosine(const Real &angle, Real *sine, Real *cosine);
void rounded_sine_cosine(const Real &angle, Real *sine, Real *cosine);
#define DECLARED(CODE, name, of, sign, text) Real of(const Real &x);
ELEMENTARY_FUNCTIONS(DECLARED)
#undef DECLARED
Real exponential_less_1(const Real &x);
Real real_power(const Real &a, const Real &p);

/* Numbers as decimal texts of so many significant digits, each in `width` characters, the rest of them 0; false where one is not
 * finite, or beyond what this is made for. width: digits + 8 at least.
 */
bool decimal_texts(const Real *x, long count, int digits, int width, char *out);

/* The next larger time: a unit round-off on, whatever the direction asked for. */
static inline Real nextafter(const Real &t, const Real &towards)
{
    (void)towards;
    return t + (fabs(t) + unit_roundoff) * unit_roundoff;
}

static inline Real fmax(const Real &a, const Real &b) { return a > b ? a : b; }
static inline Real fmin(const Real &a, const Real &b) { return a < b ? a : b; }

static inline void moderate_sine_cosine(const Real &angle, Real *sine, Real *cosine)
{
    sine_cosine(angle, sine, cosine);
}

#endif
