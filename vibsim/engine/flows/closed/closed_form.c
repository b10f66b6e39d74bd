/* The closed-form flow: one exact expression per modal coordinate from event to event.
 *
 * Inside a mode that has a closed form every modal coordinate is a damped oscillator, or a free mass, under a constant and
 * harmonic loads. A trajectory costs a few evaluations per event, however long the stretches between them.
 *
 * Time is absolute, the anchor is the last event.
 */
#include "engine.h"
#include "numbers.h"
#include "responses.h"

/* Sum of signed displacements at the anchor. */
static Real fixed_sum(const Run *r, int first, int count)
{
    const Fixed *fixed = r->mode->modal->fixed + first;
    Real total = 0.0;
    int i;
    for (i = 0; i < count; i++) {
        Real part = fixed[i].sign * r->closed_form.x0[fixed[i].column];
        total = i == 0 ? part : total + part;
    }
    return total;
}

/* Displacement and velocity of the base from sines and cosines of the harmonics. */
static void base_motion(const Run *r, const Real *sines, const Real *cosines, Real *X, Real *V)
{
    int i;
    *X = *V = 0.0;
    for (i = 0; i < r->base_count; i++) {
        const Harmonic *term = &r->base[i];
        if (term->harmonic < 0)
            continue;
        *X = *X + term->amplitude * sines[term->harmonic];
        *V = *V + term->amplitude * term->omega * cosines[term->harmonic];
    }
}

/* A coordinate, or its rate, from the displacements or velocities of columns. */
static Real weighted(const Source *sources, int count, const Real *values)
{
    Real total = 0.0;
    int i;
    for (i = 0; i < count; i++) {
        Real part = sources[i].weight * (sources[i].Q < 0 ? values[sources[i].P] : values[sources[i].P] - values[sources[i].Q]);
        total = i == 0 ? part : total + part;
    }
    return total;
}

/* Start, rate and constant load of a coordinate at the anchor, and its drives there by their sines and cosines; responses are 0. */
static void anchor_coordinate(Run *r, const Modal *modal, const Coordinate *c, Motion *y)
{
    const ClosedForm *f = &r->closed_form;
    Real load = c->load;
    int i;
    for (i = 0; i < c->shifts; i++) {
        const Shift *shift = &modal->shifts[c->first_shift + i];
        load = load + shift->factor * fixed_sum(r, shift->first, shift->count);
    }
    y->jet[0] = y->q0 = weighted(modal->sources + c->first_source, c->sources, f->x0);
    y->jet[1] = y->u0 = weighted(modal->sources + c->first_source, c->sources, f->v0);
    y->load = load;
    y->stiff = y->impulse = y->steady = 0.0;
    for (i = 0; i < c->drive_count; i++) {
        const Drive *drive = &c->drives[i];
        Response *response = &y->responses[i];
        Real sine = f->sin0[drive->harmonic], cosine = f->cos0[drive->harmonic];
        response->load_sine = drive->sine * sine + drive->cosine * cosine;
        response->load_cosine = drive->sine * cosine - drive->cosine * sine;
        response->hc = response->hs = response->dc = response->ds = 0.0;
    }
}

/* How many functions of time the motion in the mode is a sum of: what has so many derivatives zero at one instant is zero. */
int closed_form_dimension(const Run *r)
{
    return 2 * r->mode->modal->count + 2 * r->harmonic_count + 1;
}

/* Anchor the flow at `state` in the mode of now; harmonics by their reduced phases. */
void closed_form_enter(Run *r, const State *state)
{
    ClosedForm *f = &r->closed_form;
    const Modal *modal = r->mode->modal;
    int n = r->bodies, h, c, m;
    r->closed = 1;
    r->t0 = state->t;
    for (h = 0; h < r->harmonic_count; h++) {
        const Harmonic *one = &r->harmonics[h];
        Real angle = turn_angle(one->cycles, one->cycles_lo, state->t) + one->phase;
        rounded_sine_cosine(angle, &f->sin0[h], &f->cos0[h]);
        f->sines[h] = f->sin0[h];
        f->cosines[h] = f->cos0[h];
    }
    for (c = 0; c < n; c++) {
        f->x0[c] = state->x[c];
        f->v0[c] = state->v[c];
    }
    f->x0[n] = f->v0[n] = 0.0;
    base_motion(r, f->sin0, f->cos0, &f->x0[n + 1], &f->v0[n + 1]);
    for (c = 0; c < n; c++) {
        const Place *place = &modal->places[c];
        f->rest[c] = place->fixed ? fixed_sum(r, place->first_fixed, place->fixed) : -0.0;
    }
    for (m = 0; m < modal->count; m++)
        anchor_coordinate(r, modal, &modal->coordinates[m], &f->motions[m]);
    f->tau = f->counted = 0.0;
    closed_form_open(r);
}

/* A coordinate and its rate a time tau after the anchor, and the responses they are made of, for bounds of their rounding.
 * `sines`, `cosines`: of the harmonics' own angles since the anchor.
 */
static inline void evaluate_coordinate(const Coordinate *c, Motion *y, Real tau, const Real *sines, const Real *cosines)
{
    const Oscillator *o = &c->oscillator;
    const Real q0 = y->q0, u0 = y->u0, load = y->load;
    Real q, u, release = 0, impulse = 0;
    int i;
    if (c->is_free) {
        q = q0 + u0 * tau + load * (tau * tau / 2);
        u = u0 + load * tau;
    } else {
        Real steady, rate, stiff;
        release_and_impulse(o, tau, &release, &impulse);
        steady = constant_response(o, tau, release);
        rate = release - 2 * o->a * impulse;
        stiff = o->b * impulse;
        q = q0 * release + u0 * impulse + load * steady;
        u = u0 * rate - q0 * stiff + load * impulse;
        y->stiff = stiff;
        y->impulse = impulse;
        y->steady = steady;
    }
    for (i = 0; i < c->drive_count; i++) {
        const Drive *drive = &c->drives[i];
        Response *response = &y->responses[i];
        Real cosine = cosines[drive->harmonic], sine = sines[drive->harmonic], hc, hs, dc, ds;
        if (c->is_free) {
            free_harmonic_response(&drive->oscillator, tau, cosine, sine, &hc, &hs);
            dc = sine / drive->oscillator.omega;
            ds = drive->oscillator.omega * hc;
        } else {
            harmonic_response(&drive->oscillator, tau, release, impulse, cosine, sine, &hc, &hs, &dc, &ds);
        }
        q = q + (response->load_sine * hc + response->load_cosine * hs);
        u = u + (response->load_sine * dc + response->load_cosine * ds);
        response->hc = hc;
        response->hs = hs;
        response->dc = dc;
        response->ds = ds;
    }
    y->jet[0] = q;
    y->jet[1] = u;
}

/* Set coordinates, rates and the phases of the harmonics a time tau after the anchor, once. */
void closed_form_evaluate(Run *r, Real tau)
{
    ClosedForm *f = &r->closed_form;
    const Modal *modal = r->mode->modal;
    int h, m;
    if (tau == f->tau)
        return;
    r->evaluations += tau != f->counted;
    f->tau = f->counted = tau;
    for (h = 0; h < r->harmonic_count; h++) {
        const Harmonic *one = &r->harmonics[h];
        Real angle = one->omega * tau, cosine, sine, sin0 = f->sin0[h], cos0 = f->cos0[h];
        if (angle > 3) /* below, the product is as good as its reduction */
            angle = turn_angle(one->cycles, one->cycles_lo, tau);
        sine_cosine(angle, &sine, &cosine);
        f->cosine[h] = cosine;
        f->sine[h] = sine;
        f->sines[h] = sin0 * cosine + cos0 * sine;
        f->cosines[h] = cos0 * cosine - sin0 * sine;
    }
    for (m = 0; m < modal->count; m++)
        evaluate_coordinate(&modal->coordinates[m], &f->motions[m], tau, f->sine, f->cosine);
}

/* Adds a harmonic load to the orders of d from 2. */
static void drive_jet(const ClosedForm *f, const Drive *drive, Real *d, int count)
{
    Real sine = drive->sine, cosine = drive->cosine, turn = f->sines[drive->harmonic], next = f->cosines[drive->harmonic];
    int n;
    for (n = 2; n <= count; n++) {
        Real before = turn;
        d[n] = d[n] + (sine * turn + cosine * next);
        sine = sine * drive->oscillator.omega;
        cosine = cosine * drive->oscillator.omega;
        turn = next;
        next = -before;
    }
}

/* Derivatives of order 2 to `count` of a coordinate at the point evaluated last, by its equation of motion; with one drive in one
 * loop.
 */
static inline void jet_of(const ClosedForm *f, const Coordinate *c, Motion *y, int count)
{
    const Real twice = 2 * c->a, b = c->b;
    Real *d = y->jet, first = d[0], second = d[1];
    int i, n;
    if (c->drive_count == 1) {
        const Drive *drive = c->drives;
        const Real omega = drive->oscillator.omega;
        Real sine = drive->sine, cosine = drive->cosine, turn = f->sines[drive->harmonic], next = f->cosines[drive->harmonic];
        for (n = 2; n <= count; n++) {
            Real before = turn, term = sine * turn + cosine * next;
            term = c->is_free ? term : term - twice * second - b * first;
            first = second;
            d[n] = second = n == 2 ? term + y->load : term;
            sine = sine * omega;
            cosine = cosine * omega;
            turn = next;
            next = -before;
        }
        return;
    }
    for (n = 2; n <= count; n++)
        d[n] = 0.0;
    for (i = 0; i < c->drive_count; i++)
        drive_jet(f, &c->drives[i], d, count);
    for (n = 2; n <= count; n++) {
        if (!c->is_free)
            d[n] = d[n] - twice * d[n - 1] - b * d[n - 2];
        if (n == 2)
            d[2] = d[2] + y->load;
    }
}

/* Sine of a harmonic's angle here and so many quarters of a turn. */
Real harmonic_turned(const ClosedForm *f, const Harmonic *term, int quarters)
{
    Real value = (quarters % 2 == 0 ? f->sines : f->cosines)[term->harmonic];
    return quarters % 4 < 2 ? value : -value;
}

/* Derivatives of the coordinates as far as the event functions' n-th and a bound of it ask for them. */
void closed_form_jets(Run *r, int n)
{
    ClosedForm *f = &r->closed_form;
    const Modal *modal = r->mode->modal;
    int count = n + 3, m, i;
    for (m = 0; m < modal->count; m++)
        if (n + modal->coordinates[m].depth > 0) /* values and rates are there */
            jet_of(f, &modal->coordinates[m], &f->motions[m], n + 1 + modal->coordinates[m].depth);
    if (r->base_count == 0)
        return;
    for (n = 0; n <= count; n++)
        f->base[n] = 0.0;
    for (i = 0; i < r->base_count; i++) {
        const Harmonic *term = &r->base[i];
        Real factor = term->amplitude;
        if (term->harmonic < 0)
            continue;
        for (n = 0; n <= count; n++) {
            f->base[n] = f->base[n] + factor * harmonic_turned(f, term, n);
            factor = factor * term->omega;
        }
    }
}

/* State a time tau after the anchor, which need not be on the grid of time. Each body is where what rests of its place and its
 * shares of the coordinates put it; -0.0 stands for nothing.
 */
void closed_form_state_after(Run *r, Real tau, State *out)
{
    const ClosedForm *f = &r->closed_form;
    const Modal *modal = r->mode->modal;
    const Motion *y = f->motions;
    Real X = 0.0, V = 0.0;
    int c, i;
    closed_form_evaluate(r, tau);
    if (r->base_count > 0)
        base_motion(r, f->sines, f->cosines, &X, &V);
    out->t = r->t0 + tau;
    out->phase = out->turns = out->w = 0.0;
    for (c = 0; c < r->bodies; c++) {
        const Place *place = &modal->places[c];
        const Share *share = place->share;
        Real position = f->rest[c], rate = -0.0;
        if (place->shares == 2) {
            const Real *one = y[share[0].m].jet, *other = y[share[1].m].jet, a = share[0].share, b = share[1].share;
            position = position + a * one[0] + b * other[0];
            rate = a * one[1] + b * other[1];
        } else {
            for (i = place->shares; i > 0; i--, share++) {
                const Real *jet = y[share->m].jet;
                position = position + share->share * jet[0];
                rate = rate + share->share * jet[1];
            }
        }
        out->x[c] = place->base ? position + X : position;
        out->v[c] = place->base ? rate + V : place->shares ? rate : 0.0;
    }
}
