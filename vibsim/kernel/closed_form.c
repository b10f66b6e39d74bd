/* The closed-form flow of the ideal source; twin of vibsim/flows/closed_form.py. */
#include "first_root.h"
#include "kernel.h"
#include "numbers.h"

#define STEPS_PER_CALL 4096
#define POLISHING 10
#define TURNING 60

static const Regime *regime_of(const ClosedForm *f)
{
    return &f->regimes[f->regime[0]][f->regime[1]][f->regime[2]];
}

void closed_form_enter(Run *r, const State *state, Mode mode)
{
    const Scene *s = &r->scene;
    ClosedForm *f = &r->closed;
    f->leading = 1;
    f->locked = s->has_block2 == 0 || (s->has_friction != 0 && mode.friction == 0);
    f->regime[0] = f->locked;
    f->regime[1] = mode.contact;
    f->regime[2] = mode.friction + 1;
    f->t0 = f->t = state->t;
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
    f->watched_t = f->t0;
    f->watched_value = f->watched_slope = f->watched_curvature = f->watched_bound = 0.0;
    f->stall = 1.0;
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
static void measure(ClosedForm *f)
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

static void evaluate(Run *r, double tau)
{
    ClosedForm *f = &r->closed;
    const Regime *g = regime_of(f);
    const Oscillator *o = &g->oscillator;
    double release, impulse, steady, rate, stiff, y, u, sine = 0, cosine = 0;
    double y0 = f->y0, u0 = f->u0;
    if (tau == f->tau)
        return;
    r->evaluations += 1;
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
        harmonic_response(o, tau, release, impulse, cosine, sine, &hc, &hs);
        dc = impulse - f->omega * hs;
        ds = f->omega * hc;
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
    evaluate(r, tau);
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

static void jet_here(const ClosedForm *f, int count, double *d)
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
    jet_here(&r->closed, count, jet);
}

/* Bound of |y^(n)| over the window ahead. */
static double bound(const ClosedForm *f, const double *d, int n)
{
    const Regime *g = regime_of(f);
    const Oscillator *o = &g->oscillator;
    double size = fabs(d[n]) + fabs(d[n + 1]) * o->window;
    if (o->w0 > 0) {
        double ratio = d[n + 1] / o->w0, energy = sqrt(d[n] * d[n] + ratio * ratio);
        if (energy < size)
            size = energy;
    }
    return size + g->forced[n];
}

static double force_derivative(const Run *r, const double *d, int n)
{
    const Regime *g = regime_of(&r->closed);
    double force = g->k * d[n] + r->scene.c * d[n + 1];
    return n == 0 ? force + g->offset : force;
}

static double derivative(const Run *r, int function, const double *d, int n)
{
    const Scene *s = &r->scene;
    const ClosedForm *f = &r->closed;
    double value;
    if (function == GAP) {
        value = -(s->stop_sign * d[n]);
        value = n == 0 ? value - s->G : value;
        return r->mode.contact ? value : -value;
    }
    if (function == CLEARANCE) {
        value = n == 0 ? s->rest_distance - d[0] : -d[n];
        return r->mode.violated ? -value : value;
    }
    if (function == SLIDE) {
        if (n == 0)
            return r->mode.friction * (f->V - f->share2 * f->u);
        value = force_derivative(r, d, n - 1);
        value = n == 1 ? value - r->mode.friction * f->limit : value;
        return r->mode.friction * value / s->m2;
    }
    value = force_derivative(r, d, n);
    value = function == HOLD_PLUS ? -value : value;
    return n == 0 ? f->limit + value : value;
}

static double derivative_bound(const Run *r, int function, const double *d, int n)
{
    const ClosedForm *f = &r->closed;
    double k = regime_of(f)->k, c = r->scene.c;
    if (function == GAP || function == CLEARANCE)
        return bound(f, d, n);
    if (function == SLIDE)
        return (k * bound(f, d, n - 1) + c * bound(f, d, n)) / r->scene.m2;
    return k * bound(f, d, n) + c * bound(f, d, n + 1);
}

static double noise_of(const Run *r, int function)
{
    const Scene *s = &r->scene;
    const ClosedForm *f = &r->closed;
    const Regime *g = regime_of(f);
    double unit = EPS * (16 + g->oscillator.w0 * f->tau);
    if (function == GAP)
        return unit * (f->scale_y + fabs(s->G));
    if (function == CLEARANCE)
        return unit * (f->scale_y + fabs(s->rest_distance));
    if (function == SLIDE)
        return unit * (f->scale_V + f->share2 * f->scale_u);
    return unit * (g->k * f->scale_y + s->c * f->scale_u + fabs(g->offset) + f->limit);
}

static void move(ClosedForm *f, double step)
{
    f->t = f->t0 + ((f->t - f->t0) + step);
}

static int lead(Run *r)
{
    ClosedForm *f = &r->closed;
    double step = regime_of(f)->oscillator.window, d[JET_ORDER + 1];
    int i;
    f->leading = 0;
    measure(f);
    jet_here(f, JET_ORDER, d);
    for (i = 0; i < r->function_count; i++) {
        int function = r->functions[i], order = r->known.order[function];
        double first, limit, ahead;
        while (order < JET_ORDER - 2 && derivative(r, function, d, order) == 0)
            order++;
        if (order == 0 && derivative(r, function, d, 0) <= noise_of(r, function) && derivative(r, function, d, 1) <= 0)
            return function;
        if (order >= JET_ORDER - 3)
            continue;
        first = derivative(r, function, d, order);
        if (order == 0)
            first = first - noise_of(r, function);
        first = first > 0 ? first : 0.0;
        limit = derivative_bound(r, function, d, order + 2);
        ahead = deflated_step(order, first, derivative(r, function, d, order + 1), limit);
        step = ahead < step ? ahead : step;
        if (function == GAP) {
            f->watched_t = f->t0;
            f->watched_value = derivative(r, GAP, d, 0);
            f->watched_slope = derivative(r, GAP, d, 1);
            f->watched_curvature = derivative(r, GAP, d, 2);
            f->watched_bound = derivative_bound(r, GAP, d, 2);
        }
    }
    move(f, step);
    return NOTHING;
}

/* Keep the minimum of the gap function between two times, by safeguarded Newton steps on its slope. */
static void turn_between(Run *r, double low, double high)
{
    ClosedForm *f = &r->closed;
    double here = f->t, t = low + (high - low) / 2, settled = f->settled * regime_of(f)->oscillator.window;
    double value = 0, slope = 0, curvature = 0, ahead = t, d[6];
    int i;
    for (i = 0; i < TURNING; i++) {
        evaluate(r, t - f->t0);
        jet_here(f, 4, d);
        value = derivative(r, GAP, d, 0);
        slope = derivative(r, GAP, d, 1);
        curvature = derivative(r, GAP, d, 2);
        if (slope < 0)
            low = t;
        else
            high = t;
        ahead = curvature > 0 ? t - slope / curvature : low;
        if (curvature > 0 && fabs(ahead - t) < settled)
            break;
        if (!(low < ahead && ahead < high))
            ahead = low + (high - low) / 2;
        t = ahead;
    }
    if (curvature > 0)
        value = value - slope * slope / (2 * curvature);
    value = value > 0 ? value : 0.0;
    if (value < r->margin) {
        r->margin = value;
        r->margin_time = ahead;
    }
    evaluate(r, here - f->t0);
}

/* Look for a minimum of the gap function since the point watched before; then watch from here on. */
static void watch_turn(Run *r, double value, double slope, double curvature, double limit)
{
    ClosedForm *f = &r->closed;
    double low = f->watched_t, was = f->watched_value, before = f->watched_slope, bend = f->watched_curvature;
    double length = f->t - low, least = was + before * length - f->watched_bound * (length * length) / 2;
    f->watched_t = f->t;
    f->watched_value = value;
    f->watched_slope = slope;
    f->watched_curvature = curvature;
    f->watched_bound = limit;
    if ((least < was ? least : was) >= r->margin)
        return;
    if (before < 0 && 0 <= slope) {
        turn_between(r, low, f->t);
    } else if ((before < 0) == (slope < 0) &&
               ((bend < 0 && 0 < curvature) || (before < 0 && curvature < 0 && 0 < bend))) {
        double middle = low + length * (bend / (bend - curvature)), between, d[6];
        evaluate(r, middle - f->t0);
        jet_here(f, 4, d);
        between = derivative(r, GAP, d, 1);
        evaluate(r, f->t - f->t0);
        if (before >= 0 && 0 > between)
            turn_between(r, middle, f->t);
        else if (before < 0 && 0 <= between)
            turn_between(r, low, middle);
    }
}

static void turn_before_event(Run *r, int function)
{
    ClosedForm *f = &r->closed;
    double d[6];
    if (r->scene.has_stop != 0 && function != GAP) {
        evaluate(r, f->t - f->t0);
        jet_here(f, 4, d);
        watch_turn(r, derivative(r, GAP, d, 0), derivative(r, GAP, d, 1), derivative(r, GAP, d, 2), 0.0);
    }
}

/* Go to the one zero of `function` ahead, by Halley's iteration. */
static void polish(Run *r, int function)
{
    ClosedForm *f = &r->closed;
    double start = f->t, window = regime_of(f)->oscillator.window, d[6];
    int i;
    for (i = 0; i < POLISHING; i++) {
        double value, slope, curvature, step, reach, before = f->t;
        jet_here(f, 4, d);
        value = derivative(r, function, d, 0);
        slope = derivative(r, function, d, 1);
        curvature = derivative(r, function, d, 2);
        step = -(2 * value * slope) / (2 * slope * slope - value * curvature);
        move(f, step);
        f->t = f->t > start ? f->t : start;
        reach = fabs(curvature) * window < fabs(slope) ? window : fabs(slope / curvature);
        if (f->t == before || fabs(step) < f->settled * reach)
            return;
        r->steps += 1;
        evaluate(r, f->t - f->t0);
    }
}

static int step_once(Run *r)
{
    ClosedForm *f = &r->closed;
    double step = regime_of(f)->oscillator.window, rival = step, reach = 0, before, d[6];
    int nearest = NOTHING, alone = 0, i;
    r->steps += 1;
    evaluate(r, f->t - f->t0);
    measure(f);
    jet_here(f, 4, d);
    for (i = 0; i < r->function_count; i++) {
        int function = r->functions[i];
        double value = derivative(r, function, d, 0), slope = derivative(r, function, d, 1);
        double noise = noise_of(r, function), room, ahead, limit;
        if (value < -noise || (value <= noise && slope <= 0))
            return function;
        limit = derivative_bound(r, function, d, 2);
        if (function == GAP)
            watch_turn(r, value, slope, derivative(r, GAP, d, 2), limit);
        room = value - noise;
        ahead = safe_step(room > 0 ? room : 0.0, slope, limit);
        if (ahead < step) {
            rival = step;
            step = ahead;
            nearest = slope < 0 ? function : NOTHING;
            alone = slope < 0 && 8 * value * limit < slope * slope;
            reach = -2 * value / slope;
        } else if (ahead < rival) {
            rival = ahead;
        }
    }
    if (alone && reach <= rival) {
        polish(r, nearest);
        return nearest;
    }
    before = f->t;
    move(f, step);
    if (f->t > before) {
        f->stall = 1.0;
        return NOTHING;
    }
    if (nearest == NOTHING) {
        r->uncertified += 1;
        f->t = before + (nextafter(before, INFINITY) - before) * f->stall;
        f->stall = f->stall * 2;
    }
    return nearest;
}

double closed_form_advance(Run *r, double limit, int *function)
{
    ClosedForm *f = &r->closed;
    int i;
    *function = NOTHING;
    if (f->leading) {
        *function = lead(r);
        if (*function != NOTHING)
            return f->t;
    }
    if (r->function_count == 0)
        f->t = limit;
    for (i = 0; i < STEPS_PER_CALL; i++) {
        if (f->t >= limit)
            return limit;
        *function = step_once(r);
        if (*function != NOTHING && f->t > limit) {
            *function = NOTHING;
            return limit;
        }
        if (*function != NOTHING) {
            turn_before_event(r, *function);
            return f->t;
        }
    }
    return f->t > limit ? limit : f->t;
}
