/* Event functions as polynomials over a Taylor step. */
#include <string.h>

#include "engine.h"

/* Series of the load on a column: its forces, and what a motor on it exerts while it is tied to the ground or the base. */
static void load_on(const Run *r, int column, Real *out)
{
    const Taylor *f = &r->taylor;
    const Real *load = f->loaded_on[column];
    Series sw;
    int n, i;
    for (n = 0; n < f->order; n++)
        out[n] = load ? load[n] : 0.0;
    if (r->rotors.count > 0)
        rotors_thrust(r, column, out);
    if (!r->has_motor || r->motor_on != column)
        return;
    for (n = 0; n <= f->order; n++) {
        sw[n] = 0.0;
        for (i = 0; i <= n; i++)
            sw[n] = sw[n] + f->sine[i] * f->w_back[f->order - (n - i)];
    }
    for (n = 0; n < f->order; n++)
        out[n] = out[n] + (r->unbalance * ((n + 1) * sw[n + 1]) - r->m3 * f->a1_back[f->order - n]);
}

/* a - b, where a column without place in the table is zero throughout. */
static void plain_difference(const Real *row, int stride, int a, int b, int count, Real *restrict out)
{
    int n;
    if (b < 0) {
        for (n = 0; n < count; n++, row += stride)
            out[n] = row[a];
    } else if (a < 0) {
        for (n = 0; n < count; n++, row += stride)
            out[n] = 0.0 - row[b];
    } else {
        for (n = 0; n < count; n++, row += stride)
            out[n] = row[a] - row[b];
    }
}

/* factor (a - b); most factors are 1. */
static void difference(const Real *row, int stride, int a, int b, Real factor, int count, Real *restrict out)
{
    int n;
    plain_difference(row, stride, a, b, count, out);
    if (factor == -1)
        for (n = 0; n < count; n++)
            out[n] = -out[n];
    else if (factor != 1)
        for (n = 0; n < count; n++)
            out[n] = factor * out[n];
}

/* factor times the series of the force of a coupling, whose offset counts in order 0. */
static void coupling_force(const Coupling *c, const Taylor *f, Real factor, int count, Real *restrict out)
{
    const Real *a = f->table + c->from, *b = f->table + c->to, k = c->k, damping = c->c;
    const int stride = f->stride, rates = f->rates;
    int n;
    out[0] = factor * (k * (*a - *b) + damping * (a[rates] - b[rates]) + c->offset);
    for (n = 1; n < count; n++) {
        a += stride;
        b += stride;
        out[n] = factor * (k * (*a - *b) + damping * (a[rates] - b[rates]));
    }
}

/* Series of a term of an event function over the step; returns its number of coefficients, fewer where derivatives are read. */
int taylor_term(const Run *r, const Term *t, Real *out)
{
    const Taylor *f = &r->taylor;
    const int p = f->order;
    const Real *row;
    int n;
    switch (t->kind) {
    case DIFFERENCE:
        difference(f->table, f->stride, t->from, t->to, t->coefficient, p + 2, out);
        return p + 2;
    case RATE:
        difference(f->table, f->stride, t->from, t->to, t->coefficient, p + 1, out);
        return p + 1;
    case COUPLING:
        coupling_force(&r->mode->couplings[t->P], f, t->coefficient, p + 1, out);
        return p + 1;
    case ACCELERATION:
        row = f->table + f->rates + column_in_table(r, t->P);
        for (n = 0; n < p; n++)
            out[n] = t->coefficient * ((n + 1) * row[(n + 1) * f->stride]);
        return p;
    case FORMULA:
        row = series_along(f->tapes.series, r->mode->tape.outputs[t->P]);
        for (n = 0; n < p; n++)
            out[n] = t->coefficient * row[n];
        return p;
    default:
        load_on(r, t->P, out);
        for (n = 0; n < p; n++)
            out[n] = t->coefficient * out[n];
        return p;
    }
}

/* Coefficients of an event function over the step; returns their number. */
int taylor_polynomial(const Run *r, const Event *e, Real *out)
{
    Series more;
    int count, i, n;
    if (e->terms == 0) {
        memset(out, 0, sizeof(Real) * (size_t)(r->taylor.order + 1));
        out[0] = e->constant;
        return r->taylor.order + 1;
    }
    count = taylor_term(r, r->mode->terms + e->first, out);
    for (i = 1; i < e->terms; i++) {
        int other = taylor_term(r, r->mode->terms + e->first + i, more);
        count = other < count ? other : count;
        for (n = 0; n < count; n++)
            out[n] = out[n] + more[n];
    }
    out[0] = out[0] + e->constant;
    return count;
}

/* Sum of the magnitudes that a term is made of at the expansion point, without its coefficient; of a formula what its rounding
 * bound stands for.
 */
static Real magnitude_of(const Run *r, const Term *t)
{
    const Taylor *f = &r->taylor;
    const Real *row = f->table;
    switch (t->kind) {
    case DIFFERENCE:
    case RATE:
        return (t->from < 0 ? 0.0 : fabs(row[t->from])) + (t->to < 0 ? 0.0 : fabs(row[t->to]));
    case COUPLING: {
        const Coupling *c = &r->mode->couplings[t->P];
        Real places = fabs(row[c->from]) + fabs(row[c->to]);
        Real speeds = fabs(row[f->rates + c->from]) + fabs(row[f->rates + c->to]);
        return c->k * places + c->c * speeds + fabs(c->offset);
    }
    case ACCELERATION:
        return fabs(row[f->stride + f->rates + column_in_table(r, t->P)]);
    case FORMULA:
        tape_values(r, 0.0);
        return f->tapes.bounds[r->mode->tape.outputs[t->P]] / EPS;
    default: {
        Series series;
        load_on(r, t->P, series);
        return fabs(series[0]);
    }
    }
}

/* Sum of the magnitudes that an event function is made of at the expansion point. */
Real taylor_magnitude(const Run *r, const Event *e)
{
    Real total = e->size;
    int i;
    for (i = 0; i < e->terms; i++) {
        const Term *t = &r->mode->terms[e->first + i];
        total = total + fabs(t->coefficient) * magnitude_of(r, t);
    }
    return total;
}
