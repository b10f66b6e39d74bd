/* Responses of one damped oscillator (see responses.c), where they are evaluated at every step. */
#ifndef VIBSIM_RESPONSES_H
#define VIBSIM_RESPONSES_H

#include "engine.h"
#include "numbers.h"

/* Quotients by b and by Z = (r1 - i omega)(r2 - i omega) cancel at most three bits where |Z| t^2 is above a quarter; far above
 * critical damping, where r2 t is large whatever r1 t is, where |r1 - i omega| t is above a half.
 */
#define QUARTER 0.25
/* After many turns close to resonance the phases of C and S, rounded to eps w t, come out of the quotient over |r1 - i omega| t,
 * which is small.
 */
#define RESONANT 0.01

/* responses.c; near resonance, where the difference of two modes would cancel */
void confluent_response(const Oscillator *o, Real t, Real cosine, Real sine, Real *hc, Real *hs);

/* Of an oscillation whose sine and cosine are given. */
static inline void swing(const Oscillator *o, Real t, Real sine, Real cosine, Real *release, Real *impulse)
{
    Real decay = exponential(-(o->a * t)), rise = decay * (sine * o->per_wd), slow = decay * t;
    *impulse = o->wd * t != 0 ? rise : slow;
    *release = decay * cosine + o->a * *impulse;
}

/* C(t) [-] and S(t) [s]. */
static inline void release_and_impulse(const Oscillator *o, Real t, Real *release, Real *impulse)
{
    Real decay, sine, cosine;
    if (o->oscillates) {
        sine_cosine(o->wd * t, &sine, &cosine);
        swing(o, t, sine, cosine, release, impulse);
        return;
    }
    decay = exponential(o->slow * t);
    *impulse = decay * (exponential_less_1(-(2 * (o->wd * t))) / -(2 * o->wd));
    *release = decay - o->slow * *impulse;
}

/* Re H, Im H [s^2] by power series, for spreads |r t|, |omega t| below 2. */
static inline void series_response(const Oscillator *o, Real t, Real *hc, Real *hs)
{
    Real square = t * t, angle = o->rate * t;
    *hc = square * horner(o->real_series, SERIES_TERMS, angle);
    *hs = square * horner(o->imag_series, SERIES_TERMS, angle);
}

/* I(t) [s^2], given C(t). */
static inline Real constant_response(const Oscillator *o, Real t, Real release)
{
    if (o->settling * (t * t) >= QUARTER)
        return (1 - release) * o->per_b;
    if (!o->oscillates && o->wd * t >= 0.5) {
        Real slow = o->slow != 0 ? exponential_less_1(o->slow * t) / o->slow : t;
        return (slow - exponential_less_1(o->fast * t) / o->fast) / (2 * o->wd);
    }
    return t * t * horner(o->steady_series, SERIES_TERMS, o->rate * t);
}

/* Whether the difference of two modes would cancel at the time t, its square given. */
static inline int is_resonant(const Oscillator *o, Real square)
{
    Real detuning = o->wd - o->omega;
    return o->oscillates && (o->a * o->a + detuning * detuning) * square < RESONANT;
}

/* Whether the response to a harmonic load is a quotient at the time t, its square given: it is at all later times too. */
static inline int is_quotient(const Oscillator *o, Real square)
{
    return o->beating * (square * square) >= QUARTER * QUARTER && !is_resonant(o, square);
}

/* Re H(t), Im H(t) [s^2] and their rates [s], given C, S and cos, sin of omega t. The rates from H' = S + i omega H, but for a
 * quotient, as of a fast load, where that difference would cancel.
 */
static inline void harmonic_response(const Oscillator *o, Real t, Real release, Real impulse, Real cosine, Real sine,
                       Real *hc, Real *hs, Real *dc, Real *ds)
{
    if (is_quotient(o, t * t)) {
        Real nr = cosine - release, ni = sine - o->omega * impulse, vr, vi;
        *hc = nr * o->inverse_r + ni * o->inverse_i;
        *hs = ni * o->inverse_r - nr * o->inverse_i;
        vr = o->b * impulse - o->omega * sine;
        vi = o->omega * (cosine - (release - 2 * o->a * impulse));
        *dc = vr * o->inverse_r + vi * o->inverse_i;
        *ds = vi * o->inverse_r - vr * o->inverse_i;
        return;
    }
    if (o->wd * t >= 0.5)
        confluent_response(o, t, cosine, sine, hc, hs);
    else
        series_response(o, t, hc, hs);
    *dc = impulse - o->omega * *hs;
    *ds = o->omega * *hc;
}

/* H of a free mass (a = b = 0): int int cos(omega s), int int sin(omega s) [s^2]; the series of `point` serves short times. */
static inline void free_harmonic_response(const Oscillator *point, Real t, Real cosine, Real sine, Real *hc, Real *hs)
{
    Real angle = point->omega * t;
    if (angle * angle >= QUARTER) {
        *hc = (cosine - 1) * point->inverse_r;
        *hs = (sine - angle) * point->inverse_r;
        return;
    }
    series_response(point, t, hc, hs);
}

#endif
