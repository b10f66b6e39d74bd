/* What an event does to small disturbances, where no formula jumps and no rigid stop is struck;
 * vibsim/engine/tangent/saltation.py says what it is, and has it for the others.
 */
#include <stddef.h>

#include "tangent.h"

static const Saltation nothing = {SAME, NULL, NULL, NULL, 1.0};

/* n^T times a disturbance whose entries are `stride` apart. */
Real gradient(const Run *r, const Mode *m, const Event *event, const Real *vector, int stride)
{
    Real total = 0.0;
    int i;
    for (i = 0; i < event->terms; i++) {
        const Term *t = &m->terms[event->first + i];
        const Real *of = vector + (t->kind == DIFFERENCE ? 0 : r->bodies) * stride;
        Real P = t->P < r->bodies ? of[t->P * stride] : 0.0, Q = t->Q < r->bodies ? of[t->Q * stride] : 0.0;
        Real part = t->coefficient * (P - Q);
        total = i == 0 ? part : total + part;
    }
    return total;
}

/* Rate of an event function along the motion in the mode m. */
Real event_rate_at(const Run *r, const State *state, const Mode *m, const Event *event)
{
    Real *values = r->tangent->other_accelerations, total = 0.0, X;
    int i;
    if (m->terms[event->first].kind == DIFFERENCE) {
        for (i = 0; i < r->bodies; i++)
            values[i] = state->v[i];
        values[r->bodies] = 0.0;
        base_motion_at(r, m, state->t, &X, &values[r->bodies + 1]);
    } else {
        accelerations(r, m, state, values);
    }
    for (i = 0; i < event->terms; i++) {
        const Term *t = &m->terms[event->first + i];
        Real part = t->coefficient * (values[t->P] - values[t->Q]);
        total = i == 0 ? part : total + part;
    }
    return total;
}

/* S from the jump of the accelerations, in b->accelerations, and of the rotor's. */
static Saltation rank_one(const Run *r, const Mode *m, const Event *event, Real rotor, Real rate)
{
    const Tangent *b = r->tangent;
    Saltation s = nothing;
    int c, n = r->bodies;
    if (rate == 0)
        return s;
    s.kind = MOVED;
    s.before = m;
    s.event = event;
    s.jump = b->jump;
    for (c = 0; c < n; c++) {
        s.jump[c] = 0.0;
        s.jump[n + c] = b->accelerations[c] / rate;
    }
    if (r->has_motor) {
        s.jump[2 * n] = 0.0;
        s.jump[2 * n + 1] = rotor / rate;
    }
    s.determinant = 1 + gradient(r, m, event, s.jump, 1);
    return s;
}

static void add_force(const Run *r, const Mode *m, Real *F, int P, int Q, Real force)
{
    if (P < r->bodies)
        F[m->leader[P]] = F[m->leader[P]] + force;
    if (Q < r->bodies)
        F[m->leader[Q]] = F[m->leader[Q]] + -force;
}

static void clear(const Run *r, Real *F)
{
    int c;
    for (c = 0; c < r->columns; c++)
        F[c] = 0.0;
}

/* Force of a slipping friction on P; one that sticks acts within a group, where it does not count. */
static Real friction_force(const FrictionEnds *f, int status)
{
    return status == 0 ? 0.0 : status > 0 ? -f->forward : f->backward;
}

/* A damped stop touches or leaves at its gap: its force jumps by c per unit of the rate x_P' - x_Q'. */
static Saltation damped(const Run *r, const State *state, const Mode *before, const Event *event, int gained)
{
    const StopEnds *stop = &r->tangent->stops[event->part];
    Real *F = r->tangent->force, rotor;
    clear(r, F);
    add_force(r, before, F, stop->P, stop->Q, -(gained * stop->c));
    rotor = response(r, before, state, F, 0.0, 0.0, r->tangent->accelerations);
    return rank_one(r, before, event, rotor, before->terms[event->first].coefficient);
}

/* Frictions turn round. */
static Saltation reversal(const Run *r, const State *state, const Mode *before, const Mode *after, const Event *event)
{
    const Tangent *b = r->tangent;
    const int *old = before->codes + b->stop_count, *now = after->codes + b->stop_count;
    Real rate = event_rate_at(r, state, before, event), rotor;
    int i;
    clear(r, b->force);
    for (i = 0; i < b->friction_count; i++)
        if (old[i] != now[i]) {
            const FrictionEnds *f = &b->frictions[i];
            add_force(r, before, b->force, f->P, f->Q, friction_force(f, now[i]) - friction_force(f, old[i]));
        }
    rotor = response(r, before, state, b->force, 0.0, 0.0, b->accelerations);
    return rank_one(r, before, event, rotor, rate);
}

/* S by the vector fields on both sides. */
static Saltation general(const Run *r, const State *state, const Mode *before, const Mode *after, const Event *event)
{
    const Tangent *b = r->tangent;
    Real rate = event_rate_at(r, state, before, event);
    Real rotor = accelerations(r, before, state, b->other_accelerations), turned = accelerations(r, after, state, b->accelerations);
    int c;
    for (c = 0; c < r->columns; c++)
        b->accelerations[c] = b->accelerations[c] - b->other_accelerations[c];
    return rank_one(r, before, event, turned - rotor, rate);
}

/* The saltation of `event` at `state` between two modes; at a tangency, where first order says nothing, none. */
Saltation saltation(const Run *r, const State *state, const Mode *before, const Mode *after, const Event *event)
{
    const Tangent *b = r->tangent;
    const int *old = before->codes + b->stop_count, *now = after->codes + b->stop_count;
    int turned = 0, all_stick = 1, tied = 0, gained = 0, i;
    Saltation s = nothing;
    if ((event->kind == SLIDE || event->kind == GAP) && !same_seats(r, before, after))
        return general(r, state, before, after, event);
    for (i = 0; i < b->friction_count; i++)
        if (old[i] != now[i]) {
            turned = 1;
            all_stick = all_stick && now[i] == 0;
        }
    if (!turned) {
        if (event->kind == GAP)
            gained = (after->codes[event->part] == IN_CONTACT) - (before->codes[event->part] == IN_CONTACT);
        return gained && b->stops[event->part].c != 0 ? damped(r, state, before, event, gained) : s;
    }
    for (i = 0; i < r->columns; i++)
        tied = tied || before->leader[i] != after->leader[i];
    if (event->kind == SLIDE && tied && all_stick) {
        s.kind = JOINED;
        s.before = after;
        return s;
    }
    if (event->kind == SLIDE && !tied)
        return reversal(r, state, before, after, event);
    return event->kind == SLIDE || event->kind == GAP ? general(r, state, before, after, event) : s;
}

/* Apply S to the possible disturbances. */
void saltation_apply(const Run *r, const Saltation *s, const State *state)
{
    Tangent *b = r->tangent;
    int i, k;
    if (s->kind == JOINED)
        join_disturbances(r, s->before, state);
    for (i = 0; s->kind == MOVED && i < b->possible; i++) {
        Real along = gradient(r, s->before, s->event, b->vectors + i, b->stride);
        for (k = 0; k < b->size; k++)
            b->vectors[k * b->stride + i] = b->vectors[k * b->stride + i] + along * s->jump[k];
    }
}

/* Accelerations of the bodies by the forces that friction i gains where it turns round in the mode m. */
void reversal_accelerations(const Run *r, const Mode *m, const State *state, int i, Real *out)
{
    const Tangent *b = r->tangent;
    const FrictionEnds *f = &b->frictions[i];
    Real total = f->forward + f->backward;
    clear(r, b->force);
    add_force(r, m, b->force, f->P, f->Q, m->codes[b->stop_count + i] > 0 ? total : -total);
    response(r, m, state, b->force, 0.0, 0.0, out);
}
