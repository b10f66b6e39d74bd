/* The closed-form flow at many times of a segment: the operations of closed_form.c, response by response in loops over the
 * times without branches, of which a compiler makes operations on vectors.
 */
#include "engine.h"
#include "numbers.h"
#include "responses.h"
#include "wide.h"

/* How many times are worked on, so that loops over the first `count` have no rest that is less than a register wide. */
static int whole_registers(int count)
{
    return (count + DOUBLES_AT_ONCE - 1) / DOUBLES_AT_ONCE * DOUBLES_AT_ONCE;
}

/* First time from which on the response to a constant load is a quotient; times ascend, and so does what it is told by. */
static int first_settled(const Oscillator *o, const Real *tau, int count)
{
    int j = 0;
    while (j < count && !(o->oscillates && o->settling * (tau[j] * tau[j]) >= QUARTER))
        j++;
    return j;
}

/* First time from which on the response to a harmonic load is a quotient. */
static int first_beating(const Oscillator *o, const Real *tau, int count)
{
    int j = 0;
    while (j < count && !is_quotient(o, tau[j] * tau[j]))
        j++;
    return j;
}

/* First time from which on a response that is no quotient has no series either. */
static int first_slow(const Oscillator *o, const Real *tau, int count)
{
    int j = 0;
    while (j < count && !(o->wd * tau[j] >= 0.5))
        j++;
    return j;
}

/* The same of a free mass. */
static int first_turned(const Oscillator *o, const Real *tau, int count)
{
    int j = 0;
    while (j < count && !(o->omega * tau[j] * (o->omega * tau[j]) >= QUARTER))
        j++;
    return j;
}

/* Cosine and sine of a harmonic's own angle since the anchor; up to 3 rad the product is as good as its reduction. */
static void turn_harmonic(const Harmonic *one, const Real *restrict tau, int count, Real *restrict cosine, Real *restrict sine)
{
    Real angle[TIMES_AT_ONCE];
    int j;
    for (j = 0; j < count; j++)
        angle[j] = one->omega * tau[j];
    for (j = count - 1; j >= 0 && angle[j] > 3; j--)
        angle[j] = turn_angle(one->cycles, one->cycles_lo, tau[j]);
    for (j = 0; j < count; j++)
        moderate_sine_cosine(angle[j], &sine[j], &cosine[j]);
}

/* A free mass under its constant load. */
static void move_freely(const Motion *y, const Real *restrict tau, int count, Real *restrict q, Real *restrict u)
{
    const Real q0 = y->q0, u0 = y->u0, load = y->load;
    int j;
    for (j = 0; j < count; j++) {
        q[j] = q0 + u0 * tau[j] + load * (tau[j] * tau[j] / 2);
        u[j] = u0 + load * tau[j];
    }
}

/* Responses to a harmonic load by their series at the first `count` times, and with them at some behind. */
static void response_series_at(const Oscillator *restrict o, const Real *restrict tau, int count, Real *restrict hc, Real *restrict hs)
{
    const int whole = whole_registers(count);
    int j;
    for (j = 0; j < whole; j++)
        series_response(o, tau[j], &hc[j], &hs[j]);
}

/* Add the responses of a free mass to a harmonic load. */
static void drive_freely(const Oscillator *o, const Response *response, const Real *restrict tau, int count,
                         const Real *restrict cosine, const Real *restrict sine, Real *restrict q, Real *restrict u)
{
    const Real load_sine = response->load_sine, load_cosine = response->load_cosine, omega = o->omega, inverse = o->inverse_r;
    const int turned = first_turned(o, tau, count);
    Real hc[TIMES_AT_ONCE], hs[TIMES_AT_ONCE];
    int j;
    response_series_at(o, tau, turned, hc, hs);
    for (j = turned; j < count; j++) {
        hc[j] = (cosine[j] - 1) * inverse;
        hs[j] = (sine[j] - omega * tau[j]) * inverse;
    }
    for (j = 0; j < count; j++) {
        q[j] = q[j] + (load_sine * hc[j] + load_cosine * hs[j]);
        u[j] = u[j] + (load_sine * (sine[j] / omega) + load_cosine * (omega * hc[j]));
    }
}

/* Release and impulse response of an oscillation. */
static void swing_at(const Oscillator *restrict o, const Real *restrict tau, int count, Real *restrict release,
                     Real *restrict impulse)
{
    Real sine[TIMES_AT_ONCE], cosine[TIMES_AT_ONCE];
    int j;
    for (j = 0; j < count; j++)
        moderate_sine_cosine(o->wd * tau[j], &sine[j], &cosine[j]);
    for (j = 0; j < count; j++)
        swing(o, tau[j], sine[j], cosine[j], &release[j], &impulse[j]);
}

/* Response to a constant load at the first `count` times, and with them at some behind. */
static void steady_series_at(const Oscillator *restrict o, const Real *restrict tau, int count, Real *restrict steady)
{
    const int whole = whole_registers(count);
    int j;
    for (j = 0; j < whole; j++)
        steady[j] = tau[j] * tau[j] * horner(o->steady_series, SERIES_TERMS, o->rate * tau[j]);
}

/* An oscillator under its constant load; its release and impulse response for the drives. */
static void oscillate(const Oscillator *o, const Motion *y, const Real *restrict tau, int count, Real *restrict release,
                      Real *restrict impulse, Real *restrict q, Real *restrict u)
{
    const Real a = o->a, b = o->b, per_b = o->per_b, q0 = y->q0, u0 = y->u0, load = y->load;
    const int settled = first_settled(o, tau, count);
    Real steady[TIMES_AT_ONCE];
    int j;
    if (o->oscillates && o->wd * tau[count - 1] < LARGEST_ANGLE)
        swing_at(o, tau, count, release, impulse);
    else
        for (j = 0; j < count; j++)
            release_and_impulse(o, tau[j], &release[j], &impulse[j]);
    if (o->oscillates)
        steady_series_at(o, tau, settled, steady);
    else
        for (j = 0; j < settled; j++)
            steady[j] = constant_response(o, tau[j], release[j]);
    for (j = settled; j < count; j++)
        steady[j] = (1 - release[j]) * per_b;
    for (j = 0; j < count; j++) {
        q[j] = q0 * release[j] + u0 * impulse[j] + load * steady[j];
        u[j] = u0 * (release[j] - 2 * a * impulse[j]) - q0 * (b * impulse[j]) + load * impulse[j];
    }
}

/* Add the responses of an oscillator to a harmonic load: series, near resonance nested differences, then quotients. */
static void drive(const Oscillator *o, const Response *response, const Real *restrict tau, int count, const Real *restrict release,
                  const Real *restrict impulse, const Real *restrict cosine, const Real *restrict sine, Real *restrict q,
                  Real *restrict u)
{
    const Real a = o->a, b = o->b, omega = o->omega, real = o->inverse_r, imaginary = o->inverse_i;
    const Real load_sine = response->load_sine, load_cosine = response->load_cosine;
    const int slow = first_slow(o, tau, count), beating = first_beating(o, tau, count);
    Real hc[TIMES_AT_ONCE], hs[TIMES_AT_ONCE];
    int j;
    response_series_at(o, tau, slow < beating ? slow : beating, hc, hs);
    for (j = slow; j < beating; j++)
        confluent_response(o, tau[j], cosine[j], sine[j], &hc[j], &hs[j]);
    for (j = 0; j < beating; j++) {
        q[j] = q[j] + (load_sine * hc[j] + load_cosine * hs[j]);
        u[j] = u[j] + (load_sine * (impulse[j] - omega * hs[j]) + load_cosine * (omega * hc[j]));
    }
    for (j = beating; j < count; j++) {
        Real nr = cosine[j] - release[j], ni = sine[j] - omega * impulse[j];
        Real vr = b * impulse[j] - omega * sine[j], vi = omega * (cosine[j] - (release[j] - 2 * a * impulse[j]));
        q[j] = q[j] + (load_sine * (nr * real + ni * imaginary) + load_cosine * (ni * real - nr * imaginary));
        u[j] = u[j] + (load_sine * (vr * real + vi * imaginary) + load_cosine * (vi * real - vr * imaginary));
    }
}

/* A coordinate and its rate at all times. */
static void move_coordinate(const Times *at, const Coordinate *c, const Motion *y, const Real *tau, Real *q, Real *u)
{
    Real release[TIMES_AT_ONCE], impulse[TIMES_AT_ONCE];
    int i;
    if (c->is_free)
        move_freely(y, tau, at->count, q, u);
    else
        oscillate(&c->oscillator, y, tau, at->count, release, impulse, q, u);
    for (i = 0; i < c->drive_count; i++) {
        const Oscillator *o = &c->drives[i].oscillator;
        const Real *cosine = at->cosine[c->drives[i].harmonic], *sine = at->sine[c->drives[i].harmonic];
        if (c->is_free)
            drive_freely(o, &y->responses[i], tau, at->count, cosine, sine, q, u);
        else
            drive(o, &y->responses[i], tau, at->count, release, impulse, cosine, sine, q, u);
    }
}

/* Fill whole registers with the times, the last of them again where there are none left; how many that makes. */
static int filled_up(const Real *times, int count, Real *tau)
{
    const int whole = whole_registers(count);
    int j;
    for (j = 0; j < whole; j++)
        tau[j] = times[j < count ? j : count - 1];
    return whole;
}

/* Work out at most TIMES_AT_ONCE ascending times, none of them negative, for the three functions below; the next single time is
 * evaluated anew, whatever it is.
 */
WIDE_WITH_CALLS void closed_form_many(Run *r, const Real *times, int count)
{
    const Modal *modal = r->mode->modal;
    Times *at = &r->closed_form.times;
    Real tau[TIMES_AT_ONCE];
    int i;
    at->count = filled_up(times, count, tau);
    r->evaluations += count - (times[0] == r->closed_form.counted);
    r->closed_form.counted = times[count - 1];
    r->closed_form.tau = NAN;
    for (i = 0; i < r->harmonic_count; i++)
        turn_harmonic(&r->harmonics[i], tau, at->count, at->cosine[i], at->sine[i]);
    for (i = 0; i < modal->count; i++)
        move_coordinate(at, &modal->coordinates[i], &r->closed_form.motions[i], tau, at->q[i], at->u[i]);
    at->count = count;
}

/* Sine of a harmonic, its phase at the anchor included. */
void closed_form_sines(const Run *r, int harmonic, Real *restrict out)
{
    const ClosedForm *f = &r->closed_form;
    const Real sin0 = f->sin0[harmonic], cos0 = f->cos0[harmonic];
    const Real *restrict cosine = f->times.cosine[harmonic], *restrict sine = f->times.sine[harmonic];
    int j;
    for (j = 0; j < f->times.count; j++)
        out[j] = sin0 * cosine[j] + cos0 * sine[j];
}

/* Add factor times the cosine of a harmonic, its phase at the anchor included. */
static void add_cosines(const Run *r, int harmonic, Real factor, Real *restrict out)
{
    const ClosedForm *f = &r->closed_form;
    const Real sin0 = f->sin0[harmonic], cos0 = f->cos0[harmonic];
    const Real *restrict cosine = f->times.cosine[harmonic], *restrict sine = f->times.sine[harmonic];
    int j;
    for (j = 0; j < f->times.count; j++)
        out[j] = out[j] + factor * (cos0 * cosine[j] - sin0 * sine[j]);
}

/* Displacement and velocity of the base. */
void closed_form_base(const Run *r, Real *restrict X, Real *restrict V)
{
    Real sines[TIMES_AT_ONCE];
    int i, j;
    for (j = 0; j < r->closed_form.times.count; j++)
        X[j] = V[j] = 0.0;
    for (i = 0; i < r->base_count; i++) {
        const Harmonic *term = &r->base[i];
        if (term->harmonic < 0)
            continue;
        closed_form_sines(r, term->harmonic, sines);
        for (j = 0; j < r->closed_form.times.count; j++)
            X[j] = X[j] + term->amplitude * sines[j];
        add_cosines(r, term->harmonic, term->amplitude * term->omega, V);
    }
}

/* Displacements and velocities of body c, those of the base given. */
WIDE void closed_form_body(const Run *r, int c, const Real *X, const Real *V, Real *restrict x, Real *restrict v)
{
    const ClosedForm *f = &r->closed_form;
    const Place *place = &r->mode->modal->places[c];
    const int count = f->times.count;
    const Real rest = f->rest[c];
    int i, j;
    for (j = 0; j < count; j++) {
        x[j] = rest;
        v[j] = place->shares || place->base ? -0.0 : 0.0;
    }
    for (i = 0; i < place->shares; i++) {
        const Real share = place->share[i].share;
        const Real *restrict q = f->times.q[place->share[i].m], *restrict u = f->times.u[place->share[i].m];
        for (j = 0; j < count; j++) {
            x[j] = x[j] + share * q[j];
            v[j] = v[j] + share * u[j];
        }
    }
    for (j = 0; place->base && j < count; j++) {
        x[j] = x[j] + X[j];
        v[j] = v[j] + V[j];
    }
}
