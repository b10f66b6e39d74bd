/* How long a Taylor step may be, and of which order the next one is. */
#include "engine.h"
#include "inlining.h"
#include "numbers.h"
#include "tape_series.h"

/* Orders from one to the next that is tried, the least of them; each is kept for so many steps, and left for one by which the motion gets
 * so much further in the time that computing takes. A step takes as long as so many orders beside its own ones.
 */
#define ORDERS_LESS 3
#define LEAST_ORDER 8
#define STEPS_OF_AN_ORDER 8
#define ORDERS_OF_A_STEP 9
#define FASTER 1.1
#define MUCH_FASTER 1.2

/* Binary exponent of the summed rates of one order: of the bodies, and of the base where it moves. */
static int size_of_rates(const Run *r, int n, int none)
{
    const Taylor *f = &r->taylor;
    const Real *row = f->table + n * f->stride + f->rates;
    Real total = fabs(row[0]);
    int c;
    (void)none;
    for (c = 1; c < r->bodies; c++)
        total = total + fabs(row[c]);
    if (r->has_base)
        total = total + fabs(row[base_column(r)]);
    return binary_exponent(total);
}

/* The same of the bodies alone, where other columns have units of their own; of the first of these where there is no body. */
static int size_of_bodies(const Run *r, int n, int none)
{
    const Taylor *f = &r->taylor;
    const Real *row = f->table + n * f->stride + f->rates;
    Real total = 0.0;
    int c, k = 0, first = 1;
    (void)none;
    for (c = 0; c < r->bodies; c++) {
        if (k < r->alone_count && r->alone[k] == c) {
            k++;
            if (r->alone_count < r->bodies || k > 1)
                continue;
        }
        total = first ? fabs(row[c]) : total + fabs(row[c]);
        first = 0;
    }
    if (r->has_base)
        total = total + fabs(row[base_column(r)]);
    return binary_exponent(total);
}

/* Of the sine of rotor i: nothing else tells how a rotor turns on what does not move on its own. */
static int size_of_turning(const Run *r, int n, int i)
{
    return binary_exponent(fabs(series_along(r->rotors.sine, i)[n]));
}

static int size_of_rate(const Run *r, int n, int c)
{
    const Taylor *f = &r->taylor;
    return binary_exponent(fabs(f->table[n * f->stride + f->rates + c]));
}

static int size_of_speed(const Run *r, int n, int none)
{
    (void)none;
    return binary_exponent(fabs(r->taylor.w_back[r->taylor.order - n]));
}

static int size_of_sine(const Run *r, int n, int none)
{
    (void)none;
    return binary_exponent(fabs(r->taylor.sine[n]));
}

static int size_of_load(const Run *r, int n, int c)
{
    return binary_exponent(fabs(r->taylor.loaded_on[c][n]));
}

/* Order of the first term that is not zero of the series number c, up to `highest`, or the order behind that. */
static int order_of_first(const Run *r, int (*size)(const Run *, int, int), int c, int highest)
{
    int n = 0;
    while (n <= highest && size(r, n, c) <= NO_EXPONENT)
        n++;
    return n;
}

/* Binary exponent of the step that the terms of order `highest` and the one before allow of a series, of the number c that `size` tells
 * of, that begins so flat that its LEADING_TERMS first terms are zero: as `longest_step`, from those that follow. Where there is none
 * before them, the step is so short against the run that the next series does not begin at zero.
 */
APART double longest_flat_step(const Run *r, int (*size)(const Run *, int, int), int c, int highest, double longest)
{
    const int first = order_of_first(r, size, c, highest);
    int last, m;
    for (last = highest - 1; last <= highest; last++) {
        const int following = size(r, last, c);
        double best = r->tolerance_exponent + binary_exponent(r->t_end);
        if (following <= NO_EXPONENT)
            continue;
        for (m = first; m < first + LEADING_TERMS && m < last; m++) {
            const int exponent = size(r, m, c);
            const double step = (r->tolerance_exponent + (exponent - following)) / (last - m);
            if (exponent > NO_EXPONENT && (m == first || step > best))
                best = step;
        }
        longest = best < longest ? best : longest;
    }
    return longest;
}

/* Binary exponent of the step that the terms of order `highest` and the one before allow, of the series number c that `size` tells
 * of: they stay below the tolerance times the largest of the leading ones (after Jorba & Zou 2005). At most `longest`.
 */
INLINE double longest_step(const Run *r, int (*size)(const Run *, int, int), int c, int highest, double longest)
{
    double leading[LEADING_TERMS], allowed = longest;
    int flat = 0, last, m;
    for (m = 0; m < LEADING_TERMS; m++) {
        int exponent = size(r, m, c);
        leading[m] = exponent > NO_EXPONENT ? exponent : -INFINITY; /* a term that is zero allows nothing by itself */
    }
    for (last = highest - 1; last <= highest; last++) {
        int following = size(r, last, c);
        if (following > NO_EXPONENT) {
            double steps[LEADING_TERMS], best = -INFINITY;
            for (m = 0; m < LEADING_TERMS; m++) /* side by side: most of the time goes into the quotients */
                steps[m] = (r->tolerance_exponent + (leading[m] - following)) / (last - m);
            for (m = 0; m < LEADING_TERMS && m < last; m++)
                best = steps[m] > best ? steps[m] : best;
            flat = flat || best == -INFINITY;
            longest = best > -INFINITY && best < longest ? best : longest;
        }
    }
    return flat ? longest_flat_step(r, size, c, highest, allowed) : longest;
}

/* Step that the velocities of bodies allow, each column of units of its own, and the turning of rotors on what does not move on its
 * own. APART, so that scenes without such columns keep their registers.
 */
APART double step_of_columns(const Run *r)
{
    double longest = longest_step(r, size_of_bodies, 0, r->taylor.order, 1000.0);
    int i;
    for (i = r->alone_count < r->bodies ? 0 : 1; i < r->alone_count; i++)
        longest = longest_step(r, size_of_rate, r->alone[i], r->taylor.order, longest);
    for (i = 0; i < r->rotors.count; i++)
        if (r->mode->leader[r->rotors.of[i].on] >= r->bodies)
            longest = longest_step(r, size_of_turning, i, r->taylor.order, longest);
    return longest;
}

/* Longest step that velocities, rotor, and what ties must carry, which moves nothing, allow; infinite where nothing limits it. */
Real step_length(const Run *r)
{
    double longest;
    int i;
    if (r->alone_count + r->rotors.count == 0)
        longest = longest_step(r, size_of_rates, 0, r->taylor.order, 1000.0);
    else
        longest = step_of_columns(r);
    if (r->has_motor) {
        longest = longest_step(r, size_of_speed, 0, r->taylor.order, longest);
        if (r->mode->carried == 0)
            longest = longest_step(r, size_of_sine, 0, r->taylor.order, longest);
    }
    for (i = 0; i < r->mode->tied_count; i++)
        longest = longest_step(r, size_of_load, r->mode->tied[i], r->taylor.order - 1, longest);
    return longest < 1000.0 ? power_of_two(longest) : (Real)INFINITY;
}

#ifdef LIMBS
void tune_order(Run *r) { r->taylor.next = r->taylor.order; }
#else
/* Longest step at another order than that of the series in hand. */
static double step_at_order(Run *r, int order)
{
    const int now = r->taylor.order;
    double h;
    r->taylor.order = order;
    h = step_length(r);
    r->taylor.order = now;
    return h;
}

/* The order of the next step of the stretch. Where formulas move it that may be another one: the one by which the motion gets furthest
 * in the time that computing takes. A stiff state, as of a bristle, leaves nothing in the last terms but the rounding of the first ones,
 * which keeps a step of high order as short as one of low order.
 */
void tune_order(Run *r)
{
    Taylor *f = &r->taylor;
    const int lower = f->order - ORDERS_LESS;
    double here, there;
    f->next = f->order;
    f->since += 1;
    if (r->has_motor || r->mode->shape != FORMULAS || f->most - ORDERS_LESS < LEAST_ORDER || f->since % STEPS_OF_AN_ORDER != 0)
        return;
    here = step_at_order(r, f->order) / (ORDERS_OF_A_STEP + f->order);
    there = step_at_order(r, lower) / (ORDERS_OF_A_STEP + lower);
    if (there > FASTER * here && lower >= LEAST_ORDER)
        f->next = lower;
    else if (here > MUCH_FASTER * there && f->order < f->most)
        f->next = f->order + ORDERS_LESS;
}
#endif
