/* The stroboscopic section; twin of vibsim/kernel/stroboscopic.py. */
#include "kernel.h"
#include "../engine/numbers.h"

#define ITERATIONS 60
#define LAST_PERIOD 9007199254740992.0 /* 2^53: behind it whole numbers of periods are no doubles */

static double period_end(const Scene *s, double k)
{
    double t = k / s->cycles;
    return t - t * (s->cycles_lo / s->cycles);
}

static double angle_at(Run *r, double t, State *state)
{
    flow_state(r, t, state);
    return state->phase + (state->turns - r->state.turns) * TWO_PI;
}

static double passage(Run *r, double end, double target)
{
    double low = r->state.t, high = end, t = low + (high - low) / 2;
    int i;
    for (i = 0; i < ITERATIONS; i++) {
        State state;
        double error = angle_at(r, t, &state) - target, ahead;
        if (error < 0)
            low = t;
        else
            high = t;
        ahead = state.w > 0 ? t - error / state.w : low;
        if (!(low < ahead && ahead < high))
            ahead = low + (high - low) / 2;
        if (ahead == t || !(low < ahead && ahead < high))
            return high;
        t = ahead;
    }
    return high;
}

static void keep(Run *r, Buffers *b, double t)
{
    State state;
    flow_state(r, t, &state);
    write_state(b->section + b->section_count++, b->section_room, &state);
}

void section_start(Run *r)
{
    r->period = 1;
    if (r->scene.harmonic != 0 && r->state.t > 0) {
        r->period = floor(r->state.t * r->scene.cycles);
        r->period = r->period > 1 ? r->period : 1;
        while (period_end(&r->scene, r->period) <= r->state.t && r->period < LAST_PERIOD)
            r->period += 1;
    }
}

int section_gather(Run *r, Buffers *b, double end)
{
    if (b->section_room == 0)
        return 1;
    if (r->scene.has_motor != 0) {
        double first = r->state.phase, last;
        State state;
        int turn;
        if (b->section_count + 2 > b->section_room)
            return 0;
        last = angle_at(r, end, &state);
        for (turn = 0; turn < 2; turn++) {
            double target = turn * TWO_PI + turn * TWO_PI_LO;
            if (first < target && target <= last)
                keep(r, b, passage(r, end, target));
        }
        return 1;
    }
    for (; period_end(&r->scene, r->period) <= end && r->period < LAST_PERIOD; r->period += 1) {
        if (b->section_count >= b->section_room)
            return 0;
        keep(r, b, period_end(&r->scene, r->period));
    }
    return 1;
}
