/* The closed-form flow of the ideal source; twin of vibsim/flows/closed_form.py. */
#include "kernel.h"
#include "../engine/numbers.h"

const Regime *regime_of(const ClosedForm *f)
{
    return &f->regimes[f->regime[0]][f->regime[1]][f->regime[2]];
}

void closed_form_enter(Run *r, const State *state, Mode mode)
{
    const Scene *s = &r->scene;
    ClosedForm *f = &r->closed;
    f->locked = s->has_block2 == 0 || (s->has_friction != 0 && mode.friction == 0);
    f->regime[0] = f->locked;
    f->regime[1] = mode.contact;
    f->regime[2] = mode.friction + 1;
    f->t0 = state->t;
    f->x2 = state->x2;
    f->y0 = state->x1 - state->x2;
    f->u0 = state->v1 - state->v2;
    if (!f->locked) {
        f->X0 = f->share2 * state->x1 + f->share1 * state->x2;
        f->V0 = f->share2 * state->v1 + f->share1 * state->v2;
    }
    f->sin0 = 0.0;
    f->cos0 = 1.0;
    if (f->driven) {
        double angle = turn_angle(s->cycles, s->cycles_lo, state->t);
        f->sin0 = sin(angle);
        f->cos0 = cos(angle);
    }
    f->load_sine = regime_of(f)->amplitude * f->sin0;
    f->load_cosine = regime_of(f)->amplitude * f->cos0;
    f->centre_sine = regime_of(f)->centre_amplitude * f->sin0;
    f->centre_cosine = regime_of(f)->centre_amplitude * f->cos0;
    f->tau = 0.0;
    f->y = f->y0;
    f->u = f->u0;
    f->sine = f->sin0;
    f->cosine = f->cos0;
    f->stiff = f->impulse = f->steady = 0.0;
    f->hc = f->hs = f->dc = f->ds = f->centre_dc = f->centre_ds = 0.0;
    if (!f->locked) {
        f->X = f->X0;
        f->V = f->V0;
    }
    closed_form_open(r);
}

static void centre(ClosedForm *f, const Regime *g, double tau, double sine, double cosine)
{
    double load = g->centre_load;
    f->X = f->X0 + f->V0 * tau + load * (tau * tau / 2);
    f->V = f->V0 + load * tau;
    if (f->driven) {
        double hc, hs;
        free_harmonic_response(&f->mass_point, tau, cosine, sine, &hc, &hs);
        f->centre_dc = sine / f->omega;
        f->centre_ds = f->omega * hc;
        f->X = f->X + (f->centre_sine * hc + f->centre_cosine * hs);
        f->V = f->V + (f->centre_sine * f->centre_dc + f->centre_cosine * f->centre_ds);
    }
}

/* Magnitudes of the terms of y, u and V at the point evaluated last: what their rounding is proportional to. */
void closed_form_measure(ClosedForm *f)
{
    const Regime *g = regime_of(f);
    double amplitude = fabs(g->amplitude), load = g->load;
    f->scale_y = fabs(f->y0) + fabs(f->u0 * f->impulse) + fabs(load * f->steady);
    f->scale_u = fabs(f->u0) + fabs(f->y0 * f->stiff) + fabs(load * f->impulse);
    if (f->driven) {
        f->scale_y = f->scale_y + amplitude * (fabs(f->hc) + fabs(f->hs));
        f->scale_u = f->scale_u + amplitude * (fabs(f->dc) + fabs(f->ds));
    }
    if (!f->locked) {
        f->scale_V = fabs(f->V0) + fabs(g->centre_load * f->tau);
        if (f->driven)
            f->scale_V = f->scale_V + fabs(g->centre_amplitude) * (fabs(f->centre_dc) + fabs(f->centre_ds));
    }
}

void closed_form_evaluate(Run *r, double tau)
{
    ClosedForm *f = &r->closed;
    const Regime *g = regime_of(f);
    const Oscillator *o = &g->oscillator;
    double release, impulse, steady, rate, stiff, y, u, sine = 0, cosine = 0;
    double y0 = f->y0, u0 = f->u0;
    if (tau == f->tau)
        return;
    r->evaluations += 1;
    r->spent += 1;
    release_and_impulse(o, tau, &release, &impulse);
    steady = constant_response(o, tau, release);
    rate = release - 2 * o->a * impulse;
    stiff = o->b * impulse;
    y = y0 * release + u0 * impulse + g->load * steady;
    u = u0 * rate - y0 * stiff + g->load * impulse;
    f->stiff = stiff;
    f->impulse = impulse;
    f->steady = steady;
    if (f->driven) {
        double angle = f->omega * tau, hc, hs, dc, ds;
        if (angle > 3)
            angle = turn_angle(r->scene.cycles, r->scene.cycles_lo, tau);
        cosine = cos(angle);
        sine = sin(angle);
        harmonic_response(o, tau, release, impulse, cosine, sine, &hc, &hs, &dc, &ds);
        y = y + (f->load_sine * hc + f->load_cosine * hs);
        u = u + (f->load_sine * dc + f->load_cosine * ds);
        f->hc = hc;
        f->hs = hs;
        f->dc = dc;
        f->ds = ds;
        f->sine = f->sin0 * cosine + f->cos0 * sine;
        f->cosine = f->cos0 * cosine - f->sin0 * sine;
    }
    f->y = y;
    f->u = u;
    f->tau = tau;
    if (!f->locked)
        centre(f, g, tau, sine, cosine);
}

double closed_form_longest_piece(const Run *r, double tau)
{
    const Oscillator *o = &regime_of(&r->closed)->oscillator;
    double longest = 1.5 * o->window, growing = o->a > 0 ? 1.5 / (2 * o->a) + tau : longest;
    return growing < longest ? growing : longest;
}

void closed_form_state_after(Run *r, double tau, State *out)
{
    const ClosedForm *f = &r->closed;
    closed_form_evaluate(r, tau);
    out->t = f->t0 + tau;
    out->phase = out->turns = out->w = 0.0;
    if (f->locked) {
        out->x1 = f->x2 + f->y;
        out->v1 = f->u;
        out->x2 = f->x2;
        out->v2 = 0.0;
        return;
    }
    out->x1 = f->X + f->share1 * f->y;
    out->x2 = f->X - f->share2 * f->y;
    out->v1 = f->V + f->share1 * f->u;
    out->v2 = f->V - f->share2 * f->u;
}

void closed_form_jet_here(const ClosedForm *f, int count, double *d)
{
    const Regime *g = regime_of(f);
    const Oscillator *o = &g->oscillator;
    double loads[4], amplitude = g->amplitude;
    int n;
    loads[0] = f->sine;
    loads[1] = f->cosine;
    loads[2] = -f->sine;
    loads[3] = -f->cosine;
    d[0] = f->y;
    d[1] = f->u;
    for (n = 0; n < count - 1; n++) {
        double term = amplitude * loads[n % 4] - 2 * o->a * d[n + 1] - o->b * d[n];
        d[n + 2] = n == 0 ? term + g->load : term;
        amplitude = amplitude * f->omega;
    }
}

void closed_form_jet(Run *r, const State *state, Mode mode, int count, double *jet)
{
    closed_form_enter(r, state, mode);
    closed_form_jet_here(&r->closed, count, jet);
}
