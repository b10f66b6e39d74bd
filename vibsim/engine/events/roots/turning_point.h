/* The minimum of a function between two points, by safeguarded Newton steps on its slope. */
#ifndef VIBSIM_TURNING_POINT_H
#define VIBSIM_TURNING_POINT_H

#include <math.h>

#define TURNING 60 /* Newton steps or bisections, at most */

/* Where a slope has its extreme within `length`, from its cubic: values before and after, derivatives bend and unbend of opposite
 * signs there.
 */
static inline Real extreme_of_slope(Real length, Real before, Real bend, Real after, Real unbend)
{
    Real mean = (after - before) / length;
    Real b = 6 * mean - 4 * bend - 2 * unbend, a = 3 * (bend + unbend) - 6 * mean;
    Real root = sqrt(b * b - 4 * a * bend);
    return length * (2 * bend / (bend > 0 ? root - b : -root - b));
}

typedef void (*SlopeAt)(void *function, Real t, Real *slope, Real *curvature);

/* Where a function with a falling slope at `low` and a rising one at `high` turns round; settled: length of a step behind which
 * the next one is round-off. last: point evaluated last; turn: place of the minimum by one more Newton step; depth: of that
 * minimum below the value at `last`.
 */
static inline void turning_point(SlopeAt slope_at, void *function, Real low, Real high, Real settled, Real *last,
                                 Real *turn, Real *depth)
{
    Real ahead = low + (high - low) / 2, t = ahead, slope = 0, curvature = 0;
    int i;
    for (i = 0; i < TURNING; i++) {
        t = ahead;
        slope_at(function, t, &slope, &curvature);
        if (slope < 0)
            low = t;
        else
            high = t;
        ahead = curvature > 0 ? t - slope / curvature : low;
        if (curvature > 0 && fabs(ahead - t) < settled)
            break;
        if (!(low < ahead && ahead < high))
            ahead = low + (high - low) / 2;
    }
    *last = t;
    *turn = ahead;
    *depth = curvature > 0 ? slope * slope / (2 * curvature) : 0 * slope;
}

#endif
