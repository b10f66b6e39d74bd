/* Event functions of the closed-form flow, at the point whose jets were taken last and to the orders that those were taken for:
 * derivatives, bounds of them ahead, and rounding bounds. Sums of one term are evaluated here, others term by term.
 */
#ifndef VIBSIM_EVENT_FUNCTIONS_H
#define VIBSIM_EVENT_FUNCTIONS_H

#include "engine.h"

/* Sizes: WITHIN_REACH, a bound up to `reach` from here; else what rounding is proportional to, by a measure of that of coordinates, see
 * rounding.c.
 */
enum { WITHIN_REACH = MEASURES };

/* event_functions.c; of `count` terms from number `first`: the n-th derivative of their sum, and its size. */
Real sum_of_terms(const Run *r, int first, int count, int n);
Real size_of_sum(const Run *r, int first, int count, int n, int measure, Real reach);

/* n-th derivative of the coordinate, or the two, that a sum of one term reads. */
static inline Real single_difference(const Run *r, const Single *s, int n)
{
    const Motion *motions = r->closed_form.motions;
    Real y = s->share * motions[s->m].jet[n];
    return s->other < 0 ? y : y + s->other_share * motions[s->other].jet[n];
}

/* n-th derivative of a sum of terms. */
static inline Real sum_derivative(const Run *r, const Single *s, int first, int count, int n)
{
    Real force;
    if (s->kind == NOTHING)
        return sum_of_terms(r, first, count, n);
    if (s->kind != COUPLING)
        return s->coefficient * single_difference(r, s, n + (s->kind == RATE));
    force = s->k * single_difference(r, s, n) + s->c * single_difference(r, s, n + 1);
    return s->coefficient * (n == 0 ? force + s->offset : force);
}

/* n-th time derivative of an event function, n >= 0. That of a sliding velocity is, for n > 0, a sum over groups: forces by
 * masses.
 */
static inline Real event_derivative(const Run *r, const Event *e, int n)
{
    Real value, total = 0.0;
    int i, k;
    if (n == 0 || e->slopes == 0) {
        value = sum_derivative(r, &e->single, e->first, e->terms, n);
        return n == 0 ? value + e->constant : value;
    }
    for (i = 0; i < e->slopes; i++) {
        const Slope *s = &r->mode->slopes[e->first_slope + i];
        Real force = sum_derivative(r, &s->single, s->first, s->terms, n - 1), part;
        if (n == 1)
            for (k = 0; k < s->constants; k++)
                force = force + r->mode->slope_constants[s->first_constant + k];
        part = s->factor * force / s->mass;
        total = i == 0 ? part : total + part;
    }
    return total;
}

/* Bound of |q^(n)| up to `reach` ahead. q^(n) obeys the same oscillator: its free part stays below both the energy and the
 * ballistic bound, the forced part below |R| omega^n reach^2 / 2, R the amplitude, because the impulse response S(t) is no larger
 * than t.
 */
static inline Real coordinate_bound(const Run *r, int m, int n, Real reach)
{
    const Coordinate *c = &r->mode->modal->coordinates[m];
    const Real *d = r->closed_form.motions[m].jet;
    Real w0 = c->oscillator.w0, size = fabs(d[n]) + fabs(d[n + 1]) * reach;
    if (w0 > 0) {
        Real energy = fabs(d[n]) + fabs(d[n + 1]) / w0;
        if (energy < size)
            size = energy;
    }
    return size + c->forced[n] * (reach * reach);
}

/* Size of the n-th derivative of a coordinate; of its rounding n < 3. */
static inline Real coordinate_size(const Run *r, int m, int n, int measure, Real reach)
{
    const Scale *y;
    if (measure == WITHIN_REACH)
        return coordinate_bound(r, m, n, reach);
    y = &r->closed_form.scales[measure][m];
    return n == 0 ? y->q : n == 1 ? y->u : y->a;
}

/* Size of the n-th derivative of `single_difference`. */
static inline Real single_size(const Run *r, const Single *s, int n, int measure, Real reach)
{
    Real y = fabs(s->share) * coordinate_size(r, s->m, n, measure, reach);
    return s->other < 0 ? y : y + fabs(s->other_share) * coordinate_size(r, s->other, n, measure, reach);
}

/* Size of the n-th derivative of a sum of terms. */
static inline Real sum_size(const Run *r, const Single *s, int first, int count, int n, int measure, Real reach)
{
    Real size;
    if (s->kind == NOTHING)
        return size_of_sum(r, first, count, n, measure, reach);
    size = single_size(r, s, n + (s->kind == RATE), measure, reach);
    if (s->kind == COUPLING) {
        size = s->k * size + s->c * single_size(r, s, n + 1, measure, reach);
        size = n == 0 ? size + fabs(s->offset) : size;
    }
    return fabs(s->coefficient) * size;
}

/* Bound of the n-th derivative of an event function up to `reach` ahead, n >= 2. */
static inline Real event_bound(const Run *r, const Event *e, int n, Real reach)
{
    Real total = 0.0;
    int i;
    if (e->slopes == 0)
        return sum_size(r, &e->single, e->first, e->terms, n, WITHIN_REACH, reach);
    for (i = 0; i < e->slopes; i++) {
        const Slope *s = &r->mode->slopes[e->first_slope + i];
        Real part = fabs(s->factor) * sum_size(r, &s->single, s->first, s->terms, n - 1, WITHIN_REACH, reach) / s->mass;
        total = i == 0 ? part : total + part;
    }
    return total;
}

/* Rounding of an event function in units of its scale: that of some operations, and of phases, eps times the angle since the
 * anchor.
 */
static inline Real rounding_unit(const Run *r)
{
    return EPS * (16 + r->mode->modal->pace * r->closed_form.tau);
}

/* What the rounding of an event function is proportional to, by a measure of that of coordinates. */
static inline Real event_scale(const Run *r, const Event *e, int measure)
{
    return sum_size(r, &e->single, e->first, e->terms, 0, measure, 0) + e->size;
}

#endif
