/* The closed-form flow; twin of vibsim/engine/closed_form.py. */
#include "engine.h"
#include "numbers.h"

static double fixed_sum(const Run *r, int first, int count)
{
    const Fixed *fixed = r->mode->modal->fixed + first;
    double total = 0.0;
    int i;
    for (i = 0; i < count; i++) {
        double part = fixed[i].sign * r->closed_form.x0[fixed[i].column];
        total = i == 0 ? part : total + part;
    }
    return total;
}

/* Displacement and velocity of the base from sines and cosines of the harmonics. */
static void base_motion(const Run *r, const double *sines, const double *cosines, double *X, double *V)
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

static double weighted(const Source *sources, int count, const double *values)
{
    double total = 0.0;
    int i;
    for (i = 0; i < count; i++) {
        double part = sources[i].weight * (sources[i].Q < 0 ? values[sources[i].P] : values[sources[i].P] - values[sources[i].Q]);
        total = i == 0 ? part : total + part;
    }
    return total;
}

static void anchor_coordinate(Run *r, int m)
{
    ClosedForm *f = &r->closed_form;
    const Modal *modal = r->mode->modal;
    const Coordinate *c = &modal->coordinates[m];
    double load = c->load;
    int i;
    for (i = 0; i < c->shifts; i++) {
        const Shift *shift = &modal->shifts[c->first_shift + i];
        load = load + shift->factor * fixed_sum(r, shift->first, shift->count);
    }
    f->q[m] = f->q0[m] = weighted(modal->sources + c->first_source, c->sources, f->x0);
    f->u[m] = f->u0[m] = weighted(modal->sources + c->first_source, c->sources, f->v0);
    f->load[m] = load;
    f->stiff[m] = f->impulse[m] = f->steady[m] = 0.0;
    for (i = 0; i < c->driven_count; i++) {
        int h = c->driven[i], at = m * r->harmonic_count + i, k;
        f->load_sine[at] = c->sines[h] * f->sin0[h] + c->cosines[h] * f->cos0[h];
        f->load_cosine[at] = c->sines[h] * f->cos0[h] - c->cosines[h] * f->sin0[h];
        for (k = 0; k < 4; k++)
            f->responses[4 * at + k] = 0.0;
    }
}

void closed_form_enter(Run *r, const State *state)
{
    ClosedForm *f = &r->closed_form;
    int n = r->bodies, h, c, m;
    r->closed = 1;
    r->t0 = state->t;
    for (h = 0; h < r->harmonic_count; h++) {
        const Harmonic *one = &r->harmonics[h];
        double angle = turn_angle(one->cycles, one->cycles_lo, state->t) + one->phase;
        f->sines[h] = f->sin0[h] = sin(angle);
        f->cosines[h] = f->cos0[h] = cos(angle);
    }
    for (c = 0; c < n; c++) {
        f->x0[c] = state->x[c];
        f->v0[c] = state->v[c];
    }
    f->x0[n] = f->v0[n] = 0.0;
    base_motion(r, f->sin0, f->cos0, &f->x0[n + 1], &f->v0[n + 1]);
    for (c = 0; c < n; c++) {
        const Place *place = &r->mode->modal->places[c];
        f->rest[c] = place->fixed ? fixed_sum(r, place->first_fixed, place->fixed) : -0.0;
    }
    for (m = 0; m < r->mode->modal->count; m++)
        anchor_coordinate(r, m);
    f->tau = 0.0;
    closed_form_open(r);
}

static void evaluate_coordinate(const Run *r, ClosedForm *f, const Coordinate *c, int m, double tau)
{
    const double q0 = f->q0[m], u0 = f->u0[m], load = f->load[m];
    double q, u, release = 0, impulse = 0;
    int i;
    if (c->is_free) {
        q = q0 + u0 * tau + load * (tau * tau / 2);
        u = u0 + load * tau;
    } else {
        const Oscillator *o = c->oscillators;
        double steady, rate, stiff;
        release_and_impulse(o, tau, &release, &impulse);
        steady = constant_response(o, tau, release);
        rate = release - 2 * o->a * impulse;
        stiff = o->b * impulse;
        q = q0 * release + u0 * impulse + load * steady;
        u = u0 * rate - q0 * stiff + load * impulse;
        f->stiff[m] = stiff;
        f->impulse[m] = impulse;
        f->steady[m] = steady;
    }
    for (i = 0; i < c->driven_count; i++) {
        const Oscillator *o = &c->oscillators[i];
        int h = c->driven[i], at = m * r->harmonic_count + i;
        double *response = f->responses + 4 * at, cosine = f->cosine[h], sine = f->sine[h], hc, hs, dc, ds;
        if (c->is_free) {
            free_harmonic_response(o, tau, cosine, sine, &hc, &hs);
            dc = sine / o->omega;
            ds = o->omega * hc;
        } else {
            harmonic_response(o, tau, release, impulse, cosine, sine, &hc, &hs, &dc, &ds);
        }
        q = q + (f->load_sine[at] * hc + f->load_cosine[at] * hs);
        u = u + (f->load_sine[at] * dc + f->load_cosine[at] * ds);
        response[0] = hc;
        response[1] = hs;
        response[2] = dc;
        response[3] = ds;
    }
    f->q[m] = q;
    f->u[m] = u;
}

void closed_form_evaluate(Run *r, double tau)
{
    ClosedForm *f = &r->closed_form;
    const Modal *modal = r->mode->modal;
    int h, m;
    if (tau == f->tau)
        return;
    r->evaluations += 1;
    f->tau = tau;
    for (h = 0; h < r->harmonic_count; h++) {
        const Harmonic *one = &r->harmonics[h];
        double angle = one->omega * tau, cosine, sine;
        if (angle > 3) /* below, the product is as good as its reduction */
            angle = turn_angle(one->cycles, one->cycles_lo, tau);
        f->cosine[h] = cosine = cos(angle);
        f->sine[h] = sine = sin(angle);
        f->sines[h] = f->sin0[h] * cosine + f->cos0[h] * sine;
        f->cosines[h] = f->cos0[h] * cosine - f->sin0[h] * sine;
    }
    for (m = 0; m < modal->count; m++)
        evaluate_coordinate(r, f, &modal->coordinates[m], m, tau);
}

void closed_form_measure(Run *r)
{
    ClosedForm *f = &r->closed_form;
    int m, i;
    for (m = 0; m < r->mode->modal->count; m++) {
        const Coordinate *c = &r->mode->modal->coordinates[m];
        double q0 = fabs(f->q0[m]), u0 = fabs(f->u0[m]), load = f->load[m], tau = f->tau, q, u;
        if (c->is_free) {
            q = q0 + fabs(u0 * tau) + fabs(load * (tau * tau / 2));
            u = u0 + fabs(load * tau);
        } else {
            q = q0 + fabs(f->u0[m] * f->impulse[m]) + fabs(load * f->steady[m]);
            u = u0 + fabs(f->q0[m] * f->stiff[m]) + fabs(load * f->impulse[m]);
        }
        for (i = 0; i < c->driven_count; i++) {
            const double *response = f->responses + 4 * (m * r->harmonic_count + i);
            double size = c->sizes[i];
            q = q + size * (fabs(response[0]) + fabs(response[1]));
            u = u + size * (fabs(response[2]) + fabs(response[3]));
        }
        f->scale_q[m] = q;
        f->scale_u[m] = u;
    }
}

/* Sum over harmonics of order n of the load on a coordinate; moves `sines` and `cosines` on to the next order. */
static double load_order(const Run *r, const Coordinate *c, int n, double *sines, double *cosines)
{
    const ClosedForm *f = &r->closed_form;
    double total = 0.0;
    int i;
    for (i = 0; i < c->driven_count; i++) {
        int h = c->driven[i];
        double turns[4];
        turns[0] = f->sines[h];
        turns[1] = f->cosines[h];
        turns[2] = -f->sines[h];
        turns[3] = -f->cosines[h];
        total = total + (sines[i] * turns[n % 4] + cosines[i] * turns[(n + 1) % 4]);
        sines[i] = sines[i] * r->harmonics[h].omega;
        cosines[i] = cosines[i] * r->harmonics[h].omega;
    }
    return total;
}

static void jet_of(Run *r, const Coordinate *c, int m, int count)
{
    ClosedForm *f = &r->closed_form;
    const double twice = 2 * c->a, b = c->b;
    double *d = f->jets[m], sine = 0, cosine = 0, turn = 0, next_turn = 0, omega = 0, load = f->load[m];
    double sines[64], cosines[64];
    int one = c->driven_count == 1, i, n;
    d[0] = f->q[m];
    d[1] = f->u[m];
    if (count < 2)
        return;
    for (i = 0; i < c->driven_count; i++) {
        sines[i] = c->sines[c->driven[i]];
        cosines[i] = c->cosines[c->driven[i]];
    }
    if (one) {
        int h = c->driven[0];
        sine = sines[0];
        cosine = cosines[0];
        turn = f->sines[h];
        next_turn = f->cosines[h];
        omega = r->harmonics[h].omega;
    }
    for (n = 0; n < count - 1; n++) {
        double term = 0.0, before = turn;
        if (one) {
            term = sine * turn + cosine * next_turn;
            sine = sine * omega;
            cosine = cosine * omega;
            turn = next_turn;
            next_turn = -before;
        } else if (c->driven_count > 0) {
            term = load_order(r, c, n, sines, cosines);
        }
        if (!c->is_free)
            term = term - twice * d[n + 1] - b * d[n];
        d[n + 2] = n == 0 ? term + load : term;
    }
}

/* Derivatives of the coordinates as far as the event functions' n-th and a bound of it ask for them. */
void closed_form_jets(Run *r, int n)
{
    ClosedForm *f = &r->closed_form;
    const Modal *modal = r->mode->modal;
    int count = n + 3, m, i;
    for (m = 0; m < modal->count; m++)
        jet_of(r, &modal->coordinates[m], m, n + 1 + modal->coordinates[m].depth);
    if (r->base_count == 0)
        return;
    for (n = 0; n <= count; n++)
        f->base[n] = 0.0;
    for (i = 0; i < r->base_count; i++) {
        const Harmonic *term = &r->base[i];
        double factor = term->amplitude, turns[4];
        if (term->harmonic < 0)
            continue;
        turns[0] = f->sines[term->harmonic];
        turns[1] = f->cosines[term->harmonic];
        turns[2] = -turns[0];
        turns[3] = -turns[1];
        for (n = 0; n <= count; n++) {
            f->base[n] = f->base[n] + factor * turns[n % 4];
            factor = factor * term->omega;
        }
    }
}

/* Each body is where what rests of its place and its shares of the coordinates put it; -0.0 stands for nothing. */
void closed_form_state_after(Run *r, double tau, State *out)
{
    const ClosedForm *f = &r->closed_form;
    const Modal *modal = r->mode->modal;
    const double *q = f->q, *u = f->u;
    double X = 0.0, V = 0.0;
    int c, i;
    closed_form_evaluate(r, tau);
    if (r->base_count > 0)
        base_motion(r, f->sines, f->cosines, &X, &V);
    out->t = r->t0 + tau;
    out->phase = out->turns = out->w = 0.0;
    for (c = 0; c < r->bodies; c++) {
        const Place *place = &modal->places[c];
        const Share *share = &modal->shares[place->first_share];
        double position = f->rest[c], rate = -0.0;
        for (i = 0; i < place->shares; i++, share++) {
            position = position + share->share * q[share->m];
            rate = rate + share->share * u[share->m];
        }
        out->x[c] = place->base ? position + X : position;
        out->v[c] = place->base ? rate + V : place->shares ? rate : 0.0;
    }
}
