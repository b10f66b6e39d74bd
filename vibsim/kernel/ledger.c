/* The energy ledger; twin of vibsim/kernel/ledger.py. */
#include "gauss_nodes.h"
#include "kernel.h"
#include "../engine/numbers.h"

double ledger_energy(const Run *r, const State *state, Mode mode)
{
    const Scene *s = &r->scene;
    double y = state->x1 - state->x2;
    double energy = s->m1 * (state->v1 * state->v1) / 2 + s->k1 * (y * y) / 2;
    if (s->has_block2 != 0)
        energy = energy + s->m2 * (state->v2 * state->v2) / 2;
    if (mode.contact) {
        double gap = -(s->stop_sign * y) - s->G;
        energy = energy + s->k2 * (gap * gap) / 2;
    }
    if (s->has_motor != 0) {
        double spin = s->e * state->w;
        energy = energy + s->m3 * (state->v1 * state->v1) / 2;
        energy = energy + (s->J + s->m3 * s->e * s->e) * (state->w * state->w) / 2;
        energy = energy - s->m3 * (state->v1 * (spin * sin(state->phase)));
    }
    return energy;
}

static double power(const Run *r, const State *state, double tau)
{
    const Scene *s = &r->scene;
    double angle;
    if (s->has_motor != 0)
        return s->M0 * (1.0 - state->w / s->Omega0) * state->w;
    if (s->harmonic == 0)
        return 0.0;
    angle = turn_angle(s->cycles, s->cycles_lo, flow_anchor(r)) + turn_angle(s->cycles, s->cycles_lo, tau);
    return (s->A * sin(angle) + s->F0) * state->v1;
}

static void integrate(Run *r, OpenStretch *open, double length)
{
    double work = 0, viscous = 0;
    int i;
    for (i = 0; i < NODE_COUNT; i++) {
        double offset = open->tau + NODES[i] * length, u;
        State state;
        flow_state_after(r, offset, &state);
        u = state.v1 - state.v2;
        viscous = viscous + WEIGHTS[i] * (u * u);
        work = work + WEIGHTS[i] * power(r, &state, offset);
    }
    open->work = open->work + length * work;
    open->viscous = open->viscous + length * (r->scene.c * viscous);
}

void ledger_open(Run *r)
{
    r->open.tau = r->state.t - flow_anchor(r);
    r->open.work = r->work;
    r->open.viscous = r->viscous;
}

int ledger_gather(Run *r)
{
    OpenStretch *open = &r->open;
    double last = r->end - flow_anchor(r);
    if (r->scene.ledger == 0)
        return 1;
    while (open->tau < last) {
        double piece = flow_longest_piece(r, open->tau);
        double ahead = piece < last - open->tau ? open->tau + piece : last;
        if (r->spent > WORK_AT_ONCE)
            return 0;
        integrate(r, open, ahead - open->tau);
        open->tau = ahead;
    }
    r->work = open->work;
    r->viscous = open->viscous;
    if (r->scene.has_friction != 0 && r->mode.friction != 0)
        r->friction_loss = r->friction_loss + r->scene.N * (r->mode.friction * (r->arrival.x2 - r->state.x2));
    r->stored = ledger_energy(r, &r->arrival, r->mode);
    return 1;
}
