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
    for (m = 0; m < r->mode->modal->count; m++)
        anchor_coordinate(r, m);
    f->tau = 0.0;
    closed_form_open(r);
}

static void evaluate_coordinate(Run *r, int m, double tau)
{
    ClosedForm *f = &r->closed_form;
    const Coordinate *c = &r->mode->modal->coordinates[m];
    double q0 = f->q0[m], u0 = f->u0[m], load = f->load[m], q, u, release = 0, impulse = 0;
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
        double *response = f->responses + 4 * at, cosine = f->cosine[h], sine = f->sine[h];
        if (c->is_free) {
            free_harmonic_response(o, tau, cosine, sine, &response[0], &response[1]);
            response[2] = sine / o->omega;
            response[3] = o->omega * response[0];
        } else {
            harmonic_response(o, tau, release, impulse, cosine, sine, &response[0], &response[1], &response[2], &response[3]);
        }
        q = q + (f->load_sine[at] * response[0] + f->load_cosine[at] * response[1]);
        u = u + (f->load_sine[at] * response[2] + f->load_cosine[at] * response[3]);
    }
    f->q[m] = q;
    f->u[m] = u;
}

void closed_form_evaluate(Run *r, double tau)
{
    ClosedForm *f = &r->closed_form;
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
    for (m = 0; m < r->mode->modal->count; m++)
        evaluate_coordinate(r, m, tau);
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
            int h = c->driven[i];
            double size = fabs(c->sines[h]) + fabs(c->cosines[h]);
            q = q + size * (fabs(response[0]) + fabs(response[1]));
            u = u + size * (fabs(response[2]) + fabs(response[3]));
        }
        f->scale_q[m] = q;
        f->scale_u[m] = u;
    }
}

static void jet_of(Run *r, int m, int count)
{
    ClosedForm *f = &r->closed_form;
    const Coordinate *c = &r->mode->modal->coordinates[m];
    double *d = f->jets[m], sines[64], cosines[64];
    int i, n;
    d[0] = f->q[m];
    d[1] = f->u[m];
    for (i = 0; i < c->driven_count; i++) {
        sines[i] = c->sines[c->driven[i]];
        cosines[i] = c->cosines[c->driven[i]];
    }
    for (n = 0; n < count - 1; n++) {
        double term = 0.0;
        for (i = 0; i < c->driven_count; i++) {
            int h = c->driven[i];
            double turns[4];
            turns[0] = f->sines[h];
            turns[1] = f->cosines[h];
            turns[2] = -f->sines[h];
            turns[3] = -f->cosines[h];
            term = term + (sines[i] * turns[n % 4] + cosines[i] * turns[(n + 1) % 4]);
            sines[i] = sines[i] * r->harmonics[h].omega;
            cosines[i] = cosines[i] * r->harmonics[h].omega;
        }
        term = term - 2 * c->a * d[n + 1] - c->b * d[n];
        d[n + 2] = n == 0 ? term + f->load[m] : term;
    }
}

void closed_form_jets(Run *r, int count)
{
    ClosedForm *f = &r->closed_form;
    int m, i, n;
    for (m = 0; m < r->mode->modal->count; m++)
        jet_of(r, m, count);
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

void closed_form_state_after(Run *r, double tau, State *out)
{
    const ClosedForm *f = &r->closed_form;
    const Modal *modal = r->mode->modal;
    double X, V;
    int c, i;
    closed_form_evaluate(r, tau);
    base_motion(r, f->sines, f->cosines, &X, &V);
    out->t = r->t0 + tau;
    out->phase = out->turns = out->w = 0.0;
    for (c = 0; c < r->bodies; c++) {
        const Place *place = &modal->places[c];
        double position = fixed_sum(r, place->first_fixed, place->fixed), rate = 0.0;
        for (i = 0; i < place->shares; i++) {
            const Share *share = &modal->shares[place->first_share + i];
            double part = share->share * f->q[share->m];
            position = i == 0 && place->fixed == 0 ? part : position + part;
            part = share->share * f->u[share->m];
            rate = i == 0 ? part : rate + part;
        }
        if (place->base) {
            position = place->fixed + place->shares == 0 ? X : position + X;
            rate = rate + V;
        }
        out->x[c] = position;
        out->v[c] = rate;
    }
}
