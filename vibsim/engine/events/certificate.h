/* What a run has proved about its events, and its grazing margin: the smallest gap [m] at a turn of a gap function.
 *
 * A stretch between two events is certified where every event function is known to stay positive on it, by more than the bound of
 * its rounding and truncation. An event is certified where its function is known to cross zero, by more than that bound too. Of
 * two events, the first is certified to be the first where their times are further apart than rounding blurs them, or where which of
 * them is first makes no difference (order_of_events.c). All else is a doubt: counted, the first one timed,
 * and the first MOST_DOUBTS described by the event functions in question.
 */
#ifndef VIBSIM_CERTIFICATE_H
#define VIBSIM_CERTIFICATE_H

#include "engine.h"

static inline void certificate_open(Certificate *c)
{
    c->margin = INFINITY;
    c->margin_time = c->first_doubt = 0.0;
    c->uncertified = 0;
    c->doubted = NAN;
    c->watched = NOTHING;
}

/* How many doubts are described. */
static inline int described(const Certificate *c)
{
    return c->uncertified < MOST_DOUBTS ? (int)c->uncertified : MOST_DOUBTS;
}

/* Count the stretch that starts at the time `anchor` as not proved, once: for the first reason that there is. at: time [s] near
 * which the doubt is; event, other: as of a `Doubt`. Whether it has been counted just now.
 */
static inline int doubt(Certificate *c, Real anchor, Real at, int reason, int event, int other)
{
    if (!(anchor != c->doubted)) /* NaN before the first */
        return 0;
    if (c->uncertified == 0)
        c->first_doubt = anchor;
    if (c->uncertified < MOST_DOUBTS) {
        Doubt *d = &c->doubts[described(c)];
        d->at = at;
        d->reason = reason;
        d->mode = c->mode;
        d->event = event;
        d->other = other;
    }
    c->uncertified += 1;
    c->doubted = anchor;
    return 1;
}

/* Keep a minimum of a gap function, of height `value` [m] at time t, if it is the smallest so far; below zero it counts as 0. */
static inline void keep_turn(Certificate *c, Real value, Real t)
{
    value = value > 0 ? value : 0 * value;
    if (value < c->margin) {
        c->margin = value;
        c->margin_time = t;
    }
}

/* Whether a function that is zero here with this slope falls below -error: its upper parabola does, which is lowest, at -slope^2 /
 * (2 bound), where its slope is zero; bound: on its absolute second derivative ahead. A touch from above by less than `error` does
 * not.
 */
static inline int crosses(Real slope, Real bound, Real error)
{
    return slope < 0 && -slope > 2 * bound * (error / -slope);
}

/* How long after time t the zero of a falling function may lie [s], by its tangent: the rounding of its value, and of the time
 * that it is stored with, blur the place. value, slope, noise: of the function at t, noise a bound of the rounding of its value.
 */
static inline Real latest_zero(Real value, Real slope, Real noise, Real t)
{
    return (value + noise) / -slope + (nextafter(t, INFINITY) - t);
}

/* Whether a falling function may be zero already `latest` from here; see `latest_zero`. */
static inline int may_vanish_by(Real value, Real slope, Real noise, Real latest)
{
    return slope < 0 && value - noise <= -slope * latest;
}

#endif
