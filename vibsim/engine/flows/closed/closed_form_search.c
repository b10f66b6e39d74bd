/* Certified first event on the closed-form flow: safe steps from bounds of the event functions' curvature. */
#include "certificate.h"
#include "event_functions.h"
#include "first_root.h"
#include "inlining.h"
#include "turning_point.h"

#define STEPS_PER_CALL 4096
#define POLISHING 10 /* Halley's iteration triples the right digits */
#define NEAR 128 /* roundings: nearer to zero than that they are measured closely */
#define NARROWER 16 /* steps shorter than this part of the reach of the bounds shorten it to that; others widen it */

/* Begin the search at the flow's anchor, with the zeros in r->known. */
void closed_form_open(Run *r)
{
    Search *s = &r->closed_form.search;
    const Mode *m = r->mode;
    int i, k;
    s->leading = 1;
    s->t = r->t0;
    s->reach = s->window = m->modal->window;
    s->stall = 1.0;
    s->event_count = m->event_count;
    for (i = 0; i < m->event_count; i++) {
        s->events[i] = i;
        s->watched[i][0] = r->t0;
        for (k = 1; k < 5; k++)
            s->watched[i][k] = 0.0;
    }
}

/* Go ahead by `step` on the grid of time. */
static void move(Run *r, Real step)
{
    Search *s = &r->closed_form.search;
    s->t = r->t0 + ((s->t - r->t0) + step);
}

/* Let the bounds of the next step reach as far as it needs: they are the tighter the less they do. */
static void adapt_reach(Search *s, Real step)
{
    Real needed = NARROWER * step;
    s->reach = needed < s->window ? needed : s->window;
}

/* Rounding bound of an event function by the close measure, which is taken once at a point. */
APART Real close_noise(Run *r, const Event *e)
{
    Search *s = &r->closed_form.search;
    if (!s->measured)
        measure_closely(r);
    s->measured = 1;
    return rounding_unit(r) * event_scale(r, e, CLOSE);
}

/* Rounding bound of the value of an event function, by the plain measure where it is far from zero. There a step that keeps the
 * value above the plain bound can bring it below the close one at its very end only, and only where it still falls there: so the
 * next step sees it.
 */
static inline Real noise_of(Run *r, const Event *e, Real value, Real reach, Real unit)
{
    Real noise = unit * event_scale(r, e, PLAIN);
    return value <= NEAR * (noise + unit * reach) ? close_noise(r, e) : noise;
}

/* Doubt that the function of number `event`, taken for zero at `value`, falls below zero: it may be higher by `noise`. */
static void certify_crossing(Run *r, int event, Real value, Real slope, Real bound, Real noise)
{
    if (!crosses(slope, bound, value > 0 ? noise + value : noise))
        doubt(&r->certificate, r->t0, r->closed_form.search.t, TOUCH_OR_MISS, event, NOTHING);
}

/* Doubt that the zero of `first` is the first, where that of another of `events` may come as soon; value, slope and noise are
 * those of `first`. A touch is in doubt by itself.
 */
static void certify_order(Run *r, int first, const int *events, int count, Real value, Real slope, Real noise)
{
    const Search *s = &r->closed_form.search;
    const Mode *m = r->mode;
    Real latest;
    int i;
    if (slope >= 0)
        return;
    latest = latest_zero(value, slope, noise, s->t);
    for (i = 0; i < count; i++) {
        const Event *e = &m->events[events[i]];
        Real other = event_derivative(r, e, 0), fall = event_derivative(r, e, 1);
        Real blur = close_noise(r, e) + s->rounding_bounds[events[i]].residue;
        int alike = other == value && fall == slope;
        if (events[i] != first && may_vanish_by(other, fall, blur, latest) && (!alike || order_is_open(r, &m->events[first], e)))
            doubt(&r->certificate, r->t0, s->t, WHICH_IS_FIRST, first, events[i]);
    }
}

/* As `certify_order`, at the start of a segment: against the functions whose zeros are not known to be there. */
static void certify_leading_order(Run *r, int first, Real value, Real slope, Real noise)
{
    Search *s = &r->closed_form.search;
    const Mode *m = r->mode;
    int i;
    s->event_count = 0;
    for (i = 0; i < m->event_count; i++)
        if (r->known[m->events[i].key] == 0) {
            s->rounding_bounds[i].residue = 0.0;
            s->events[s->event_count++] = i;
        }
    certify_order(r, first, s->events, s->event_count, value, slope, noise);
}

/* Order of the zero that an event function begins with, as far as derivatives are taken. */
static int known_order(const Run *r, int i)
{
    int known = r->known[r->mode->events[i].key];
    return known < FLAT_ORDER ? known : FLAT_ORDER;
}

/* The first stretch of a segment, known zeros divided out, from the derivatives at its start; returns the event that comes at
 * once, or NOTHING. A function with too many zero derivatives rests at zero and is watched no more. One that rises from within
 * rounding of zero is in doubt: on which side it began is not proved.
 */
static int lead(Run *r)
{
    Search *s = &r->closed_form.search;
    const Mode *m = r->mode;
    Real step = s->window, X = 0.0, V = 0.0;
    int taken = 2, i;
    s->leading = 0;
    s->measured = 0;
    measure_start(r);
    for (i = 0; i < m->event_count; i++)
        taken = known_order(r, i) + 2 > taken ? known_order(r, i) + 2 : taken;
    closed_form_jets(r, taken);
    for (i = 0; i < r->bodies; i++) {
        X = X + fabs(r->closed_form.x0[i]);
        V = V + fabs(r->closed_form.v0[i]);
    }
    if (r->base_count > 0) {
        X = X + fabs(r->closed_form.x0[r->bodies + 1]);
        V = V + fabs(r->closed_form.v0[r->bodies + 1]);
    }
    s->event_count = 0;
    for (i = 0; i < m->event_count; i++) {
        const Event *e = &m->events[i];
        const Reach *reach = &m->modal->reaches[i];
        int known = known_order(r, i), order = known;
        Real first = event_derivative(r, e, order), bound, ahead;
        while (order < JET_ORDER - 2 && first == 0) {
            if (++order + 2 > taken)
                closed_form_jets(r, taken = JET_ORDER);
            first = event_derivative(r, e, order);
        }
        s->rounding_bounds[i].residue = known > 0 ? fabs(event_derivative(r, e, 0)) : 0.0;
        s->rounding_bounds[i].reach = reach->place * X + reach->speed * V + reach->rest;
        if (order >= FLAT_ORDER) { /* it rests at zero, surely where that are more zeros than the motion has modes */
            if (closed_form_dimension(r) > FLAT_ORDER)
                doubt(&r->certificate, r->t0, r->t0, RESTS_AT_ZERO, i, NOTHING);
            continue;
        }
        s->events[s->event_count++] = i;
        if (e->kind == STRIKE && order > known && first < 0) /* closes from exactly zero */
            return i;
        bound = event_bound(r, e, order + 2, s->window);
        if (known == 0 && order > 0 && first < 0) { /* zero, by no event, and on its way below */
            doubt(&r->certificate, r->t0, r->t0, WHICH_SIDE, i, NOTHING);
            return i;
        }
        if (order == 0) {
            Real noise = noise_of(r, e, first, s->rounding_bounds[i].reach, rounding_unit(r)), slope = event_derivative(r, e, 1);
            if (first <= noise && slope <= 0) {
                certify_crossing(r, i, first, slope, bound, noise);
                certify_leading_order(r, i, first, slope, noise);
                return i;
            }
            first = first - noise;
            if (first <= 0)
                doubt(&r->certificate, r->t0, r->t0, WHICH_SIDE, i, NOTHING);
        }
        first = first > 0 ? first : 0.0;
        ahead = deflated_step(order, first, event_derivative(r, e, order + 1), bound);
        step = ahead < step ? ahead : step;
        if (e->turns) {
            int parted = order >= 2 ? order : 0, n; /* as rest ends: what rounding left of zeros is no turn */
            s->watched[i][0] = r->t0;
            for (n = 0; n < 3; n++)
                s->watched[i][1 + n] = n < parted ? 0.0 : event_derivative(r, e, n);
            s->watched[i][4] = event_bound(r, e, 2, s->window);
        }
    }
    adapt_reach(s, step);
    move(r, step);
    return NOTHING;
}

typedef struct {
    Run *r;
    const Event *event;
} Turning;

/* Slope and curvature of a gap function at time t. */
static void gap_slope(void *function, Real t, Real *slope, Real *curvature)
{
    const Turning *of = (const Turning *)function;
    closed_form_evaluate(of->r, t - of->r->t0);
    closed_form_jets(of->r, 2);
    *slope = event_derivative(of->r, of->event, 1);
    *curvature = event_derivative(of->r, of->event, 2);
}

/* Keep the minimum of a gap function between two times at which its slopes fall and rise. */
static void turn_between(Run *r, const Event *e, Real low, Real high)
{
    const Search *s = &r->closed_form.search;
    Turning of;
    Real t, turn, depth;
    of.r = r;
    of.event = e;
    turning_point(gap_slope, &of, low, high, s->settled * s->window, &t, &turn, &depth);
    closed_form_evaluate(r, t - r->t0);
    closed_form_jets(r, 2);
    keep_turn(&r->certificate, event_derivative(r, e, 0) - depth, turn);
}

/* Look for a minimum of a gap function since the point watched before; then watch from here on. bound: on its second derivative
 * ahead. A minimum that cannot undercut the grazing margin is not looked for. Between slopes of one sign there may be a maximum
 * beside the minimum: then the slope itself has an extreme between, which the curvatures tell.
 */
static void watch_turn(Run *r, int event, Real value, Real slope, Real curvature, Real bound)
{
    Search *s = &r->closed_form.search;
    const Event *e = &r->mode->events[event];
    Real *w = s->watched[event], low = w[0], was = w[1], before = w[2], bend = w[3], limit = w[4];
    Real length = s->t - low, least = was + before * length - limit * (length * length) / 2;
    w[0] = s->t;
    w[1] = value;
    w[2] = slope;
    w[3] = curvature;
    w[4] = bound;
    if ((least < was ? least : was) >= r->certificate.margin)
        return;
    if (before < 0 && 0 <= slope) {
        turn_between(r, e, low, s->t);
    } else if ((before < 0) == (slope < 0) && ((bend < 0 && 0 < curvature) || (before < 0 && curvature < 0 && 0 < bend))) {
        Real middle = low + extreme_of_slope(length, before, bend, slope, curvature), between, unused;
        Turning of;
        of.r = r;
        of.event = e;
        gap_slope(&of, middle, &between, &unused);
        if (before >= 0 && 0 > between)
            turn_between(r, e, middle, s->t);
        else if (before < 0 && 0 <= between)
            turn_between(r, e, low, middle);
    } else {
        return; /* nothing was evaluated anywhere else */
    }
    closed_form_evaluate(r, s->t - r->t0);
    closed_form_jets(r, 2);
}

/* Look for minima of the gap functions between the points watched last and an event of another kind, or the end of the run. */
static void turn_before(Run *r, int event)
{
    const Mode *m = r->mode;
    int i;
    for (i = 0; i < m->event_count; i++)
        if (m->events[i].turns && i != event) {
            const Event *e = &m->events[i];
            closed_form_evaluate(r, r->closed_form.search.t - r->t0);
            closed_form_jets(r, 2);
            watch_turn(r, i, event_derivative(r, e, 0), event_derivative(r, e, 1), event_derivative(r, e, 2), 0.0);
        }
}

/* Go to the one zero of the event function ahead, by Halley's iteration. Called where 8 f |f''| < f'^2 and f' < 0: then f falls
 * all the way to its zero, which lies within -2 f / f' and is the only one there (Kantorovich), and no other event function can
 * vanish within that.
 */
static void polish(Run *r, const Event *e)
{
    Search *s = &r->closed_form.search;
    Real start = s->t;
    int i;
    for (i = 0; i < POLISHING; i++) {
        Real value, slope, curvature, newton, step, near, before = s->t;
        closed_form_jets(r, 2);
        value = event_derivative(r, e, 0);
        slope = event_derivative(r, e, 1);
        curvature = event_derivative(r, e, 2);
        newton = value / slope;
        step = -(2 * newton) / (2 - newton * (curvature / slope));
        move(r, step);
        s->t = s->t > start ? s->t : start;
        near = fabs(curvature) * s->window < fabs(slope) ? s->window : fabs(slope / curvature);
        if (s->t == before || fabs(step) < s->settled * near)
            return;
        r->steps += 1;
        closed_form_evaluate(r, s->t - r->t0);
    }
}

/* Go on to the zero of a tie's function, which falls within its rounding of zero, where another tie has the same one: as of bodies that
 * are alike. Both let go at that instant, and what is left of the functions there is to be rounding of the time alone.
 */
static void reach_zero_of_twins(Run *r, int which, Real value, Real slope)
{
    const Search *s = &r->closed_form.search;
    int i;
    for (i = 0; i < s->event_count; i++) {
        const Event *e = &r->mode->events[s->events[i]];
        if (s->events[i] != which && e->kind == HOLD && event_derivative(r, e, 0) == value && event_derivative(r, e, 1) == slope) {
            move(r, value / -slope);
            return;
        }
    }
}

/* Length of a step while a function, `held`, rises within its rounding of zero: one that leaves zero as slowly as t^4 does so for long, and
 * certified steps grow too little. So each is at least twice the one before, as far as the others allow, `free_step`.
 */
static Real leap(Run *r, int held, Real step, Real free_step)
{
    Search *s = &r->closed_form.search;
    Real least = (nextafter(s->t, INFINITY) - s->t) * s->stall;
    s->stall = s->stall * 2;
    least = least < free_step ? least : free_step;
    if (step >= least)
        return step;
    doubt(&r->certificate, r->t0, s->t, TOO_SHORT_STEPS, held, NOTHING);
    return least;
}

/* One certified step; returns the event whose function reached zero here, or NOTHING. The event function that may come to zero
 * first sets the step; `rival` is the step that the next one allows. Where the step is too short to move the time, a function that
 * falls is at its zero; else the point is left, in doubt, by steps that double.
 */
static int step_ahead(Run *r)
{
    Search *s = &r->closed_form.search;
    Real step = s->reach, rival = step, free_step = step, near = 0, before, unit, course[3] = {0, 0, 0};
    int nearest = NOTHING, alone = 0, held = NOTHING, i;
    r->steps += 1;
    closed_form_evaluate(r, s->t - r->t0);
    s->measured = 0;
    measure_plainly(r);
    unit = rounding_unit(r);
    closed_form_jets(r, 2);
    for (i = 0; i < s->event_count; i++) {
        int which = s->events[i];
        const Event *e = &r->mode->events[which];
        const RoundingBound *blur = &s->rounding_bounds[which];
        Real value = event_derivative(r, e, 0), slope = event_derivative(r, e, 1), ahead, room;
        Real noise = noise_of(r, e, value, blur->reach, unit) + blur->residue, bound = event_bound(r, e, 2, s->reach);
        if (value < -noise || (value <= noise && slope <= 0)) {
            if (s->t == r->t0 && r->known[e->key] > 0) /* the zero of before */
                continue;
            certify_crossing(r, which, value, slope, bound, noise);
            certify_order(r, which, s->events, s->event_count, value, slope, noise);
            if (e->kind == HOLD && value > 0 && slope < 0)
                reach_zero_of_twins(r, which, value, slope);
            return which;
        }
        if (e->turns)
            watch_turn(r, which, value, slope, event_derivative(r, e, 2), bound);
        room = value - noise;
        ahead = safe_step(room > 0 ? room : 0.0, slope, bound);
        if (room <= 0)
            held = which;
        else if (ahead < free_step)
            free_step = ahead;
        if (ahead < step) {
            rival = step;
            step = ahead;
            nearest = slope < 0 ? which : NOTHING;
            near = slope < 0 ? -2 * value / slope : step;
            alone = slope < 0 && 4 * near * bound < -slope;
            course[0] = value;
            course[1] = slope;
            course[2] = bound;
        } else if (ahead < rival) {
            rival = ahead;
        }
    }
    if (alone && near <= rival) {
        polish(r, &r->mode->events[nearest]);
        return nearest;
    }
    if (held != NOTHING)
        step = leap(r, held, step, free_step);
    adapt_reach(s, step);
    before = s->t;
    move(r, step);
    if (s->t > before) {
        s->stall = held != NOTHING ? s->stall : 1.0;
        return NOTHING;
    }
    if (nearest == NOTHING) {
        doubt(&r->certificate, r->t0, before, TOO_SHORT_STEPS, held, NOTHING);
        s->t = before + (nextafter(before, INFINITY) - before) * s->stall;
        s->stall = s->stall * 2;
        if (s->reach == 0) /* a step near t = 0 was too short to be a number: bounds have to reach further */
            s->reach = s->window;
    } else {
        Real noise = close_noise(r, &r->mode->events[nearest]) + s->rounding_bounds[nearest].residue;
        certify_crossing(r, nearest, course[0], course[1], course[2], noise);
        certify_order(r, nearest, s->events, s->event_count, course[0], course[1], noise);
    }
    return nearest;
}

/* March to the first event or to `limit`; returns the time, and in `event` its number or NOTHING. */
Real closed_form_advance(Run *r, Real limit, int *event)
{
    Search *s = &r->closed_form.search;
    int i;
    *event = NOTHING;
    if (s->leading) {
        *event = lead(r);
        if (*event != NOTHING)
            return s->t;
    }
    if (s->event_count == 0)
        s->t = limit;
    for (i = 0; i < STEPS_PER_CALL; i++) {
        *event = s->t < limit ? step_ahead(r) : NOTHING;
        if (s->t >= limit && (*event == NOTHING || s->t > limit)) { /* at the end, or polished past it */
            *event = NOTHING;
            s->t = limit;
            turn_before(r, NOTHING);
            return limit;
        }
        if (*event != NOTHING) {
            turn_before(r, *event);
            return s->t;
        }
    }
    return s->t;
}
