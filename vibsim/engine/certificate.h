/* Doubts of a run and its grazing margin; twin of vibsim/engine/certificate.py. */
#ifndef VIBSIM_CERTIFICATE_H
#define VIBSIM_CERTIFICATE_H

#include "engine.h"

static inline void doubt(Certificate *c, double anchor)
{
    if (anchor != c->doubted) {
        if (c->uncertified == 0)
            c->first_doubt = anchor;
        c->uncertified += 1;
        c->doubted = anchor;
    }
}

static inline void keep_turn(Certificate *c, double value, double t)
{
    value = value > 0 ? value : 0 * value;
    if (value < c->margin) {
        c->margin = value;
        c->margin_time = t;
    }
}

static inline int crosses(double slope, double bound, double error)
{
    return slope < 0 && -slope > 2 * bound * (error / -slope);
}

#endif
