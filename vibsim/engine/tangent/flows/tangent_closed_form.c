/* How small disturbances move inside a mode of the closed-form flow.
 *
 * A mode with a closed form is linear with loads that depend on time alone, so a disturbance obeys the homogeneous equations of
 * its modal coordinates. Where bodies are tied, the disturbed distance between them is a constant load on what holds them.
 */
#include <string.h>

#include "responses.h"
#include "tangent.h"

#define E_FOLDS 8 /* of decay in one piece: neighbouring directions then part by 3 of the 16 digits at most */

/* End of the piece from t that is moved at once: at most `end`, not beyond `mark` where that is ahead, and short enough that no
 * direction is lost below round-off.
 */
Real closed_form_piece_end(const Run *r, Real t, Real end, Real mark)
{
    const Modal *modal = r->mode->modal;
    Real decay = 0.0, ahead;
    int m;
    for (m = 0; m < modal->count; m++) {
        const Oscillator *o = &modal->coordinates[m].oscillator;
        Real fastest = o->oscillates ? o->a : o->a + o->wd;
        if (!modal->coordinates[m].is_free && fastest > decay)
            decay = fastest;
    }
    ahead = decay > 0 ? t + E_FOLDS / decay : end;
    if (t < mark && mark < ahead)
        ahead = mark;
    return t < ahead && ahead < end ? ahead : end;
}

/* Responses of the coordinates over a piece of length tau. */
static void prepare(const Run *r, Real tau)
{
    const Modal *modal = r->mode->modal;
    int m;
    for (m = 0; m < modal->count; m++) {
        const Oscillator *o = &modal->coordinates[m].oscillator;
        Moving *moving = &r->tangent->moving[m];
        Real release, impulse;
        if (modal->coordinates[m].is_free) {
            *moving = (Moving){{1.0, tau, tau * tau / 2}, {0.0, 1.0, tau}};
            continue;
        }
        release_and_impulse(o, tau, &release, &impulse);
        moving->q[0] = release;
        moving->q[1] = impulse;
        moving->q[2] = constant_response(o, tau, release);
        moving->u[0] = -(o->b * impulse);
        moving->u[1] = release - 2 * o->a * impulse;
        moving->u[2] = impulse;
    }
}

/* Entries of the bodies' displacements or velocities; nothing disturbs ground and base. */
static const Real *entries(const Run *r, const Real *bodies, int column)
{
    return column < r->bodies ? bodies + column * r->tangent->stride : r->tangent->zeros;
}

/* Adds the weighted sum of a coordinate's sources. */
static void weigh(const Run *r, const Coordinate *c, const Real *values, Real *restrict out)
{
    const Source *source = r->mode->modal->sources + c->first_source;
    int count = r->tangent->possible, s, i;
    for (s = 0; s < c->sources; s++, source++) {
        const Real weight = source->weight, *P = entries(r, values, source->P);
        const Real *Q = source->Q < 0 ? r->tangent->zeros : entries(r, values, source->Q);
        for (i = 0; i < count; i++)
            out[i] = out[i] + weight * (P[i] - Q[i]);
    }
}

/* Adds factor times the sum of signed displacements. */
static void shift(const Run *r, Real factor, int first, int fixed, const Real *x, Real *restrict out)
{
    const Fixed *place = r->mode->modal->fixed + first;
    int count = r->tangent->possible, i, k;
    for (i = 0; i < count; i++) {
        Real total = 0.0;
        for (k = 0; k < fixed; k++)
            total = total + place[k].sign * entries(r, x, place[k].column)[i];
        out[i] = out[i] + factor * total;
    }
}

/* Displacement and velocity of a coordinate from those before it moved. */
static void move_coordinate(const Run *r, int m)
{
    Tangent *b = r->tangent;
    const Modal *modal = r->mode->modal;
    const Coordinate *c = &modal->coordinates[m];
    const Moving *by = &b->moving[m];
    Real *q = b->q + m * b->stride, *u = b->u + m * b->stride, *load = b->moved; /* not yet in use */
    int i, s;
    size_t bytes = sizeof(Real) * (size_t)b->stride;
    memset(q, 0, bytes);
    memset(u, 0, bytes);
    memset(load, 0, bytes);
    weigh(r, c, b->vectors, q);
    weigh(r, c, b->vectors + r->bodies * b->stride, u);
    for (s = 0; s < c->shifts; s++) {
        const Shift *one = &modal->shifts[c->first_shift + s];
        shift(r, one->factor, one->first, one->count, b->vectors, load);
    }
    for (i = 0; i < b->possible; i++) {
        Real q0 = q[i], u0 = u[i];
        q[i] = q0 * by->q[0] + u0 * by->q[1] + load[i] * by->q[2];
        u[i] = q0 * by->u[0] + u0 * by->u[1] + load[i] * by->u[2];
    }
}

/* Adds the shares that a place has of the coordinates. */
static void shape(const Run *r, const Place *p, const Real *coordinates, Real *restrict out)
{
    int s, i;
    for (s = 0; s < p->shares; s++) {
        const Real share = p->share[s].share, *values = coordinates + p->share[s].m * r->tangent->stride;
        for (i = 0; i < r->tangent->possible; i++)
            out[i] = out[i] + share * values[i];
    }
}

/* The disturbances after a piece of length tau. */
void closed_form_move(Run *r, Real tau)
{
    Tangent *b = r->tangent;
    const Modal *modal = r->mode->modal;
    int n = r->bodies, c, m, k, i;
    prepare(r, tau);
    for (m = 0; m < modal->count; m++)
        move_coordinate(r, m);
    memset(b->moved, 0, sizeof(Real) * (size_t)(2 * n * b->stride));
    for (c = 0; c < n; c++) {
        const Place *place = &modal->places[c];
        Real *dx = b->moved + c * b->stride, *dv = b->moved + (n + c) * b->stride, *shaped = b->line;
        memset(shaped, 0, sizeof(Real) * (size_t)b->stride);
        shift(r, 1.0, place->first_fixed, place->fixed, b->vectors, dx);
        shape(r, place, b->q, shaped);
        for (i = 0; i < b->possible; i++)
            dx[i] = dx[i] + shaped[i];
        shape(r, place, b->u, dv);
    }
    for (k = 0; k < 2 * n; k++)
        for (i = 0; i < b->possible; i++)
            b->vectors[k * b->stride + i] = b->moved[k * b->stride + i];
}
