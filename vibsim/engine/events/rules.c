/* What follows an event where its rule is simple and the decision clear; elsewhere Python decides, see events/automaton.py:
 *   CROSS  the function falls through its zero: on to the mode `target`; nothing happens there that is told where a force of a
 *          formula has but another slope behind it
 *   RIGID_IMPACT  one rigid stop is struck, and nothing else touches: on in the mode that slips as the velocities say, see
 *          impacts.c
 *   STICK_OR_REVERSE  a sliding velocity is zero: on to `target`, where it sticks, if every tie of that mode holds, or to
 *          `other`, where it slides the other way, if the tie `hold` gives way; if another tie is overloaded most, on to the mode in
 *          which that one has let go, by the rule of its event
 *   CROSS_IF_TIES_HOLD  as CROSS, where forces jump: if every tie of the mode `target` holds, and what a tie that gave way
 *          has let go slips
 */
#include <string.h>

#include "columns.h"
#include "event_functions.h"
#include "numbers.h"

#define TOUCHING 64 /* roundings: beyond those within which Python says that ends just touch */
#define GRAZING 0x1p-20 /* of what a rate changes by within a step: Python looks closely at less */
#define NEAR_ORDER 6 /* of a motion whose second derivatives are asked for */
#define CLEARLY 4 /* times the bounds of the rounding of switches */
#define BEYOND 4 /* times the bounds of rounding: a derivative that is so far from zero has a sign */
#define GRID 8 /* roundings of the time of an event, by which its zeros may be beside it */
#define NEAR_LIMIT 0x1p-40 /* of all forces of a mode: nearer to its limit than that Python measures the force of a tie closely */

/* Rate of a function made of differences, from the velocities: no rounding of a flow in it. */
static Real direct_rate(const Run *r, const Event *e)
{
    const Term *t = r->mode->terms + e->first;
    Real total = 0.0, X = 0.0, V = 0.0;
    int i;
    if (r->has_base)
        base_motion_at(r, r->mode, r->next.t, &X, &V);
    for (i = 0; i < e->terms; i++) {
        Real P = column_value(r, r->next.v, t[i].P, V), Q = column_value(r, r->next.v, t[i].Q, V);
        Real part = t[i].coefficient * (P - Q);
        total = i == 0 ? part : total + part;
    }
    return total;
}

/* Take the motion from a state on to no higher an order than what is near needs; returns the order that it has otherwise. In many digits
 * all orders may take seconds, in which no signal is heard.
 */
static int look_near(Run *r, const State *state)
{
    const int order = r->taylor.order;
#ifdef WORDS_BY_RUN
    r->taylor.order = NEAR_ORDER;
#endif
    taylor_look(r, state);
    return order;
}

/* An event function of mode m from r->next on, as a Taylor series as the automaton's; near: its first coefficients are enough. */
static void flow_series(Run *r, const Mode *m, const Event *e, Real *series, int near)
{
    const Mode *before = r->mode;
    int order = r->taylor.order;
    r->mode = m;
    if (near)
        order = look_near(r, &r->next);
    else
        taylor_look(r, &r->next);
    taylor_polynomial(r, e, series);
    r->mode = before;
    r->taylor.order = order;
}

/* Value, or first derivative, of an event function of mode m at r->next. */
static Real flow_derivative(Run *r, const Mode *m, const Event *e, int order)
{
    Series series;
    flow_series(r, m, e, series, 1);
    return series[order];
}

/* Derivative of an event function at r->next over its factorial: of order 1, or 2 where the rate is zero. 0 where its sign is not clear, or
 * where a signal has ended the look: the event waits then. Clear is a rate that is more than next to nothing of what it changes by within
 * a step, and a second derivative beyond its rounding.
 */
static Real clear_derivative(Run *r, const Event *e, int order)
{
    const double evaluations = r->evaluations;
    Series series, bounds;
    r->hears = 1;
    flow_series(r, r->mode, e, series, 0);
    r->hears = 0;
    if (r->interrupted) {
        r->interrupted = ELSEWHERE;
        r->evaluations = evaluations;
        return 0.0;
    }
    if (order == 1)
        return fabs(series[1]) <= GRAZING * r->taylor.h * fabs(series[2]) ? 0.0 : series[1];
    if (series[1] != 0 || !taylor_bounds(r, e, 2, r->t0 == 0, 1, r->taylor.h < r->t0 ? r->taylor.h : r->t0, bounds))
        return 0.0;
    return 2 * fabs(series[2]) > BEYOND * bounds[2] ? series[2] : 0.0;
}

static const Event *event_of_key(const Mode *m, int key)
{
    const Event *e = m->events, *end = e + m->event_count;
    while (e < end && e->key != key)
        e++;
    return e < end ? e : NULL;
}

/* Derivative of order 1 or 2 of the event function `key` of mode m, at r->next; NAN where m has none. */
Real derivative_at_next(Run *r, const Mode *m, int key, int order)
{
    const Mode *before = r->mode;
    const Event *e = event_of_key(m, key);
    const double evaluations = r->evaluations;
    Series series;
    Real value;
    if (e == NULL)
        return NAN;
    if (m->modal) {
        r->mode = m;
        closed_form_enter(r, &r->next);
        closed_form_jets(r, 2);
        value = event_derivative(r, e, order);
        r->mode = before;
    } else {
        flow_series(r, m, e, series, 1);
        value = order * series[order];
    }
    r->evaluations = evaluations;
    return value;
}

/* The zero of an event function at the instant that was looked at: of order `known`, or of a lower one, from `first` on, where a
 * derivative before that is clear of rounding; 0 where it falls at once.
 */
static int order_of_zero(const Run *r, const Event *e, int first, int known, Real span)
{
    const Real late = GRID * EPS * r->t0;
    Series series, bounds;
    Real factorial = 1.0;
    int n;
    if (taylor_polynomial(r, e, series) < known + 2 || !taylor_bounds(r, e, known, r->t0 == 0, 1, span, bounds))
        return known;
    for (n = 0; n <= known; n++) {
        Real value = series[n];
        factorial = n > 0 ? factorial * n : factorial;
        if (n >= first && factorial * fabs(value) > BEYOND * bounds[n] + late * (factorial * (n + 1) * fabs(series[n + 1])))
            return value > 0 ? n : 0;
    }
    return known;
}

/* Whether an event function of the mode of now has the value at r->state that it had in the mode before, `left` by an event that moves
 * no velocity. Then it has not jumped from its zero: it is beside it by the time between two doubles, and may rest there.
 */
static int as_before(Run *r, const Mode *left, const Event *e)
{
    const Event *event = left != NULL && r->pending_event != NOTHING ? &left->events[r->pending_event] : NULL;
    const Event *other = event != NULL && event->kind != STRIKE ? event_of_key(left, e->key) : NULL;
    Series now, then, bounds;
    if (other == NULL)
        return 0;
    flow_series(r, left, other, then, 1);
    flow_series(r, r->mode, e, now, 1);
    look_near(r, &r->state);
    return taylor_bounds(r, e, 0, r->t0 == 0, 1, 0.0, bounds) && fabs(now[0] - then[0]) <= BEYOND * bounds[0];
}

/* Look at the zeros that the mode of now begins with at r->state once more, but for those of the last event. What happens last may turn
 * what an event function does behind a zero that an event before it left, at the same instant: as an impact turns a depth that contact
 * has just begun with.
 * left: the mode before, NULL where none is known.
 */
void review_zeros(Run *r, const Mode *left)
{
    const Mode *m = r->mode;
    const int most = r->taylor.order;
    const double evaluations = r->evaluations;
    Real span;
    int looked = 0, i;
    for (i = 0; i < m->event_count; i++) {
        const Event *e = &m->events[i];
        int order = r->known[e->key];
        if (order <= 0 || r->behind[e->key] >= 0)
            continue;
        if (!looked) {
            look_near(r, &r->state);
            looked = 1;
        }
        span = r->taylor.h < r->t0 ? r->taylor.h : r->t0;
        if (order + 3 >= r->taylor.order)
            continue;
        r->known[e->key] = order_of_zero(r, e, 0, order, span);
        if (r->known[e->key] == 0 && as_before(r, left, e))
            r->known[e->key] = order_of_zero(r, e, 1, order, span);
    }
    r->taylor.order = most;
    r->evaluations = evaluations;
}

/* Value of a HOLD function of mode m at r->next from its couplings; X, V: of the base. Returns 0 where it has other terms. */
static int direct_hold(const Run *r, const Mode *m, const Event *e, Real X, Real V, Real *value)
{
    Real total = 0.0;
    int i;
    for (i = 0; i < e->terms; i++) {
        const Term *t = &m->terms[e->first + i];
        Real part;
        if (t->kind != COUPLING)
            return 0;
        part = t->coefficient * force_of_coupling(r, &m->couplings[t->P], r->next.x, r->next.v, X, V);
        total = i == 0 ? part : total + part;
    }
    *value = total + e->constant;
    return 1;
}

/* Sum of the magnitudes of all forces of mode m at a state, of couplings by what each of their ends has, of a motor also of its torque at
 * the radius of its unbalance: what the rounding of any force is below some hundred EPS of. X, V: of the base.
 */
Real forces_of(const Run *r, const Mode *m, const State *state, Real X, Real V)
{
    Real total = 0.0, inertia = 0.0;
    int i, j;
    for (i = 0; i < m->coupling_count; i++) {
        const Coupling *c = &m->couplings[i];
        Real places = fabs(column_value(r, state->x, c->P, X)) + fabs(column_value(r, state->x, c->Q, X));
        Real speeds = fabs(column_value(r, state->v, c->P, V)) + fabs(column_value(r, state->v, c->Q, V));
        total += c->k * places + fabs(c->offset) + c->c * speeds;
    }
    for (i = 0; i < r->force_count; i++) {
        total += fabs(r->forces[i].constant);
        for (j = 0; j < r->forces[i].count; j++)
            total += fabs(r->forces[i].terms[j].amplitude);
    }
    for (i = 0; i < m->constant_count; i++)
        total += fabs(m->constants[i]);
    if (m->formula_count > 0)
        tape_values_at(r, m, state, X, V, NULL);
    for (i = 0; i < m->formula_count; i++)
        total += fabs(r->taylor.tapes.values[m->tape.outputs[m->formulas[i].output]]);
    for (i = 0; i < r->bodies; i++)
        inertia += r->masses[i];
    for (i = 0; i < r->base_count; i++)
        total += inertia * fabs(r->base[i].amplitude * r->base[i].omega * r->base[i].omega);
    if (m->base_values.op_count > 0)
        total += inertia * fabs(base_acceleration_at(r, m, state->t));
    if (r->has_motor)
        total += r->unbalance * (state->w * state->w) + (fabs(r->M0) + r->drag * fabs(state->w)) / r->e;
    return total;
}

/* 1: every tie of mode m holds; -1: the tie `hold` gives way, and no other one is overloaded as much; 0: neither, or not clear.
 * other: the event of a tie that clearly is overloaded most and is not `hold`, else NOTHING.
 */
static int stands(Run *r, const Mode *m, int hold, int *other)
{
    Real X = 0.0, V = 0.0, forces, margin, lacking = 0.0, lacking_elsewhere = 0.0, next = 0.0;
    int worst = NOTHING, i;
    *other = NOTHING;
    if (r->has_base && r->next.t == 0) /* of a start Python knows more, as that the base turns round */
        return 0;
    if (r->has_base)
        base_motion_at(r, r->mode, r->next.t, &X, &V);
    forces = forces_of(r, m, &r->next, X, V);
    for (i = 0; i < m->event_count; i++) {
        Real value;
        if (m->events[i].kind != HOLD)
            continue;
        if (!direct_hold(r, m, &m->events[i], X, V, &value))
            value = flow_derivative(r, m, &m->events[i], 0);
        if (!(fabs(value) > 2 * NEAR_LIMIT * (forces + m->events[i].size))) /* Python looks closely at half of that */
            return 0;
        if (i == hold) {
            lacking = value < 0 ? value : 0.0;
        } else if (value < lacking_elsewhere) {
            next = lacking_elsewhere;
            lacking_elsewhere = value;
            worst = i;
        } else if (value < next) {
            next = value;
        }
    }
    margin = 2 * NEAR_LIMIT * forces;
    if (lacking_elsewhere < 0 && lacking_elsewhere < (next < lacking ? next : lacking) - margin)
        *other = worst;
    if (lacking < 0)
        return lacking < lacking_elsewhere - margin ? -1 : 0;
    return lacking_elsewhere < 0 ? 0 : 1;
}

/* Whether every tie of mode m holds. */
static int holds(Run *r, const Mode *m)
{
    int other;
    return stands(r, m, NOTHING, &other) > 0;
}

/* Whether what slips or parts in mode m by the event function `key` goes on doing so, while every tie of it holds. */
static int departs(Run *r, const Mode *m, int key)
{
    const Event *e = event_of_key(m, key);
    Real X = 0.0, V = 0.0, lightest = INFINITY, acceleration;
    int c;
    if (e == NULL || !holds(r, m))
        return 0;
    base_motion_at(r, r->mode, r->next.t, &X, &V);
    for (c = 0; c < r->bodies; c++)
        lightest = r->masses[c] < lightest ? r->masses[c] : lightest;
    acceleration = e->kind == STRIKE ? 2 * flow_derivative(r, m, e, 2) : flow_derivative(r, m, e, 1);
    return acceleration > NEAR_LIMIT * forces_of(r, m, &r->next, X, V) / lightest;
}

/* The same of what alone was let go: where nothing is tied in m then Python does not look either. */
static int slips(Run *r, const Mode *m, int key)
{
    return m->untied || departs(r, m, key);
}

/* Whether rounding leaves every switch of mode m, but that of the event function `key`, on its side at r->next, where the mode of now
 * has led.
 */
static int sides_last(Run *r, const Mode *m, int key)
{
    const Taylor *f = &r->taylor;
    const TapeRoom *room = &f->tapes;
    Real X = 0.0, V = 0.0;
    int i;
    if (m->switch_count == 0)
        return 1;
    r->taylor.order = look_near(r, &r->next);
    if (r->has_base) {
        X = f->table[base_column(r)];
        V = f->table[f->rates + base_column(r)];
    }
    tape_values_at(r, m, &r->next, X, V, f->table + f->stride + f->rates);
    for (i = 0; i < m->event_count; i++) {
        const Event *e = &m->events[i];
        const Term *term = &m->terms[e->first];
        if (e->kind == SWITCH && e->key != key && term->kind == FORMULA) {
            int place = m->tape.outputs[term->P];
            Real value = term->coefficient * room->values[place], bound = room->bounds[place];
            if (!(value > CLEARLY * bound || (value == 0 && bound == 0))) /* of a constant 0 the side is that of before */
                return 0;
        }
    }
    return 1;
}

/* Speeds that rotors gain with those of their bodies; old: velocities before. */
static void turn_rotors(Run *r, const Mode *m, int leader, const Real *old)
{
    Real *v = r->next.v;
    int i;
    for (i = 0; i < r->rotors.count; i++) {
        const RotorOn *one = &r->rotors.of[i];
        if (m->leader[one->on] == leader) {
            Real coupling = one->unbalance * sine_of(r->next.x[one->column]);
            v[one->column] = v[one->column] + coupling * (v[one->on] - old[one->on]) / one->inertia;
        }
    }
}

/* Give the bodies of the group that `column` is in their common velocity; momentum is kept where they move freely. */
static void join(Run *r, const Mode *m, int column)
{
    int leader = m->leader[column], c;
    Real common = 0.0, momentum = 0.0, X;
    if (leader > r->bodies) {
        base_motion_at(r, r->mode, r->next.t, &X, &common);
    } else if (leader < r->bodies) {
        int first = 1;
        for (c = 0; c < r->bodies; c++)
            if (m->leader[c] == leader) {
                Real share = r->masses[c] * (r->next.v[c] - m->drift[c]);
                momentum = first ? share : momentum + share;
                first = 0;
            }
        common = momentum / m->group_mass[leader];
    }
    for (c = 0; c < r->bodies; c++)
        if (m->leader[c] == leader)
            r->next.v[c] = common + m->drift[c];
    turn_rotors(r, m, leader, r->before_v);
}

/* Whether the ends of a stop or a clearance that is watched just touch, more or less: a release may part or close them. */
static int touches(const Run *r)
{
    const Mode *m = r->mode;
    Real X, V;
    int i, j;
    base_motion_at(r, r->mode, r->next.t, &X, &V);
    for (i = 0; i < m->event_count; i++) {
        const Event *e = &m->events[i];
        Real value = e->constant, size = e->size;
        if (e->kind != GAP && e->kind != CLEARANCE)
            continue;
        for (j = 0; j < e->terms; j++) {
            const Term *t = &m->terms[e->first + j];
            Real P = column_value(r, r->next.x, t->P, X), Q = column_value(r, r->next.x, t->Q, X);
            value = value + t->coefficient * (P - Q);
            size = size + fabs(P) + fabs(Q);
        }
        if (fabs(value) <= TOUCHING * EPS * size)
            return 1;
    }
    return 0;
}

/* Stick in mode `target` at the pending event e, at which another tie lets go by the event `released`, or none does (NULL). 0 where a switch
 * may turn.
 */
static int stick(Run *r, Buffers *b, const Event *e, int target, const Event *released)
{
    int kinds[2] = {STICK_BEGIN, NOTHING}, parts[2] = {e->rule.part, NOTHING}, count = 1;
    join(r, r->modes[target], r->mode->terms[e->first].P);
    if (!sides_last(r, r->modes[target], NOTHING)) {
        memcpy(r->next.v, r->before_v, sizeof(Real) * (size_t)r->bodies);
        return 0;
    }
    if (released != NULL) { /* events of frictions are recorded first, by their numbers */
        const int before = released->rule.event == STICK_END && released->rule.part < e->rule.part;
        kinds[before] = STICK_BEGIN;
        parts[before] = e->rule.part;
        kinds[!before] = released->rule.event;
        parts[!before] = released->rule.part;
        r->behind[released->rule.key] = released->rule.event == REST_END ? 2 : 1;
        count = 2;
    }
    run_take(r, b, target, count, kinds, parts);
    return 1;
}

/* Take the pending event by its rule; 0 where Python has to decide. */
int rule_take(Run *r, Buffers *b)
{
    const Event *e = &r->mode->events[r->pending_event];
    const Rule *rule = &e->rule;
    int kind = rule->event, part = rule->part, k;
    for (k = 0; k < r->key_count; k++)
        r->behind[k] = -1;
    if (rule->kind == CROSS || rule->kind == CROSS_IF_TIES_HOLD) {
        const int of_places = e->kind != HOLD && e->kind != PUSH && e->kind != SWITCH;
        const int own = e->kind == SWITCH ? e->key : NOTHING;
        Real rate = of_places ? direct_rate(r, e) : clear_derivative(r, e, 1);
        int order = 1;
        if (r->known[e->key] > 0 && r->pending_tau == 0)
            return 0;
        if (of_places && rate == 0) { /* as of a body that a force growing from zero has just set into motion */
            order = 2;
            rate = clear_derivative(r, e, order);
        }
        if (rate == 0 || rate != rate || (e->kind == HOLD && touches(r)))
            return 0;
        if (!sides_last(r, rate > 0 ? r->mode : r->modes[rule->target], own))
            return 0;
        if (rate > 0) {
            r->behind[e->key] = order;
            run_take(r, b, r->mode_number, 0, NULL, NULL);
            return 1;
        }
        if (rule->kind == CROSS_IF_TIES_HOLD &&
            (e->kind == HOLD ? !slips(r, r->modes[rule->target], rule->key) : !holds(r, r->modes[rule->target])))
            return 0;
        r->behind[rule->key] = order == 1 ? rule->order : order;
        run_take(r, b, rule->target, kind == NOTHING ? 0 : 1, &kind, &part);
        return 1;
    }
    if (rule->kind == RIGID_IMPACT) {
        Impact done;
        if (!impact_take(r, e, &done))
            return 0;
        r->behind[e->key] = 1;
        run_take(r, b, done.target, done.happened, r->impacts.kinds, r->impacts.parts);
        if (r->status == OK)
            impact_count(r, &done);
        return 1;
    }
    if (rule->kind == STICK_OR_REVERSE) {
        const Mode *stuck = r->modes[rule->target];
        int other, answer = stands(r, stuck, rule->hold, &other);
        const Event *released = other == NOTHING ? NULL : &stuck->events[other];
        if (answer > 0)
            return stick(r, b, e, rule->target, NULL);
        if (released != NULL && released->rule.kind != DECIDE_IN_PYTHON && r->tangent == NULL &&
            !(released->rule.event == STICK_END && released->rule.part == rule->part)) /* which would slide on */
            return departs(r, r->modes[released->rule.target], released->rule.key) && stick(r, b, e, released->rule.target, released);
        if (answer == 0)
            return 0;
        if (!slips(r, r->modes[rule->other], rule->key) || !sides_last(r, r->modes[rule->other], NOTHING))
            return 0;
        kind = REVERSAL;
        r->behind[rule->key] = 1;
        run_take(r, b, rule->other, 1, &kind, &part);
        return 1;
    }
    return 0;
}
