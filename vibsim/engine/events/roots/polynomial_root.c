/* Certified first root of an event function that is a polynomial over one step, and how close a gap function comes without one.
 * Known zeros at the start are divided out first, together with any further coefficient that is exactly zero.
 */
#include "certificate.h"
#include "first_root.h"
#include "engine.h"
#include "numbers.h"
#include "turning_point.h"

#define LONG_MARCH 64 /* steps from which on bounds reach less far, and are the tighter for it */
#define NARROWER 4 /* reach of such bounds, in ways marched so far */
#define PIECES 8 /* a step spans less than two radians of the fastest motion: one minimum at most in each piece */
#define POLISHING 5 /* Newton steps behind the first: each doubles the right digits */
#define BEYOND 64 /* roundings: a start by so much away from zero is proved to be on its side */
#define SHORTER 16 /* times, where a step is too long to prove that */
#define SHORTEST 64 /* units in the last place of the time, of such a step */

#ifdef LIMBS
/* Start of the loop below: v and s of the terms that doubles have digits enough for, by what they are at tau; returns the lowest of them.
 * Their rounding is below that of all words, finer than that of the run: events of one instant keep their order.
 */
static int last_terms(const Real *series, int count, const Real &tau, Real *v, Real *s)
{
    enum { DOUBLE = 53 };
    const long power = tau.exponent, digits = (int)DOUBLE - LIMB_BITS;
    long most = LONG_MIN, unit;
    double value = 0, slope = 0, part;
    int n, first = count - 1;
    if (tau.sign == 0)
        return count - 1;
    for (n = 0; n < count; n++) {
        const long size = series[n].exponent + n * power;
        if (series[n].sign != 0 && size > most)
            most = size;
    }
    while (first > 0 && (series[first].sign == 0 || series[first].exponent + first * power <= most + digits))
        first--;
    unit = most + digits; /* a term of it is 1 in what follows */
    part = in_double(tau, -power);
    for (n = count - 1; n > first; n--) {
        slope = slope * part + value;
        value = value * part + in_double(series[n], n * power - unit);
    }
    *v = scaled(Real(value), unit - (first + 1) * power);
    *s = scaled(Real(slope), unit - (first + 2) * power);
    return first + 1;
}
#endif

/* f and f' at tau by Horner's rule. */
static void value_and_slope(const Real *series, int count, Real tau, Real *value, Real *slope)
{
    Real v = series[count - 1], s = series[count - 1] * 0;
    int n = count - 1;
#ifdef LIMBS
    n = last_terms(series, count, tau, &v, &s);
#endif
    for (n--; n >= 0; n--) {
        s = s * tau + v;
        v = v * tau + series[n];
    }
    *value = v;
    *slope = s;
}

/* Rounding bound of the value at tau. */
static Real noise_at(const Real *series, int count, Real tau)
{
#ifdef LIMBS
    const Power step = power_of(tau);
    Power power = step;
    Magnitude total = 0;
    int n;
    for (n = 1; n < count; n++, power = next_power(power, step))
        total = total + term_size(series[n], power);
    return 4 * EPS * (fabs(series[0]) + total * INFLATED);
#else
    return 4 * EPS * sizes_at(series, count, tau);
#endif
}

/* The zero that a Newton step from tau leads to, not before the start of the step. */
static Real newton(Real tau, Real value, Real slope)
{
    Real zero = tau - value / slope;
    return zero > 0 ? zero : 0 * tau;
}

/* The zero ahead of a function that is sure to cross it: more Newton steps where the error of one, by the bound of |f''|, is
 * above the grid of time.
 */
static Real zero_ahead(const Real *series, int count, Real tau, Real value, Real slope, Real bound, Real t0)
{
    Real zero = newton(tau, value, slope), unit = nextafter(t0, INFINITY) - t0;
    int i;
    for (i = 0; i < POLISHING; i++) {
        Real step = value / slope;
        if (bound * (step * step) <= -(2 * slope) * unit)
            break;
        value_and_slope(series, count, zero, &value, &slope);
        if (slope >= 0)
            break;
        zero = newton(zero, value, slope);
    }
    return zero;
}

/* The safe step from tau by a bound of |f''| that reaches a few times as far as the march has come, or `step`, that by the
 * bound of all h, whichever is longer.
 */
static Real nearer_step(const Real *series, int count, Real tau, Real room, Real slope, Real step, Real h)
{
    Real reach = NARROWER * (tau > step ? tau : step), bound = 0.0, nearer;
    int n;
    if (reach >= h)
        return step;
    for (n = count - 1; n > 1; n--)
        bound = bound * reach + n * (n - 1) * fabs(series[n]);
    nearer = safe_step(room, slope, bound);
    nearer = nearer < reach - tau ? nearer : reach - tau;
    return nearer > step ? nearer : step;
}

/* March by safe steps from t0; as `polynomial_first_root`. The function is proved positive where the polynomial stays above
 * `error`. Where it falls below, and is sure to cross zero, one Newton step leads there, or with `sharp` some. Otherwise the
 * stretch is in doubt, and the march goes on to where the value is zero but for its rounding. Steps shorter than the grid of time
 * are doubled until they move it. bound: of |f''|.
 */
static int march(Certificate *c, const Real *series, int count, Real error, Real bound, Real t0, Real h, int sharp,
                 Real *end)
{
    Real t = t0, stall = 1.0, floor = error, noise = error;
    Real value = series[0], slope = count > 1 ? series[1] : 0.0; /* at t0 */
    int near = 0, i;
    for (i = 0; i < MARCH_LIMIT; i++) {
        Real tau = t - t0, room, step, ahead;
        if (tau > h)
            return POSITIVE;
        if (i > 0)
            value_and_slope(series, count, tau, &value, &slope);
        if (value <= error && !near) {
            if (crosses(slope, bound, 2 * error)) {
                Real zero = sharp ? zero_ahead(series, count, tau, value, slope, bound, t0) : newton(tau, value, slope);
                *end = t0 + zero;
                return zero <= h ? ZERO : POSITIVE;
            }
            near = 1;
            doubt(c, t0, t, TOUCH_OR_MISS, c->watched, NOTHING);
        }
        if (near)
            floor = noise = noise_at(series, count, tau);
        if (value < -noise || (value <= noise && slope <= 0)) {
            *end = t;
            return ZERO;
        }
        room = value > floor ? value - floor : 0.0;
        step = safe_step(room, slope, bound);
        if (step > h)
            return POSITIVE;
        if (i >= LONG_MARCH)
            step = nearer_step(series, count, tau, room, slope, step, h);
        ahead = t0 + (tau + step);
        if (ahead <= t) {
            if (slope < 0) {
                const int crossing = crosses(slope, bound, 2 * error);
                if (!crossing && !near) /* it stays at the bound of its rounding, not at zero */
                    doubt(c, t0, t, TOUCH_OR_MISS, c->watched, NOTHING);
                *end = t0 + (sharp && crossing ? zero_ahead(series, count, tau, value, slope, bound, t0)
                                               : newton(tau, value, slope));
                return ZERO;
            }
            doubt(c, t0, t, TOO_SHORT_STEPS, c->watched, NOTHING);
            ahead = t + (nextafter(t, INFINITY) - t) * stall;
            stall = stall * 2;
        } else {
            stall = 1.0;
        }
        t = ahead;
    }
    *end = t;
    return UNFINISHED;
}

typedef struct {
    const Real *slopes;
    int count;
} Slopes;

static void slope_at(void *function, Real tau, Real *slope, Real *curvature)
{
    const Slopes *of = (const Slopes *)function;
    value_and_slope(of->slopes, of->count, tau, slope, curvature);
}

/* Keep the minimum of a gap function between two points of a step, at which its slopes fall and rise. */
static void turn_between(Certificate *c, const Real *series, const Real *slopes, int count, Real t0, Real low, Real high)
{
    Slopes of;
    Real tau, turn, depth, value, unused;
    of.slopes = slopes;
    of.count = count - 1;
    turning_point(slope_at, &of, low, high, (high - low) * power_of_two(binary_exponent(EPS) / 3.0), &tau, &turn, &depth);
    value_and_slope(series, count, tau, &value, &unused);
    keep_turn(c, value - depth, t0 + turn);
}

/* Keep the smallest minimum of a gap function up to `stop` within a step: slopes at PIECES points tell where. */
static void watch_turns(Certificate *c, const Real *series, int count, Real t0, Real stop)
{
    Series slopes;
    Real low = 0 * stop, falling, rising, unused;
    int n, i;
    slopes[0] = 0.0;
    for (n = 1; n < count; n++)
        slopes[n - 1] = n * series[n];
    n = 0;
    while (n < count - 2 && slopes[n] == 0)
        n++;
    falling = slopes[n];
    for (i = 1; i <= PIECES; i++) {
        Real high = stop * i / PIECES;
        value_and_slope(slopes, count - 1, high, &rising, &unused);
        if (falling < 0 && 0 <= rising)
            turn_between(c, series, slopes, count, t0, low, high);
        low = high;
        falling = rising;
    }
}

/* Bound of the slope (order 1) or curvature (order 2) within h, times h to that power. */
static Magnitude bend_of(const Real *series, int count, int order, Power h)
{
    Magnitude total = 0.0;
    Power power = h;
    int n;
    for (n = 1; n < count; n++) {
        if (n >= order)
            total = total + (order == 1 ? n : n * (n - 1)) * term_size(series[n], power);
        power = next_power(power, h);
    }
    return total * INFLATED;
}

/* Whether f = t^order sum b_n t^n may have a minimum within h; not where it is plainly monotonic. total: sum |b_n| h^n. */
static int may_turn(const Real *series, int count, int order, Real total, Real h)
{
    const Magnitude swing = bend_of(series, count, 1, power_of(h));
    if (order > 0)
        return order * series[0] <= swing + order * (total - series[0]);
    return count > 1 && 2 * fabs(series[1]) * h <= swing;
}

/* Order of the zero at the start: `known`, or beyond it as long as coefficients are exactly zero; `count` where all are. */
static int order_of_zero(const Real *coefficients, int count, int known)
{
    int order = known < count ? known : count;
    while (order < count && coefficients[order] == 0)
        order++;
    return order;
}

/* Value, slope and rounding bound at tau of the polynomial without its known zeros, divided by that power of tau; 0 where it rests at
 * zero. size: sum of the magnitudes that coefficient 0 is made of, where that is not known to be zero.
 */
int polynomial_near_zero(const Real *coefficients, int count, int known, Real tau, Real size, Real *value,
                         Real *slope, Real *noise)
{
    const int order = order_of_zero(coefficients, count, known);
    if (order == count)
        return 0;
    value_and_slope(coefficients + order, count - order, tau, value, slope);
    *noise = noise_at(coefficients + order, count - order, tau);
    if (order == 0)
        *noise = *noise + 4 * EPS * size;
    return 1;
}

/* The step h, or a shorter one where rounding over all of h would hide on which side of zero the function begins, though its value
 * there tells. size: sum of the magnitudes that coefficient 0 is made of.
 */
Real polynomial_nearer(const Real *coefficients, int count, Real t0, Real h, Real size)
{
    Real start = coefficients[0], least = SHORTEST * (nextafter(t0, INFINITY) - t0);
    if (!(start > BEYOND * EPS * size))
        return h;
    while (h > least && start <= BEYOND * EPS * sizes_at(coefficients, count, h))
        h = h / SHORTER;
    return h;
}

/* How far the polynomial in t - t0 is known to be positive: on the whole step h (POSITIVE), or up to the time `end` on the grid,
 * where it is zero (ZERO) or the march was too long (UNFINISHED). Coefficients lowest first; positive at the start but for a zero
 * there of order `known`. keep_margin: look for a grazing minimum before the root or the end of the step; sharp: go to the zero by
 * more than one Newton step where that is not as near as the grid of time allows.
 *
 * The error is the rounding of the values, and what follows the last term: bounded by the last two as long as terms fall to less
 * than 0.7 of the one before; the step control lets them fall to tol^(1/order), 0.16 by default.
 */
int polynomial_first_root(Certificate *c, const Real *coefficients, int count, int known, Real t0, Real h, int keep_margin,
                          int sharp, Real *end)
{
    const Real *series;
    const Power step = power_of(h);
    Magnitude total, fall, term = 0.0, before = 0.0;
    Power power = step;
    Real error;
    int order = order_of_zero(coefficients, count, known), n, outcome = POSITIVE;
    if (order == count)
        return POSITIVE;
    series = coefficients + order;
    count = count - order;
    total = (Magnitude)fabs(series[0]);
    fall = 0.0;
    for (n = 1; n < count; n++) {
        before = term;
        term = term_size(series[n], power);
        total = total + term;
        fall = n > 1 || series[1] < 0 ? fall + term : fall;
        power = next_power(power, step);
    }
    fall = fall * INFLATED;
    error = 4 * EPS * total + (before + term);
    if (series[0] - error - fall <= 0)
        outcome = march(c, series, count, error, bend_of(series, count, 2, step) / (h * h), t0, h, sharp, end);
    if (keep_margin && series[0] - fall < c->margin &&
        may_turn(series, count, order, total, h))
        watch_turns(c, coefficients, count + order, t0, outcome == POSITIVE ? h : *end - t0);
    return outcome;
}
