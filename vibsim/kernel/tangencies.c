/* Events crossed almost tangentially, and what they do to a disturbance; twin of vibsim/events/tangencies.py, saltation.py. */
#include "kernel.h"

#define CLOSE 1e-6

static double transmitted_force(const Run *r, const State *state, int contact)
{
    const Scene *s = &r->scene;
    double y = state->x1 - state->x2, u = state->v1 - state->v2, force = s->k1 * y + s->c * u;
    return contact ? force + s->k2 * (y + s->stop_sign * s->G) : force;
}

double reversal_factor(const Run *r, const State *state, int contact)
{
    double force = fabs(transmitted_force(r, state, contact));
    return (force - r->scene.N) / (force + r->scene.N);
}

static double stopping_share(const Run *r, const State *state, int contact, int sliding)
{
    double force = transmitted_force(r, state, contact);
    return (r->scene.N - sliding * force) / (2 * r->scene.N);
}

void tangencies_forget(Tangencies *t)
{
    t->count = 0;
    t->closest = 1.0;
    t->time = 0.0;
}

void tangencies_pass_by(Tangencies *t, const State *state)
{
    double speed = fabs(state->v1 - state->v2) + t->rate * fabs(state->x1 - state->x2);
    t->fastest = speed > t->fastest ? speed : t->fastest;
}

void tangencies_judge(Run *r, int kind, const State *state, Mode before)
{
    Tangencies *t = &r->tangent.tangencies;
    double rate, share;
    if ((kind == CONTACT_BEGIN || kind == CONTACT_END) && t->fastest > 0)
        rate = (state->v1 - state->v2) / t->fastest;
    else if (kind == STICK_BEGIN)
        rate = stopping_share(r, state, before.contact, before.friction);
    else
        return;
    share = rate * rate;
    if (share < CLOSE)
        t->count += 1;
    if (share < t->closest) {
        t->closest = share;
        t->time = state->t;
    }
}
