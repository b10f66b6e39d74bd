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

/* Size of the forces on a column, or a bound of their n-th derivative. */
static Real load_size(const Run *r, int column, int n)
{
    Real total = 0.0;
    int i;
    for (i = 0; i < r->force_count; i++)
        if (r->forces[i].on == column)
            total = harmonics_bound(total, r->forces[i].terms, r->forces[i].count, n);
    for (i = 0; n == 0 && i < r->force_count; i++)
        if (r->forces[i].on == column)
            total = total + fabs(r->forces[i].constant);
    return total;
}

/* Size of the n-th derivative of what a place has of the coordinates, which is added to `total`. */
static Real shares_size(const Run *r, Real total, const Place *p, int n, int measure, Real reach)
{
    int i;
    for (i = 0; i < p->shares; i++)
        total = total + fabs(p->share[i].share) * coordinate_size(r, p->share[i].m, n, measure, reach);
    return total;
}

/* Size of the n-th derivative of x_P - x_Q. */
static Real difference_size(const Run *r, int pair, int n, int measure, Real reach)
{
    const Modal *modal = r->mode->modal;
    const Place *p = &modal->pairs[pair];
    Real total = shares_size(r, 0.0, p, n, measure, reach);
    int i;
    for (i = 0; n == 0 && i < p->fixed; i++)
        total = total + fabs(r->closed_form.x0[modal->fixed[p->first_fixed + i].column]);
    return p->base ? total + harmonics_bound(0.0, r->base, r->base_count, n) : total;
}

/* Size of the n-th derivative of a term, without its coefficient. The plain measure says nothing of accelerations: of these a bound over
 * the window serves.
 */
static Real size_of_term(const Run *r, const Term *t, int n, int measure, Real reach)
{
    const Place *place;
    switch (t->kind) {
    case DIFFERENCE:
        return difference_size(r, t->pair, n, measure, reach);
    case RATE:
        return difference_size(r, t->pair, n + 1, measure, reach);
    case COUPLING: {
        const Coupling *c = &r->mode->couplings[t->P];
        Real force = c->k * difference_size(r, c->pair, n, measure, reach) + c->c * difference_size(r, c->pair, n + 1, measure, reach);
        return n == 0 ? force + fabs(c->offset) : force;
    }
    case LOAD:
        return load_size(r, t->P, n);
    default:
        if (measure == PLAIN) {
            measure = WITHIN_REACH;
            reach = r->mode->modal->window;
        }
        place = &r->mode->modal->places[t->P];
        return shares_size(r, place->base ? harmonics_bound(0.0, r->base, r->base_count, n + 2) : 0.0, place, n + 2, measure, reach);
    }
}

Real size_of_sum(const Run *r, int first, int count, int n, int measure, Real reach)
{
    const Term *terms = r->mode->terms + first;
    Real total = 0.0;
    int i;
    for (i = 0; i < count; i++) {
        Real part = fabs(terms[i].coefficient) * size_of_term(r, &terms[i], n, measure, reach);
        total = i == 0 ? part : total + part;
    }
    return total;
}
