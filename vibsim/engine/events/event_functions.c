/* Event functions of the closed-form flow; see event_functions.h. */
#include "event_functions.h"

/* n-th derivative of x_P - x_Q of a pair of columns; what does not move counts in the displacement alone. */
static Real difference(const Run *r, int pair, int n)
{
    const ClosedForm *f = &r->closed_form;
    const Modal *modal = r->mode->modal;
    const Place *p = &modal->pairs[pair];
    Real total = 0.0;
    int i;
    for (i = 0; i < p->shares; i++) {
        const Share *share = &modal->shares[p->first_share + i];
        Real part = share->share * f->motions[share->m].jet[n];
        total = i == 0 ? part : total + part;
    }
    if (n == 0)
        for (i = 0; i < p->fixed; i++) {
            const Fixed *fixed = &modal->fixed[p->first_fixed + i];
            total = total + fixed->sign * f->x0[fixed->column];
        }
    return p->base ? total + p->base * f->base[n] : total;
}

/* n-th derivative of the force on a column. */
static Real load_derivative(const Run *r, int column, int n)
{
    const ClosedForm *f = &r->closed_form;
    Real total = 0.0;
    int i, j, k;
    for (i = 0; i < r->force_count; i++) {
        const Force *force = &r->forces[i];
        if (force->on != column)
            continue;
        if (n == 0)
            total = total + force->constant;
        for (j = 0; j < force->count; j++) {
            const Harmonic *term = &force->terms[j];
            Real factor = term->amplitude;
            if (term->harmonic < 0)
                continue;
            for (k = 0; k < n; k++)
                factor = factor * term->omega;
            total = total + factor * harmonic_turned(f, term, n);
        }
    }
    return total;
}

/* n-th derivative of x_c, n > 0. */
static Real column_derivative(const Run *r, int c, int n)
{
    const Modal *modal = r->mode->modal;
    const Place *place = &modal->places[c];
    Real total = place->base ? r->closed_form.base[n] : 0.0;
    int i;
    for (i = 0; i < place->shares; i++) {
        const Share *share = &modal->shares[place->first_share + i];
        total = total + share->share * r->closed_form.motions[share->m].jet[n];
    }
    return total;
}

/* n-th derivative of a term of an event function, without its coefficient. */
static Real term_derivative(const Run *r, const Term *t, int n)
{
    switch (t->kind) {
    case DIFFERENCE:
        return difference(r, t->pair, n);
    case RATE:
        return difference(r, t->pair, n + 1);
    case COUPLING: {
        const Coupling *c = &r->mode->couplings[t->P];
        Real force = c->k * difference(r, c->pair, n) + c->c * difference(r, c->pair, n + 1);
        return n == 0 ? force + c->offset : force;
    }
    case LOAD:
        return load_derivative(r, t->P, n);
    default:
        return column_derivative(r, t->P, n + 2);
    }
}

Real sum_of_terms(const Run *r, int first, int count, int n)
{
    const Term *terms = r->mode->terms + first;
    Real total = 0.0;
    int i;
    for (i = 0; i < count; i++) {
        Real part = terms[i].coefficient * term_derivative(r, &terms[i], n);
        total = i == 0 ? part : total + part;
    }
    return total;
}

/* Bound of the n-th derivative of a sum of harmonics at any time: sum of |amplitude| omega^n, which is added to `total`. */
static Real harmonics_bound(Real total, const Harmonic *terms, int count, int n)
{
    int i, k;
    for (i = 0; i < count; i++) {
        Real size = fabs(terms[i].amplitude);
        for (k = 0; k < n; k++)
            size = size * terms[i].omega;
        total = total + size;
    }
    return total;
}

/* The same of the forces on a column, without their constants. */
static Real load_bound(const Run *r, int column, int n)
{
    Real total = 0.0;
    int i;
    for (i = 0; i < r->force_count; i++)
        if (r->forces[i].on == column)
            total = harmonics_bound(total, r->forces[i].terms, r->forces[i].count, n);
    return total;
}

/* Bound of the n-th derivative of what a place has of the coordinates up to `reach` ahead, which is added to `total`. */
static Real shares_bound(const Run *r, Real total, const Place *p, int n, Real reach)
{
    int i;
    for (i = 0; i < p->shares; i++)
        total = total + fabs(p->share[i].share) * coordinate_bound(r, p->share[i].m, n, reach);
    return total;
}

/* Bound of the n-th derivative of x_P - x_Q up to `reach` ahead. */
static Real difference_bound(const Run *r, int pair, int n, Real reach)
{
    const Place *p = &r->mode->modal->pairs[pair];
    Real total = shares_bound(r, 0.0, p, n, reach);
    return p->base ? total + harmonics_bound(0.0, r->base, r->base_count, n) : total;
}

/* Bound of the n-th derivative of a term up to `reach` ahead, without its coefficient. */
static Real term_bound(const Run *r, const Term *t, int n, Real reach)
{
    const Place *place;
    switch (t->kind) {
    case DIFFERENCE:
        return difference_bound(r, t->pair, n, reach);
    case RATE:
        return difference_bound(r, t->pair, n + 1, reach);
    case COUPLING: {
        const Coupling *c = &r->mode->couplings[t->P];
        Real force = c->k * difference_bound(r, c->pair, n, reach);
        return force + c->c * difference_bound(r, c->pair, n + 1, reach);
    }
    case LOAD:
        return load_bound(r, t->P, n);
    default:
        place = &r->mode->modal->places[t->P];
        return shares_bound(r, place->base ? harmonics_bound(0.0, r->base, r->base_count, n + 2) : 0.0, place, n + 2, reach);
    }
}

Real bound_of_sum(const Run *r, int first, int count, int n, Real reach)
{
    const Term *terms = r->mode->terms + first;
    Real total = 0.0;
    int i;
    for (i = 0; i < count; i++) {
        Real part = fabs(terms[i].coefficient) * term_bound(r, &terms[i], n, reach);
        total = i == 0 ? part : total + part;
    }
    return total;
}

/* What the rounding of the n-th derivative, n < 3, of what a place has of the coordinates is proportional to, by a measure of that of
 * these; it is added to `total`.
 */
static Real shares_scale(const Run *r, Real total, const Place *p, int n, int measure)
{
    int i;
    for (i = 0; i < p->shares; i++) {
        const Scale *y = &r->closed_form.scales[measure][p->share[i].m];
        total = total + fabs(p->share[i].share) * (n == 0 ? y->q : n == 1 ? y->u : y->a);
    }
    return total;
}

/* The same of x_P - x_Q (order 0) or of its rate (order 1). */
static Real difference_scale(const Run *r, int pair, int order, int measure)
{
    const Modal *modal = r->mode->modal;
    const Place *p = &modal->pairs[pair];
    Real total = shares_scale(r, 0.0, p, order, measure);
    int i;
    if (order == 0)
        for (i = 0; i < p->fixed; i++)
            total = total + fabs(r->closed_form.x0[modal->fixed[p->first_fixed + i].column]);
    return p->base ? total + harmonics_bound(0.0, r->base, r->base_count, order) : total;
}

/* The same of the acceleration of a column, which the close measure knows. */
static Real acceleration_scale(const Run *r, const Term *t, int measure)
{
    const Place *place = &r->mode->modal->places[t->P];
    return shares_scale(r, place->base ? harmonics_bound(0.0, r->base, r->base_count, 2) : 0.0, place, 2, measure);
}

/* The same of a term. The plain measure says nothing of accelerations: of these a bound over the window serves. */
static Real term_scale(const Run *r, const Term *t, int measure)
{
    switch (t->kind) {
    case DIFFERENCE:
        return difference_scale(r, t->pair, 0, measure);
    case RATE:
        return difference_scale(r, t->pair, 1, measure);
    case COUPLING: {
        const Coupling *c = &r->mode->couplings[t->P];
        Real force = c->k * difference_scale(r, c->pair, 0, measure);
        return force + c->c * difference_scale(r, c->pair, 1, measure) + fabs(c->offset);
    }
    case LOAD: {
        Real total = load_bound(r, t->P, 0);
        int i;
        for (i = 0; i < r->force_count; i++)
            if (r->forces[i].on == t->P)
                total = total + fabs(r->forces[i].constant);
        return total;
    }
    default:
        if (measure == PLAIN)
            return term_bound(r, t, 0, r->mode->modal->window);
        return acceleration_scale(r, t, measure);
    }
}

Real scale_of_sum(const Run *r, int first, int count, int measure)
{
    const Term *terms = r->mode->terms + first;
    Real total = 0.0;
    int i;
    for (i = 0; i < count; i++) {
        Real part = fabs(terms[i].coefficient) * term_scale(r, &terms[i], measure);
        total = i == 0 ? part : total + part;
    }
    return total;
}
