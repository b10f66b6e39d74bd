/* Doubts of a run and its grazing margin. */
#ifndef VIBSIM_CERTIFICATE_H
#define VIBSIM_CERTIFICATE_H

#include "engine.h"

static inline void certificate_open(Certificate *c)
{
    c->margin = INFINITY;
    c->margin_time = c->first_doubt = 0.0;
    c->uncertified = 0;
    c->doubted = NAN;
}

static inline void doubt(Certificate *c, Real anchor)
{
    if (anchor != c->doubted) {
        if (c->uncertified == 0)
            c->first_doubt = anchor;
        c->uncertified += 1;
        c->doubted = anchor;
    }
}

static inline void keep_turn(Certificate *c, Real value, Real t)
{
    value = value > 0 ? value : 0 * value;
    if (value < c->margin) {
        c->margin = value;
        c->margin_time = t;
    }
}

static inline int crosses(Real slope, Real bound, Real error)
{
    return slope < 0 && -slope > 2 * bound * (error / -slope);
}

static inline Real latest_zero(Real value, Real slope, Real noise, Real t)
{
    return (value + noise) / -slope + (nextafter(t, INFINITY) - t);
}

static inline int may_vanish_by(Real value, Real slope, Real noise, Real latest)
{
    return slope < 0 && value - noise <= -slope * latest;
}

#endif
