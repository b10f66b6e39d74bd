/* Certified first event on the closed-form flow; twin of vibsim/events/closed_form_search.py. */
#include "certificate.h"
#include "../engine/first_root.h"
#include "kernel.h"
#include "../engine/turning_point.h"

#define STEPS_PER_CALL 4096
#define POLISHING 10
#define NARROWER 16

void closed_form_open(Run *r)
{
    ClosedFormSearch *m = &r->closed.search;
    m->leading = 1;
    m->t = r->closed.t0;
    m->reach = m->window = regime_of(&r->closed)->oscillator.window;
    m->watched_t = m->t;
    m->watched_value = m->watched_slope = m->watched_curvature = m->watched_bound = 0.0;
    m->stall = 1.0;
}

static void move(Run *r, double step)
{
    ClosedFormSearch *m = &r->closed.search;
    m->t = r->closed.t0 + ((m->t - r->closed.t0) + step);
}

static void adapt_reach(ClosedFormSearch *m, double step)
{
    double wanted = NARROWER * step;
    m->reach = wanted < m->window ? wanted : m->window;
}

static void certify_crossing(Run *r, double slope, double bound, double noise)
{
    if (!crosses(slope, bound, noise))
        doubt(&r->certificate, r->closed.t0);
}

/* Doubt that the zero of `first` is the first, where another of `functions` may vanish as soon as it does. */
static void certify_order(Run *r, int first, const int *functions, int count, const double *d, const double *residues,
                          double value, double slope, double noise)
{
    double latest;
    int i;
    if (slope >= 0)
        return;
    latest = latest_zero(value, slope, noise, r->closed.search.t);
    for (i = 0; i < count; i++) {
        double other = event_derivative(r, functions[i], d, 0), fall = event_derivative(r, functions[i], d, 1);
        double blur = event_noise(r, functions[i]) + residues[functions[i]];
        int same = functions[i] == first || (other == value && fall == slope);
        if (!same && may_vanish_by(other, fall, blur, latest))
            doubt(&r->certificate, r->closed.t0);
    }
}

/* As `certify_order`, at the start of a segment: against the functions whose zeros are not known to be there. */
static void certify_leading_order(Run *r, int first, const double *d, double value, double slope, double noise)
{
    static const double none[FUNCTIONS] = {0, 0, 0, 0, 0};
    int others[FUNCTIONS], count = 0, i;
    for (i = 0; i < r->function_count; i++)
        if (r->known.order[r->functions[i]] == 0)
            others[count++] = r->functions[i];
    certify_order(r, first, others, count, d, none, value, slope, noise);
}

static int lead(Run *r)
{
    ClosedForm *f = &r->closed;
    ClosedFormSearch *m = &f->search;
    double step = m->window, d[JET_ORDER + 1];
    int i;
    m->leading = 0;
    closed_form_measure(f);
    closed_form_jet_here(f, JET_ORDER, d);
    m->function_count = 0;
    for (i = 0; i < r->function_count; i++) {
        int function = r->functions[i], order = r->known.order[function];
        double first, bound, ahead;
        while (order < JET_ORDER - 2 && event_derivative(r, function, d, order) == 0)
            order++;
        m->residues[function] = r->known.order[function] > 0 ? fabs(event_derivative(r, function, d, 0)) : 0.0;
        if (order >= JET_ORDER - 3)
            continue;
        m->functions[m->function_count++] = function;
        first = event_derivative(r, function, d, order);
        bound = event_bound(r, function, d, order + 2, m->window);
        if (order == 0) {
            double noise = event_noise(r, function), slope = event_derivative(r, function, d, 1);
            if (first <= noise && slope <= 0) {
                certify_crossing(r, slope, bound, noise);
                certify_leading_order(r, function, d, first, slope, noise);
                return function;
            }
            first = first - noise;
            if (first <= 0)
                doubt(&r->certificate, f->t0);
        }
        first = first > 0 ? first : 0.0;
        ahead = deflated_step(order, first, event_derivative(r, function, d, order + 1), bound);
        step = ahead < step ? ahead : step;
        if (function == GAP) {
            m->watched_t = f->t0;
            m->watched_value = event_derivative(r, GAP, d, 0);
            m->watched_slope = event_derivative(r, GAP, d, 1);
            m->watched_curvature = event_derivative(r, GAP, d, 2);
            m->watched_bound = event_bound(r, GAP, d, 2, m->window);
        }
    }
    adapt_reach(m, step);
    move(r, step);
    return NOTHING;
}

/* Slope and curvature of the gap function at time t. */
static void gap_slope(void *run, double t, double *slope, double *curvature)
{
    Run *r = run;
    double d[6];
    closed_form_evaluate(r, t - r->closed.t0);
    closed_form_jet_here(&r->closed, 4, d);
    *slope = event_derivative(r, GAP, d, 1);
    *curvature = event_derivative(r, GAP, d, 2);
}

static void turn_between(Run *r, double low, double high)
{
    ClosedForm *f = &r->closed;
    double t, turn, depth, d[4];
    turning_point(gap_slope, r, low, high, f->settled * f->search.window, &t, &turn, &depth);
    closed_form_evaluate(r, t - f->t0);
    closed_form_jet_here(f, 2, d);
    keep_turn(&r->certificate, event_derivative(r, GAP, d, 0) - depth, turn);
}

/* Look for a minimum of the gap function since the point watched before; then watch from here on. */
static void watch_turn(Run *r, double value, double slope, double curvature, double bound)
{
    ClosedFormSearch *m = &r->closed.search;
    double low = m->watched_t, was = m->watched_value, before = m->watched_slope, bend = m->watched_curvature;
    double length = m->t - low, least = was + before * length - m->watched_bound * (length * length) / 2;
    m->watched_t = m->t;
    m->watched_value = value;
    m->watched_slope = slope;
    m->watched_curvature = curvature;
    m->watched_bound = bound;
    if ((least < was ? least : was) >= r->certificate.margin)
        return;
    if (before < 0 && 0 <= slope) {
        turn_between(r, low, m->t);
    } else if ((before < 0) == (slope < 0) &&
               ((bend < 0 && 0 < curvature) || (before < 0 && curvature < 0 && 0 < bend))) {
        double middle = low + extreme_of_slope(length, before, bend, slope, curvature), between, unused;
        gap_slope(r, middle, &between, &unused);
        if (before >= 0 && 0 > between)
            turn_between(r, middle, m->t);
        else if (before < 0 && 0 <= between)
            turn_between(r, low, middle);
    }
    closed_form_evaluate(r, m->t - r->closed.t0);
}

static void turn_before(Run *r, int function)
{
    ClosedForm *f = &r->closed;
    double d[6];
    if (r->scene.has_stop != 0 && function != GAP) {
        closed_form_evaluate(r, f->search.t - f->t0);
        closed_form_jet_here(f, 4, d);
        watch_turn(r, event_derivative(r, GAP, d, 0), event_derivative(r, GAP, d, 1), event_derivative(r, GAP, d, 2), 0.0);
    }
}

/* Go to the one zero of `function` ahead, by Halley's iteration. */
static void polish(Run *r, int function)
{
    ClosedForm *f = &r->closed;
    ClosedFormSearch *m = &f->search;
    double start = m->t, d[6];
    int i;
    for (i = 0; i < POLISHING; i++) {
        double value, slope, curvature, newton, step, near, before = m->t;
        closed_form_jet_here(f, 4, d);
        value = event_derivative(r, function, d, 0);
        slope = event_derivative(r, function, d, 1);
        curvature = event_derivative(r, function, d, 2);
        newton = value / slope;
        step = -(2 * newton) / (2 - newton * (curvature / slope));
        move(r, step);
        m->t = m->t > start ? m->t : start;
        near = fabs(curvature) * m->window < fabs(slope) ? m->window : fabs(slope / curvature);
        if (m->t == before || fabs(step) < f->settled * near)
            return;
        r->steps += 1;
        closed_form_evaluate(r, m->t - f->t0);
    }
}

/* Leave a point where the certified step is shorter than the time grid's. */
static void creep(Run *r, double before)
{
    ClosedFormSearch *m = &r->closed.search;
    doubt(&r->certificate, r->closed.t0);
    m->t = before + (nextafter(before, INFINITY) - before) * m->stall;
    m->stall = m->stall * 2;
}

static int step_once(Run *r)
{
    ClosedForm *f = &r->closed;
    ClosedFormSearch *m = &f->search;
    double step = m->reach, rival = step, near = 0, before, d[6], course[4] = {0, 0, 0, 0};
    int nearest = NOTHING, alone = 0, i;
    r->steps += 1;
    closed_form_evaluate(r, m->t - f->t0);
    closed_form_measure(f);
    closed_form_jet_here(f, 4, d);
    for (i = 0; i < m->function_count; i++) {
        int function = m->functions[i];
        double value = event_derivative(r, function, d, 0), slope = event_derivative(r, function, d, 1);
        double noise = event_noise(r, function) + m->residues[function];
        double bound = event_bound(r, function, d, 2, m->reach), room, ahead;
        if (value < -noise || (value <= noise && slope <= 0)) {
            certify_crossing(r, slope, bound, noise);
            certify_order(r, function, m->functions, m->function_count, d, m->residues, value, slope, noise);
            return function;
        }
        if (function == GAP)
            watch_turn(r, value, slope, event_derivative(r, GAP, d, 2), bound);
        room = value - noise;
        ahead = safe_step(room > 0 ? room : 0.0, slope, bound);
        if (ahead < step) {
            rival = step;
            step = ahead;
            nearest = slope < 0 ? function : NOTHING;
            near = slope < 0 ? -2 * value / slope : step;
            alone = slope < 0 && 4 * near * bound < -slope;
            course[0] = value;
            course[1] = slope;
            course[2] = bound;
            course[3] = noise;
        } else if (ahead < rival) {
            rival = ahead;
        }
    }
    if (alone && near <= rival) {
        polish(r, nearest);
        return nearest;
    }
    adapt_reach(m, step);
    before = m->t;
    move(r, step);
    if (m->t > before) {
        m->stall = 1.0;
        return NOTHING;
    }
    if (nearest == NOTHING) {
        creep(r, before);
    } else {
        certify_crossing(r, course[1], course[2], course[3]);
        certify_order(r, nearest, m->functions, m->function_count, d, m->residues, course[0], course[1], course[3]);
    }
    return nearest;
}

double closed_form_advance(Run *r, double limit, int *function)
{
    ClosedFormSearch *m = &r->closed.search;
    int i;
    *function = NOTHING;
    if (m->leading) {
        *function = lead(r);
        if (*function != NOTHING)
            return m->t;
    }
    if (m->function_count == 0)
        m->t = limit;
    for (i = 0; i < STEPS_PER_CALL; i++) {
        *function = m->t < limit ? step_once(r) : NOTHING;
        if (m->t >= limit && (*function == NOTHING || m->t > limit)) {
            *function = NOTHING;
            m->t = limit;
            turn_before(r, NOTHING);
            return limit;
        }
        if (*function != NOTHING) {
            turn_before(r, *function);
            return m->t;
        }
    }
    return m->t;
}
