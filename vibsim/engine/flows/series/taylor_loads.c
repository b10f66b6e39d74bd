/* Series of the forces and of the base's motion over a Taylor step. */
#include <string.h>

#include "engine.h"
#include "numbers.h"

/* The derivatives of order 0 to 3 of the sine of a harmonic at t, each over omega to that order; the angle without a large
 * product.
 */
static void sine_and_cosine(const Harmonic *term, Real t, Real *turns)
{
    Real angle = turn_angle(term->cycles, term->cycles_lo, t) + term->phase;
    rounded_sine_cosine(angle, &turns[0], &turns[1]);
    turns[2] = -turns[0];
    turns[3] = -turns[1];
}

/* X by a formula, or its velocity: coefficients along its tape, three beyond the order. */
static void expand_base_formula(Run *r, const Tape *tape, Real t)
{
    Taylor *f = &r->taylor;
    const Real *X = series_along(f->base_tapes.series, tape->outputs[0]);
    Real *row = f->table;
    int at = base_column(r), n;
    tape_start(&f->base_tapes, t, f->nearest, f->inverse, f->order + 3);
    tape_begin(tape, &f->base_tapes, NULL);
    for (n = 0; n < f->order + 2; n++, row += f->stride) {
        if (r->has_base == 2) {
            row[at] = n > 0 ? X[n - 1] * f->inverse[n] : 0.0;
            row[f->rates + at] = X[n];
            continue;
        }
        row[at] = X[n];
        row[f->rates + at] = (n + 1) * X[n + 1];
    }
}

/* Series of the base at t, X by harmonics or by a formula, to two orders beyond those of the forces. */
void taylor_expand_base(Run *r, Real t)
{
    Taylor *f = &r->taylor;
    int at = base_column(r), i, k;
    Real *row = f->table;
    if (r->mode->base_tape.op_count > 0) {
        expand_base_formula(r, &r->mode->base_tape, t);
        return;
    }
    for (k = 0; k < f->order + 2; k++, row += f->stride)
        row[at] = row[f->rates + at] = 0.0;
    for (i = 0; i < r->base_count; i++) {
        const Harmonic *term = &r->base[i];
        Real turns[4], factor = term->amplitude;
        row = f->table;
        sine_and_cosine(term, t, turns);
        for (k = 0; k < f->order + 2; k++, row += f->stride) {
            row[at] = row[at] + factor * turns[k % 4];
            factor = factor * term->omega;
            row[f->rates + at] = row[f->rates + at] + factor * turns[(k + 1) % 4];
            factor = factor * f->inverse[k + 1];
        }
    }
}

/* Series of the forces on the bodies at t, summed by column. */
void taylor_expand_loads(Run *r, Real t)
{
    Taylor *f = &r->taylor;
    int i, j, k;
    for (i = 0; i < f->loaded_count; i++)
        memset(f->loaded_on[f->loaded[i]], 0, sizeof(Real) * (size_t)f->order);
    for (i = 0; i < r->force_count; i++) {
        const Force *force = &r->forces[i];
        Real *series = f->loaded_on[force->on];
        for (j = 0; j < force->count; j++) {
            const Harmonic *term = &force->terms[j];
            Real turns[4], factor = term->amplitude;
            sine_and_cosine(term, t, turns);
            for (k = 0; k < f->order; k++) {
                series[k] = series[k] + factor * turns[k % 4];
                factor = factor * term->omega * f->inverse[k + 1];
            }
        }
        series[0] = series[0] + force->constant;
    }
}
