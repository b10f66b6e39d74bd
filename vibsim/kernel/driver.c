/* The driver: one loop over segments, for either flow; twin of vibsim/kernel/driver.py. */
#include <string.h>

#include "kernel.h"
#include "../engine/numbers.h"

#define EVENTS_AT_ONE_INSTANT 64

void flow_enter(Run *r, const State *state, Mode mode)
{
    watch(r, mode);
    if (r->scene.closed_form != 0)
        closed_form_enter(r, state, mode);
    else
        taylor_enter(r, state, mode);
}

void flow_jet(Run *r, const State *state, Mode mode, int count, double *jet)
{
    if (r->scene.closed_form != 0)
        closed_form_jet(r, state, mode, count, jet);
    else
        taylor_jet(r, state, mode, count, jet);
}

double flow_anchor(const Run *r)
{
    return r->scene.closed_form != 0 ? r->closed.t0 : r->taylor.t0;
}

void flow_state_after(Run *r, double tau, State *out)
{
    if (r->scene.closed_form != 0)
        closed_form_state_after(r, tau, out);
    else
        taylor_state_after(r, tau, out);
}

void flow_state(Run *r, double t, State *out)
{
    flow_state_after(r, t - flow_anchor(r), out);
    out->t = t;
}

double flow_advance(Run *r, double limit, int *function)
{
    return r->scene.closed_form != 0 ? closed_form_advance(r, limit, function) : taylor_advance(r, limit, function);
}

double flow_longest_piece(const Run *r, double tau)
{
    return r->scene.closed_form != 0 ? closed_form_longest_piece(r, tau) : INFINITY;
}

static double sample_time(const Scene *s, long long i)
{
    return ((double)i * s->every_num) / s->every_den;
}

/* Index of the first sample at or after t. */
static long long sample_index(const Scene *s, double t)
{
    long long i = (long long)(t * s->every_den / s->every_num);
    while (i > 0 && sample_time(s, i - 1) >= t)
        i--;
    while (sample_time(s, i) < t)
        i++;
    return i;
}

void write_state(double *row, long room, const State *s)
{
    row[0] = s->t;
    row[room] = s->x1;
    row[2 * room] = s->v1;
    row[3 * room] = s->x2;
    row[4 * room] = s->v2;
    row[5 * room] = unwind(s->phase, s->turns);
    row[6 * room] = s->w;
}

static void write_sample(const Run *r, Buffers *b, const State *s)
{
    long i = b->sample_count++, room = b->sample_room;
    write_state(b->samples + i, room, s);
    b->sample_modes[i] = (signed char)r->mode.contact;
    b->sample_modes[room + i] = (signed char)r->mode.friction;
}

static void record(Run *r, Buffers *b, int kind)
{
    long i = b->event_count++, room = b->event_room;
    const State *s = &r->state;
    r->counts[kind] += 1;
    write_state(b->events + i, room, s);
    b->events[7 * room + i] = s->phase;
    b->event_codes[i] = (signed char)kind;
    b->event_codes[room + i] = (signed char)r->mode.contact;
    b->event_codes[2 * room + i] = (signed char)r->mode.friction;
}

static void finish(Run *r, Buffers *b)
{
    record(r, b, END);
    r->finished = 1;
}

static void note_violation(Run *r, Buffers *b)
{
    if (!r->violated_once)
        r->first_violation = r->state.t;
    r->violated_once = 1;
    if (r->scene.stop_on_violation != 0)
        finish(r, b);
}

void run_start(Run *r, const Scene *scene, const State *resume, const Mode *mode, const Known *known, Buffers *b)
{
    memset(r, 0, sizeof *r);
    r->scene = *scene;
    r->certificate.margin = INFINITY;
    r->certificate.doubted = NAN;
    if (scene->closed_form != 0)
        closed_form_set(r);
    else
        taylor_set(r);
    if (resume) {
        r->state = *resume;
        r->mode = *mode;
        r->known = *known;
        r->next_sample = sample_index(scene, resume->t);
    } else {
        r->state.x1 = scene->x1;
        r->state.v1 = scene->v1;
        r->state.x2 = scene->x2;
        r->state.v2 = scene->v2;
        if (scene->has_motor != 0) {
            r->state.phase = reduce_angle(scene->phi, &r->state.turns);
            r->state.w = scene->phidot;
        }
        initial_mode(r);
    }
    r->known_since = r->state.t;
    section_start(r);
    r->energy_start = r->stored = ledger_energy(r, &r->state, r->mode);
    tangent_start(r);
    record(r, b, START);
    if (r->mode.violated)
        note_violation(r, b);
    flow_enter(r, &r->state, r->mode);
}

static int take_event(Run *r, Buffers *b, State *state, int function)
{
    Mode mode = r->mode;
    Known known = {{0, 0, 0, 0, 0}};
    int kind;
    if (state->t == r->known_since) {
        known = r->known;
        kind = transition(r, state, function, &mode, &known);
        r->crowd += 1;
        if (r->crowd > EVENTS_AT_ONE_INSTANT) {
            r->state = *state;
            return ACCUMULATION;
        }
    } else {
        kind = transition(r, state, function, &mode, &known);
        r->crowd = 0;
    }
    tangent_cross(r, kind, state, r->mode);
    r->state = *state;
    r->mode = mode;
    r->known = known;
    r->known_since = state->t;
    if (kind != NOTHING) {
        record(r, b, kind);
        if (kind == VIOLATION_BEGIN)
            note_violation(r, b);
    }
    if (!r->finished)
        flow_enter(r, &r->state, r->mode);
    return OK;
}

/* Samples in [now, end), or up to and including the end of the run; 0 when the buffer is full before that. */
static int sample(Run *r, Buffers *b)
{
    double t = sample_time(&r->scene, r->next_sample);
    int last = r->end >= r->scene.t_end;
    State state;
    while (t < r->end || (last && t <= r->end)) {
        if (b->sample_count >= b->sample_room)
            return 0;
        flow_state(r, t, &state);
        write_sample(r, b, &state);
        r->next_sample++;
        t = sample_time(&r->scene, r->next_sample);
    }
    return 1;
}

/* State at the end of the stretch; 0 where it is not finite. */
static int arrive(Run *r)
{
    State *state = &r->arrival;
    flow_state(r, r->end, state);
    if (isfinite(state->x1 + state->v1 + state->x2 + state->v2 + state->w))
        return 1;
    r->status = DIVERGED;
    return 0;
}

/* Where no event ended the stretch: the Taylor flow needs a new expansion, the closed form holds. */
static void carry_on(Run *r, const State *state)
{
    Known none = {{0, 0, 0, 0, 0}};
    r->state = *state;
    if (r->end >= r->scene.t_end || r->scene.closed_form != 0)
        return;
    r->known = none;
    flow_enter(r, &r->state, r->mode);
}

static void open_stretch(Run *r)
{
    r->end = flow_advance(r, r->scene.t_end, &r->function);
    r->carried = r->state.t;
    ledger_open(r);
}

/* The stretch from `state` to the next event, or as far as the flow advances at once: stage by stage. Returns 0 when the
 * room or the work of this call is spent, or the run fails: the next call goes on in the same stage.
 */
static int stretch(Run *r, Buffers *b)
{
    for (; r->stage < STAGES; r->stage++) {
        int done = 1;
        switch (r->stage) {
        case ADVANCE: open_stretch(r); break;
        case SAMPLE: done = sample(r, b); break;
        case SECTION: done = section_gather(r, b, r->end); break;
        case ARRIVE: done = arrive(r); break;
        case LEDGER: done = ledger_gather(r); break;
        case TANGENT: done = tangent_gather(r); break;
        }
        if (!done)
            return 0;
    }
    r->stage = ADVANCE;
    return 1;
}

void run_advance(Run *r, Buffers *b)
{
    r->spent = 0;
    while (!r->finished && r->status == OK && r->spent < WORK_AT_ONCE && b->event_count + 3 < b->event_room) {
        if (!stretch(r, b))
            return;
        r->spent += 1;
        if (r->function != NOTHING)
            r->status = take_event(r, b, &r->arrival, r->function);
        else
            carry_on(r, &r->arrival);
        if (!r->finished && r->status == OK && r->end >= r->scene.t_end)
            finish(r, b);
    }
}

/* Time that the run has been worked out to [s]: within a long stretch ahead of its state. */
double run_worked_to(const Run *r)
{
    if (r->stage == LEDGER)
        return flow_anchor(r) + r->open.tau;
    return r->stage == TANGENT ? r->carried : r->state.t;
}

int run_state_at(Run *r, double t, State *out)
{
    r->spent = 0;
    while (!r->finished && r->status == OK) {
        r->end = flow_advance(r, r->scene.t_end, &r->function);
        if (r->function != NOTHING || r->end >= t || r->end >= r->scene.t_end)
            break;
        if (!arrive(r))
            break;
        carry_on(r, &r->arrival);
        r->spent += 1;
        if (r->spent > WORK_AT_ONCE)
            return 0;
    }
    flow_state(r, t, out);
    return 1;
}
