/* What the engine takes from outside: numbers that become indices, counts or loops, checked before a run is made of them. */
#ifndef VIBSIM_CHECKS_H
#define VIBSIM_CHECKS_H

#include "kernel.h"

#define LOWEST_ORDER 4
#define MOST_SAMPLES 4e18 /* their index is a 64-bit number */

static inline int one_of(double value, double low, double high)
{
    return low <= value && value <= high && value == floor(value);
}

static inline int countable(const Scene *s, double t)
{
    return t >= 0 && t * s->every_den / s->every_num < MOST_SAMPLES;
}

/* Why no run can be made of a scene; NULL where one can. */
static inline const char *scene_problem(const Scene *s)
{
    int dimension = 2 + (s->has_motor != 0 ? 2 : 0) + (s->has_block2 != 0 ? 1 : 0);
    if (!one_of(s->order, LOWEST_ORDER, MAX_ORDER))
        return "order must be 4 to 40";
    if (!one_of(s->tangent, 0, dimension))
        return "tangent must be 0 to the number of exponents that the scene has";
    if (!(s->every_num > 0 && s->every_den > 0 && isfinite(s->every_num) && isfinite(s->every_den)))
        return "every_num and every_den must be > 0";
    if (!(isfinite(s->t_end) && countable(s, s->t_end)))
        return "t_end must be >= 0 and hold a number of samples that 64 bits can count";
    return 0;
}

/* Why a run cannot go on from a packed row: state (8), mode (3), known zeros (5); NULL where it can. */
static inline const char *resume_problem(const Scene *s, const double *row)
{
    int i;
    for (i = 0; i < 8; i++)
        if (!isfinite(row[i]))
            return "the state must be finite";
    if (!countable(s, row[0]))
        return "t must be >= 0 and within the span that samples can be counted in";
    if (!one_of(row[8], 0, s->has_stop != 0 ? 1 : 0))
        return "contact must be 0 or 1, and 0 without a stop";
    if (!one_of(row[9], -1, 1))
        return "friction must be -1, 0 or 1";
    if (!one_of(row[10], 0, 1))
        return "violated must be 0 or 1";
    for (i = 0; i < FUNCTIONS; i++)
        if (!one_of(row[11 + i], 0, 2))
            return "the order of a known zero must be 0 to 2";
    return 0;
}

#endif
