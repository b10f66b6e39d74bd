/* The closed-form flow at many times of a segment: the operations of closed_form.c time by time, in loops over the times
 * that a compiler turns into operations on vectors.
 */
#include "engine.h"
#include "numbers.h"
#include "responses.h"

typedef struct {
    int count;
    const double *tau;
    double (*cosine)[SAMPLES_AT_ONCE], (*sine)[SAMPLES_AT_ONCE]; /* of the angle of each harmonic since the anchor */
    double (*q)[SAMPLES_AT_ONCE], (*u)[SAMPLES_AT_ONCE];         /* of each coordinate */
} Times;

/* Whether every response of a coordinate is a quotient from tau on: no series, no resonance. */
static int settled(const Coordinate *c, double tau)
{
    const Oscillator *o = &c->oscillator;
    const double square = tau * tau;
    int i;
    if (!c->is_free && (!o->oscillates || o->wd * tau == 0 || o->settling * square < QUARTER))
        return 0;
    for (i = 0; i < c->drive_count; i++) {
        const Oscillator *d = &c->drives[i].oscillator;
        const double angle = d->omega * tau;
        if (c->is_free ? angle * angle < QUARTER
                       : d->beating * (square * square) < QUARTER * QUARTER || is_resonant(d, square))
            return 0;
    }
    return 1;
}

static int all_settled(const Modal *modal, double tau)
{
    int m;
    for (m = 0; m < modal->count; m++)
        if (!settled(&modal->coordinates[m], tau))
            return 0;
    return 1;
}

static void turn_harmonic(const Harmonic *one, const double *restrict tau, int count, double *restrict cosine, double *restrict sine)
{
    double angle[SAMPLES_AT_ONCE];
    int j;
    for (j = 0; j < count; j++)
        angle[j] = one->omega * tau[j];
    for (j = count - 1; j >= 0 && angle[j] > 3; j--)
        angle[j] = turn_angle(one->cycles, one->cycles_lo, tau[j]);
    for (j = 0; j < count; j++) {
        cosine[j] = cos(angle[j]);
        sine[j] = sin(angle[j]);
    }
}

static void move_freely(const Motion *y, const double *restrict tau, int count, double *restrict q, double *restrict u)
{
    const double q0 = y->q0, u0 = y->u0, load = y->load;
    int j;
    for (j = 0; j < count; j++) {
        q[j] = q0 + u0 * tau[j] + load * (tau[j] * tau[j] / 2);
        u[j] = u0 + load * tau[j];
    }
}

static void drive_freely(const Oscillator *o, const Response *response, const double *restrict tau, int count,
                         const double *restrict cosine, const double *restrict sine, double *restrict q, double *restrict u)
{
    const double load_sine = response->load_sine, load_cosine = response->load_cosine, omega = o->omega, inverse = o->inverse_r;
    int j;
    for (j = 0; j < count; j++) {
        double angle = omega * tau[j], hc = (cosine[j] - 1) * inverse, hs = (sine[j] - angle) * inverse;
        q[j] = q[j] + (load_sine * hc + load_cosine * hs);
        u[j] = u[j] + (load_sine * (sine[j] / omega) + load_cosine * (omega * hc));
    }
}

static void oscillate(const Oscillator *o, const Motion *y, const double *restrict tau, int count, double *restrict release,
                      double *restrict impulse, double *restrict q, double *restrict u)
{
    const double a = o->a, b = o->b, wd = o->wd, per_wd = o->per_wd, per_b = o->per_b, q0 = y->q0, u0 = y->u0, load = y->load;
    double cosine[SAMPLES_AT_ONCE], sine[SAMPLES_AT_ONCE], decay[SAMPLES_AT_ONCE];
    int j;
    for (j = 0; j < count; j++) {
        double angle = wd * tau[j];
        cosine[j] = cos(angle);
        sine[j] = sin(angle);
        decay[j] = exp(-(a * tau[j]));
    }
    for (j = 0; j < count; j++) {
        impulse[j] = decay[j] * (sine[j] * per_wd);
        release[j] = decay[j] * cosine[j] + a * impulse[j];
        q[j] = q0 * release[j] + u0 * impulse[j] + load * ((1 - release[j]) * per_b);
        u[j] = u0 * (release[j] - 2 * a * impulse[j]) - q0 * (b * impulse[j]) + load * impulse[j];
    }
}

static void drive(const Oscillator *o, const Response *response, int count, const double *restrict release, const double *restrict impulse,
                  const double *restrict cosine, const double *restrict sine, double *restrict q, double *restrict u)
{
    const double a = o->a, b = o->b, omega = o->omega, real = o->inverse_r, imaginary = o->inverse_i;
    const double load_sine = response->load_sine, load_cosine = response->load_cosine;
    int j;
    for (j = 0; j < count; j++) {
        double nr = cosine[j] - release[j], ni = sine[j] - omega * impulse[j];
        double vr = b * impulse[j] - omega * sine[j], vi = omega * (cosine[j] - (release[j] - 2 * a * impulse[j]));
        q[j] = q[j] + (load_sine * (nr * real + ni * imaginary) + load_cosine * (ni * real - nr * imaginary));
        u[j] = u[j] + (load_sine * (vr * real + vi * imaginary) + load_cosine * (vi * real - vr * imaginary));
    }
}

static void move_coordinate(const Coordinate *c, const Motion *y, const Times *at, double *q, double *u)
{
    double release[SAMPLES_AT_ONCE], impulse[SAMPLES_AT_ONCE];
    int i;
    if (c->is_free)
        move_freely(y, at->tau, at->count, q, u);
    else
        oscillate(&c->oscillator, y, at->tau, at->count, release, impulse, q, u);
    for (i = 0; i < c->drive_count; i++) {
        const Oscillator *o = &c->drives[i].oscillator;
        const double *cosine = at->cosine[c->drives[i].harmonic], *sine = at->sine[c->drives[i].harmonic];
        if (c->is_free)
            drive_freely(o, &y->responses[i], at->tau, at->count, cosine, sine, q, u);
        else
            drive(o, &y->responses[i], at->count, release, impulse, cosine, sine, q, u);
    }
}

/* Displacements and velocities of a body into its rows. */
static void place_body(const Place *place, double rest, const Times *at, double *restrict x, double *restrict v)
{
    int i, j;
    for (j = 0; j < at->count; j++) {
        x[j] = rest;
        v[j] = place->shares ? -0.0 : 0.0;
    }
    for (i = 0; i < place->shares; i++) {
        const double share = place->share[i].share, *restrict q = at->q[place->share[i].m], *restrict u = at->u[place->share[i].m];
        for (j = 0; j < at->count; j++) {
            x[j] = x[j] + share * q[j];
            v[j] = v[j] + share * u[j];
        }
    }
    for (j = 0; place->base && j < at->count; j++) { /* on a base at rest, as a sum with its displacement */
        x[j] = x[j] + 0.0;
        v[j] = v[j] + 0.0;
    }
}

/* Writes states at ascending times tau of the segment into rows as `write_state` does, from the second one on; returns how many of
 * the first ones are left to do one by one: none can be done at once where a base moves, or before the responses are settled.
 */
int closed_form_samples(Run *r, const double *tau, int count, double *row, long room)
{
    const Modal *modal = r->mode->modal;
    const ClosedForm *f = &r->closed_form;
    double (*table)[SAMPLES_AT_ONCE] = f->at_once;
    Times at;
    int first = 0, i, c;
    if (r->base_count > 0)
        return count;
    while (first < count && !all_settled(modal, tau[first]))
        first++;
    if (first == count)
        return count;
    at.count = count - first;
    at.tau = tau + first;
    at.cosine = table;
    at.sine = at.cosine + r->harmonic_count;
    at.q = at.sine + r->harmonic_count;
    at.u = at.q + modal->count;
    for (i = 0; i < r->harmonic_count; i++)
        turn_harmonic(&r->harmonics[i], at.tau, at.count, at.cosine[i], at.sine[i]);
    for (i = 0; i < modal->count; i++)
        move_coordinate(&modal->coordinates[i], &f->motions[i], &at, at.q[i], at.u[i]);
    row += first;
    for (c = 0; c < r->bodies; c++)
        place_body(&modal->places[c], f->rest[c], &at, row + (1 + 2 * c) * room, row + (2 + 2 * c) * room);
    for (i = 0; i < at.count; i++)
        row[(1 + 2 * r->bodies) * room + i] = row[(2 + 2 * r->bodies) * room + i] = 0.0;
    return first;
}
