/* The mode automaton; twin of vibsim/events/automaton.py and watch.py. */
#include "certificate.h"
#include "kernel.h"
#include "../engine/numbers.h"

#define JET 7
#define START_ROUNDING 16

void watch(Run *r, Mode mode)
{
    const Scene *s = &r->scene;
    int n = 0;
    if (s->has_stop != 0)
        r->functions[n++] = GAP;
    if (s->has_friction != 0) {
        if (mode.friction != 0) {
            r->functions[n++] = SLIDE;
        } else {
            r->functions[n++] = HOLD_PLUS;
            r->functions[n++] = HOLD_MINUS;
        }
    }
    if (s->has_rest != 0)
        r->functions[n++] = CLEARANCE;
    r->function_count = n;
}

static double transmitted_force(const Scene *s, double y, double u, int contact)
{
    double force = s->k1 * y + s->c * u;
    return contact ? force + s->k2 * (y + s->stop_sign * s->G) : force;
}

/* Sign of the first non-zero derivative of factor (x1 - x2). */
static int turning(Run *r, const State *state, Mode mode, double rate, double factor)
{
    double jet[JET + 3];
    int n;
    if (rate != 0)
        return sign_of(rate);
    flow_jet(r, state, mode, JET, jet);
    for (n = 2; n <= JET; n++)
        if (factor * jet[n] != 0)
            return sign_of(factor * jet[n]);
    return 0;
}

/* Sign of the first non-zero derivative of direction * S. */
static int force_growth(Run *r, const State *state, Mode mode, int direction)
{
    double jet[JET + 3], k = mode.contact ? r->scene.k1 + r->scene.k2 : r->scene.k1;
    int n;
    flow_jet(r, state, mode, JET + 1, jet);
    for (n = 1; n < JET; n++) {
        double value = direction * (k * jet[n] + r->scene.c * jet[n + 1]);
        if (value != 0)
            return sign_of(value);
    }
    return 0;
}

static double transmitted_force_size(const Scene *s, double y, double u, int contact)
{
    double size = s->k1 * fabs(y) + s->c * fabs(u);
    return contact ? size + s->k2 * (fabs(y) + fabs(s->G)) : size;
}

static int friction_at_rest(Run *r, const State *state, Mode stuck)
{
    double y = state->x1 - state->x2, u = state->v1 - state->v2;
    double force = transmitted_force(&r->scene, y, u, stuck.contact);
    int direction;
    if (fabs(fabs(force) - r->scene.N) < 4 * EPS * transmitted_force_size(&r->scene, y, u, stuck.contact))
        doubt(&r->certificate, state->t);
    if (fabs(force) < r->scene.N)
        return 0;
    direction = sign_of(force);
    if (fabs(force) > r->scene.N || force_growth(r, state, stuck, direction) > 0)
        return direction;
    return 0;
}

/* What rounding took from a - b (Knuth's two-sum). */
static double difference_error(double a, double b, double difference)
{
    double back = a - difference;
    return (a - (difference + back)) + (back - b);
}

/* Whether the rounding of x1 - x2 and of its sum with `distance` could turn the sign of `value`. */
static int blurred(double value, double x1, double x2, double distance)
{
    double y = x1 - x2, sum = y + distance;
    double lost = fabs(difference_error(x1, x2, y)) + fabs(difference_error(y, -distance, sum));
    return lost > 0 && fabs(value) <= lost;
}

/* Whether a start lies exactly where `value` = x1 - x2 + ... is zero: as computed, or as `told` from exact numbers. */
static int starts_at(double value, const State *state, double distance, double told)
{
    double size = fabs(state->x1) + fabs(state->x2) + fabs(distance);
    return value == 0 || (told != 0 && fabs(value) <= START_ROUNDING * EPS * size);
}

void initial_mode(Run *r)
{
    const Scene *s = &r->scene;
    State *state = &r->state;
    double y = state->x1 - state->x2, u = state->v1 - state->v2;
    double gap = s->has_stop != 0 ? -(s->stop_sign * y) - s->G : -1;
    int at_stop = s->has_stop != 0 && starts_at(gap, state, s->G, s->at_stop);
    int contact = gap > 0 && !at_stop ? 1 : 0, friction = 1, i;
    for (i = 0; i < FUNCTIONS; i++)
        r->known.order[i] = 0;
    if (s->has_stop != 0 && !at_stop && blurred(gap, state->x1, state->x2, s->stop_sign * s->G))
        doubt(&r->certificate, state->t);
    if (s->has_friction != 0) {
        Mode stuck = {contact, 0, 0};
        friction = sign_of(state->v2);
        if (friction == 0)
            friction = friction_at_rest(r, state, stuck);
        if (state->v2 == 0 && friction != 0)
            r->known.order[SLIDE] = 1;
    }
    if (at_stop) {
        Mode open = {0, friction, 0};
        contact = turning(r, state, open, -(s->stop_sign * u), -s->stop_sign) > 0 ? 1 : 0;
        r->known.order[GAP] = 1;
    }
    r->mode.contact = contact;
    r->mode.friction = friction;
    r->mode.violated = s->has_rest != 0 && y > s->rest_distance ? 1 : 0;
    if (s->has_rest == 0)
        return;
    if (!starts_at(y - s->rest_distance, state, s->rest_distance, s->at_rest)) {
        if (blurred(y - s->rest_distance, state->x1, state->x2, -s->rest_distance))
            doubt(&r->certificate, state->t);
    } else {
        Mode near = {contact, friction, 0};
        r->mode.violated = turning(r, state, near, u, 1) > 0 ? 1 : 0;
        r->known.order[CLEARANCE] = 1;
    }
}

/* Mode and known zeros behind the zero of `function`; returns the event kind, or NOTHING for a touch. */
int transition(Run *r, State *state, int function, Mode *mode, Known *known)
{
    const Scene *s = &r->scene;
    Mode stuck = {mode->contact, 0, mode->violated};
    double u = state->v1 - state->v2;
    int turn, direction, before;
    if (function == GAP) {
        turn = turning(r, state, *mode, -(s->stop_sign * u), -s->stop_sign);
        before = mode->contact;
        mode->contact = turn == 0 ? before : turn > 0 ? 1 : 0;
        known->order[GAP] = 1;
        return mode->contact == before ? NOTHING : mode->contact ? CONTACT_BEGIN : CONTACT_END;
    }
    if (function == CLEARANCE) {
        turn = turning(r, state, *mode, u, 1);
        before = mode->violated;
        mode->violated = turn == 0 ? before : turn > 0 ? 1 : 0;
        known->order[CLEARANCE] = 1;
        return mode->violated == before ? NOTHING : mode->violated ? VIOLATION_BEGIN : VIOLATION_END;
    }
    if (function == SLIDE) {
        before = mode->friction;
        mode->friction = friction_at_rest(r, state, stuck);
        if (mode->friction != 0)
            known->order[SLIDE] = 1;
        if (mode->friction == 0) {
            state->v2 = state->v2 * 0;
            return STICK_BEGIN;
        }
        return mode->friction == before ? NOTHING : REVERSAL;
    }
    direction = function == HOLD_PLUS ? 1 : -1;
    if (force_growth(r, state, *mode, direction) > 0) {
        mode->friction = direction;
        known->order[SLIDE] = 2;
        return STICK_END;
    }
    known->order[function] = 1;
    return NOTHING;
}
