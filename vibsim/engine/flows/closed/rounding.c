/* Scales of the rounding of modal coordinates, at the point that the closed form evaluated last.
 *
 * A response is a difference of terms that may cancel while their rounding stays: 1 - cos of a motion from rest is zero after
 * each period, cos - cos of two close frequencies after each beat. So there are two measures:
 *
 * plain : what each response adds to the coordinate; vanishes where that does
 * close : the terms that responses, loads and starts are themselves sums of; right to the rounding everywhere
 *
 * Steps far from every zero need no more than the plain one; reaches.c tells how far that is.
 */
#include "engine.h"
#include "responses.h"

/* At the anchor, where every response is zero. */
void measure_start(Run *r)
{
    ClosedForm *f = &r->closed_form;
    int m;
    for (m = 0; m < r->mode->modal->count; m++) {
        f->scales[PLAIN][m].q = fabs(f->motions[m].q0);
        f->scales[PLAIN][m].u = fabs(f->motions[m].u0);
    }
}

/* The plain measure at the point evaluated last; of coordinates of which only rates are read, only of these. */
void measure_plainly(Run *r)
{
    ClosedForm *f = &r->closed_form;
    const Modal *modal = r->mode->modal;
    const Real tau = f->tau;
    Scale *plain = f->scales[PLAIN];
    int m, i;
    for (m = 0; m < modal->count; m++) {
        const Coordinate *c = &modal->coordinates[m];
        const Motion *y = &f->motions[m];
        const int rate_alone = c->depth == RATE_ALONE;
        Real load = y->load, q = fabs(y->q0), u = fabs(y->u0);
        if (c->is_free) {
            if (!rate_alone)
                q = q + fabs(y->u0 * tau) + fabs(load * (tau * tau / 2));
            u = u + fabs(load * tau);
        } else {
            q = q + fabs(y->u0 * y->impulse) + fabs(load * y->steady);
            u = u + fabs(y->q0 * y->stiff) + fabs(load * y->impulse);
        }
        for (i = 0; i < c->drive_count; i++) {
            const Response *response = &y->responses[i];
            Real size = c->drives[i].size;
            if (!rate_alone)
                q = q + size * (fabs(response->hc) + fabs(response->hs));
            u = u + size * (fabs(response->dc) + fabs(response->ds));
        }
        plain[m].q = q;
        plain[m].u = u;
    }
}

/* Terms of a coordinate's displacement, rate and load at the start of the segment. */
static void starts(const Run *r, const Coordinate *c, const Terms *terms, Real *q, Real *u, Real *load)
{
    const ClosedForm *f = &r->closed_form;
    const Modal *modal = r->mode->modal;
    int i, k;
    *q = *u = 0.0;
    *load = terms->load;
    for (i = 0; i < c->sources; i++) {
        const Source *one = &modal->sources[c->first_source + i];
        *q = *q + fabs(one->weight * (one->Q < 0 ? f->x0[one->P] : f->x0[one->P] - f->x0[one->Q]));
        *u = *u + fabs(one->weight * (one->Q < 0 ? f->v0[one->P] : f->v0[one->P] - f->v0[one->Q]));
    }
    for (i = 0; i < c->shifts; i++) {
        const Shift *shift = &modal->shifts[c->first_shift + i];
        Real places = 0.0;
        for (k = 0; k < shift->count; k++)
            places = places + fabs(f->x0[modal->fixed[shift->first + k].column]);
        *load = *load + fabs(shift->factor) * places;
    }
}

/* Terms of C [-], S [s] and I [s^2]. Zeros of C and S are those of a cosine and a sine, whose phase is rounded: what counts is how
 * far they swing. That phase has been rounded to eps wd t, so S to no more than swing * min(t, 1 / w0) beside itself, however
 * close to critical damping.
 */
static void swinging(const Oscillator *o, Real tau, Real at_steady, Real *swing, Real *impulse, Real *steady)
{
    Real release, rise;
    int quotient = o->settling * (tau * tau) >= QUARTER;
    release_and_impulse(o, tau, &release, &rise);
    release = fabs(release);
    rise = fabs(rise);
    if (o->oscillates) {
        release = release + (o->a + o->wd) * rise;
        rise = rise + release * (o->w0 * tau < 1 ? tau : 1 / o->w0);
    }
    *swing = release;
    *impulse = rise;
    *steady = quotient ? (1 + release) * o->per_b : fabs(at_steady);
}

/* Terms of the response to a harmonic load and of its rate. */
static void response_terms(const Oscillator *o, Real tau, Real swing, Real impulse, const Response *at, Real *place,
                           Real *rate)
{
    const Real omega = o->omega;
    if (is_quotient(o, tau * tau)) {
        Real inverse = fabs(o->inverse_r) + fabs(o->inverse_i);
        *place = (2 + swing + omega * impulse) * inverse;
        *rate = (o->b * impulse + omega * (2 + swing + 2 * o->a * impulse)) * inverse;
        return;
    }
    *place = fabs(at->hc) + fabs(at->hs);
    *rate = impulse + omega * *place;
}

/* The same of a free mass. */
static void free_response_terms(const Oscillator *o, Real tau, const Response *at, Real *place, Real *rate)
{
    Real angle = o->omega * tau;
    if (angle * angle >= QUARTER) {
        *place = (3 + angle) * fabs(o->inverse_r);
        *rate = 3 / o->omega;
        return;
    }
    *place = fabs(at->hc) + fabs(at->hs);
    *rate = fabs(at->dc) + fabs(at->ds);
}

/* The close measure of a coordinate, its rate and its acceleration. */
static Scale close_scale(const Run *r, const Coordinate *c, const Terms *terms, const Motion *y)
{
    const Real tau = r->closed_form.tau;
    Real q0, u0, load, q, u, a, swing = 0.0, impulse = 0.0, steady, place, rate;
    Scale scale;
    int i;
    starts(r, c, terms, &q0, &u0, &load);
    if (c->is_free) {
        q = q0 + u0 * tau + load * (tau * tau / 2);
        u = u0 + load * tau;
    } else {
        const Oscillator *o = &c->oscillator;
        swinging(o, tau, y->steady, &swing, &impulse, &steady);
        q = q0 + u0 * impulse + load * steady;
        u = u0 * (1 + 2 * o->a * impulse) + q0 * (o->b * impulse) + load * impulse;
    }
    a = load;
    for (i = 0; i < c->drive_count; i++) {
        const Drive *drive = &c->drives[i];
        if (c->is_free)
            free_response_terms(&drive->oscillator, tau, &y->responses[i], &place, &rate);
        else
            response_terms(&drive->oscillator, tau, swing, impulse, &y->responses[i], &place, &rate);
        q = q + terms->drives[i] * place;
        u = u + terms->drives[i] * rate;
        a = a + terms->drives[i];
    }
    scale.q = q;
    scale.u = u;
    scale.a = c->is_free ? a : a + 2 * c->a * u + c->b * q;
    return scale;
}

/* The close measure of all coordinates. */
void measure_closely(Run *r)
{
    const Modal *modal = r->mode->modal;
    ClosedForm *f = &r->closed_form;
    int m;
    for (m = 0; m < modal->count; m++)
        f->scales[CLOSE][m] = close_scale(r, &modal->coordinates[m], &modal->terms[m], &f->motions[m]);
}
