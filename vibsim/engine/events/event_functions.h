/* Event functions of the closed-form flow, at the point whose jets were taken last and to the orders that those were taken for:
 * derivatives, bounds of them ahead, and rounding bounds. Sums of one term are evaluated here, others term by term.
 */
#ifndef VIBSIM_EVENT_FUNCTIONS_H
#define VIBSIM_EVENT_FUNCTIONS_H

#include "engine.h"

/* event_functions.c; of `count` terms from number `first`: the n-th derivative of their sum, a bound of it up to `reach` ahead, and
 * what the rounding of the sum is proportional to, by a measure of that of coordinates (see rounding.c).
 */
Real sum_of_terms(const Run *r, int first, int count, int n);
Real bound_of_sum(const Run *r, int first, int count, int n, Real reach);
Real scale_of_sum(const Run *r, int first, int count, int measure);

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

/* Bound of the n-th derivative of `single_difference` up to `reach` ahead. */
static inline Real single_difference_bound(const Run *r, const Single *s, int n, Real reach)
{
    Real y = fabs(s->share) * coordinate_bound(r, s->m, n, reach);
    return s->other < 0 ? y : y + fabs(s->other_share) * coordinate_bound(r, s->other, n, reach);
}

/* Bound of the n-th derivative of a sum of terms up to `reach` ahead, its constant left out. */
static inline Real sum_bound(const Run *r, const Single *s, int first, int count, int n, Real reach)
{
    Real size;
    if (s->kind == NOTHING)
        return bound_of_sum(r, first, count, n, reach);
    size = single_difference_bound(r, s, n + (s->kind == RATE), reach);
    if (s->kind == COUPLING)
        size = s->k * size + s->c * single_difference_bound(r, s, n + 1, reach);
    return fabs(s->coefficient) * size;
}

/* Bound of the n-th derivative of an event function up to `reach` ahead, n >= 2. */
static inline Real event_bound(const Run *r, const Event *e, int n, Real reach)
{
    Real total = 0.0;
    int i;
    if (e->slopes == 0)
        return sum_bound(r, &e->single, e->first, e->terms, n, reach);
    for (i = 0; i < e->slopes; i++) {
        const Slope *s = &r->mode->slopes[e->first_slope + i];
        Real part = fabs(s->factor) * sum_bound(r, &s->single, s->first, s->terms, n - 1, reach) / s->mass;
        total = i == 0 ? part : total + part;
    }
    return total;
}

/* What the rounding of `single_difference` is proportional to; order 1: of its rate. */
static inline Real single_scale(const Run *r, const Single *s, int order, int measure)
{
    const Scale *y = &r->closed_form.scales[measure][s->m];
    const Scale *other = s->other < 0 ? y : &r->closed_form.scales[measure][s->other];
    Real size = fabs(s->share) * (order ? y->u : y->q);
    return s->other < 0 ? size : size + fabs(s->other_share) * (order ? other->u : other->q);
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
    const Single *s = &e->single;
    Real size;
    if (e->terms == 0)
        return e->size;
    if (s->kind == NOTHING)
        return scale_of_sum(r, e->first, e->terms, measure) + e->size;
    size = single_scale(r, s, s->kind == RATE, measure);
    if (s->kind == COUPLING)
        size = s->k * size + s->c * single_scale(r, s, 1, measure) + fabs(s->offset);
    return fabs(s->coefficient) * size + e->size;
}

#endif
