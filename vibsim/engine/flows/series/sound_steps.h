/* What formulas read within a step, and how steps are shortened until values are those that series say. */
#ifndef VIBSIM_SOUND_STEPS_H
#define VIBSIM_SOUND_STEPS_H

#include "engine.h"
#include "numbers.h"

#define LEAST_SHORTENING 0.25 /* binary digits */
#define BEYOND_ALL 60.0       /* binary digits by which a value that is no number is beyond */

/* Displacements and velocities that formulas read, from those in the order of the table of Taylor series. */
static inline void read_columns(const Run *r, const Real *columns, TapeInputs *at)
{
    int c;
    for (c = 0; c < r->columns; c++) {
        int from = c < r->bodies ? c : c > r->bodies && r->has_base ? base_column(r) : -1;
        at->x[c] = from < 0 ? 0.0 : columns[from];
        at->v[c] = from < 0 ? 0.0 : columns[r->taylor.rates + from];
    }
}

/* Rounding of all that formulas read but the time: the share `lost` of each. */
static inline void blur_inputs(const Run *r, const TapeInputs *at, Real lost, TapeInputs *blur)
{
    int c;
    for (c = 0; c < r->columns; c++) {
        blur->x[c] = lost * fabs(at->x[c]);
        blur->v[c] = lost * fabs(at->v[c]);
    }
    blur->phi = lost * fabs(at->phi);
    blur->w = lost * fabs(at->w);
}

/* By how many binary digits, one at least, a value that is off by so much is beyond what it may be; 0 where it is not. */
static inline double digits_beyond(Real off, Real allowed)
{
    double beyond;
    if (off <= allowed && isfinite(allowed)) /* a value that overflows has no bound */
        return 0.0;
    if (!(isfinite(off) && allowed > 0))
        return BEYOND_ALL;
    beyond = binary_exponent(off) - binary_exponent(allowed);
    return beyond > 1.0 ? beyond : 1.0;
}

/* A step by series of an order that is shortened by so many binary digits, and one, over that order. */
static inline Real shortened(Real step, double beyond, int order)
{
    double digits = (beyond + 1) / order;
    return step * power_of_two(-(digits > LEAST_SHORTENING ? digits : LEAST_SHORTENING));
}

#endif
