/* The driver: one loop over stretches of motion, for either flow.
 *
 * Output cadence never changes a trajectory: samples are read off the flow, states are not restarted there.
 */
#include <string.h>

#include "certificate.h"
#include "event_functions.h"
#include "lanes.h"
#include "numbers.h"

#define EVENTS_AT_ONE_INSTANT 64 /* more than that are an accumulation, which ends the run */
#define MOST_STRETCHES 50000 /* that a run in doubles may take for PROGRESS of it, one of more digits as many times more */
#define PROGRESS 0x1p-30 /* share of the run that so many stretches must bring it on: it would take 5e13 */
/* Roundings of a time: what only bends so soon behind an event leaves its zeros known. A law that has a kink where a sliding velocity
 * is zero bends there once the friction has let go: that velocity is still zero then.
 */
#define AS_SOON 8
#define KICK 0x1p-49 /* 16 unit round-offs of doubles: so far off a computed state may be (tests/flows/test_responses.py) */

/* Whether a rigid stop that was struck here will be again within the window of the closed form, just entered. */
static int hops(Run *r)
{
    const Mode *m = r->mode;
    int i;
    for (i = 0; i < m->event_count; i++) {
        const Event *e = &m->events[i];
        Real speed, drive;
        if (e->kind != STRIKE || r->known[e->key] != 1)
            continue;
        closed_form_jets(r, 2);
        speed = event_derivative(r, e, 1);
        drive = event_derivative(r, e, 2);
        if (drive < 0 && 2 * speed < -drive * m->modal->window)
            return 1;
    }
    return 0;
}

/* `value`, up or down by KICK of `size` as splitmix64 (Steele, Lea & Flood 2014) draws; an exact zero, which is set and not
 * computed, stays.
 */
static Real kicked(Run *r, Real value, Real size)
{
    unsigned long long z = r->kicks += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    if (value == 0)
        return value;
    return (z ^ (z >> 31)) & 1 ? value + KICK * size : value - KICK * size;
}

/* Move the state that the flow goes on from as a run in doubles rounds it: displacements and velocities by the size of the
 * largest, the phase by that of a radian. A run of many digits that is kicked so tells what rounding does to a motion.
 */
static void kick(Run *r)
{
    State *s = &r->state;
    Real length = 0, speed = 0;
    int c;
    if (r->kicks == 0)
        return;
    for (c = 0; c < r->bodies; c++) {
        length = fmax(length, fabs(s->x[c]));
        speed = fmax(speed, fabs(s->v[c]));
    }
    for (c = 0; c < r->bodies; c++) {
        s->x[c] = kicked(r, s->x[c], length);
        s->v[c] = kicked(r, s->v[c], speed);
    }
    s->phase = kicked(r, s->phase, 1);
    s->w = kicked(r, s->w, fabs(s->w));
}

/* Go on from r->state in the mode of now, with the zeros in r->known: by the closed form where the mode has one, else by Taylor series. A
 * run that shares lanes waits there for its step.
 *
 * Short hops on a rigid stop are taken by Taylor series, which count depths from where the hop begins: the last ones of an
 * infinite sequence of impacts are lower than the rounding of displacements, in which the closed form looks for the next impact.
 * So are stretches at whose start more derivatives of an event function are zero than the closed form takes, as at the end of a
 * chain whose other end is shaken.
 */
static void enter(Run *r)
{
    const State *state = &r->state;
    kick(r);
    r->waits = r->abreast && suits_lanes(r);
    if (r->waits)
        return;
    if (r->mode->modal == NULL || leaves_flat(r, state)) {
        taylor_enter(r, state);
        return;
    }
    closed_form_enter(r, state);
    if (hops(r))
        taylor_enter(r, state);
}

/* Go to the first event, to where the flow stops by itself, or to `limit`: the time, and in `event` its number or NOTHING. */
static Real flow_advance(Run *r, Real limit, int *event)
{
    return r->closed ? closed_form_advance(r, limit, event) : taylor_advance(r, limit, event);
}

/* State at t, a time tau after the start of the flow, which may be beside the grid of time. */
static void state_after(Run *r, Real t, Real tau, State *out)
{
    if (r->closed)
        closed_form_state_after(r, tau, out);
    else
        taylor_state_after(r, tau, out);
    out->t = t;
}

void flow_state(Run *r, Real t, State *out)
{
    state_after(r, t, t - r->t0, out);
}

static void copy_state(const Run *r, const State *from, State *to)
{
    size_t size = sizeof(Real) * (size_t)r->bodies;
    to->t = from->t;
    to->phase = from->phase;
    to->turns = from->turns;
    to->w = from->w;
    memcpy(to->x, from->x, size);
    memcpy(to->v, from->v, size);
}

static void finish(Run *r, Buffers *b)
{
    record_event(r, b, END, -1, r->state.v, r->state.w);
    r->finished = 1;
}

/* Keep the time of the first violation of a clearance; where the scene asks for that, the run ends there. */
static void note_violation(Run *r, Buffers *b)
{
    if (!r->violated_once)
        r->first_violation = r->state.t;
    r->violated_once = 1;
    if (r->stop_on_violation)
        finish(r, b);
}

static void use_mode(Run *r, int number)
{
    r->mode_number = r->certificate.mode = number;
    r->mode = r->modes[number];
}

/* Whether the mode of now violates a clearance, whose codes are the last ones. */
static int violated(const Run *r)
{
    int i;
    for (i = r->parts - r->clearances; i < r->parts; i++)
        if (r->mode->codes[i])
            return 1;
    return 0;
}

/* Begin a run, or go on with one that is restarted, at r->state in a mode, with the zeros in r->known; those whose order in r->behind is
 * below zero are looked at once more. Samples begin with the first at that state or behind it, and not before `samples_from`.
 */
void run_start(Run *r, int mode, Buffers *b)
{
#ifdef FIXED_SERIES
    int i;
    for (i = 0; i < r->mode_count; i++)
        r->modes[i]->scales.most = 0; /* each run begins as the first one did */
#endif
    use_mode(r, mode);
    r->next_sample = sample_index(r, fmax(r->state.t, r->samples_from));
    r->at_begin.t = -1;
    r->known_since = r->progress_deadline = r->state.t;
    r->stretches = 0;
    section_start(r);
    record_event(r, b, START, -1, r->state.v, r->state.w);
    if (violated(r))
        note_violation(r, b);
    tangent_open(r);
    review_zeros(r, NULL);
    record_zeros(r, b, 0);
    enter(r); /* though it may be finished: a state is read there */
}

/* As before the start, with another end; modes and what follows their events are kept. */
void run_rewind(Run *r, Real t_end)
{
    int k;
    r->t_end = t_end;
    for (k = 0; k < KINDS; k++)
        r->counts[k] = 0;
    for (k = 0; k < r->ledger.count; k++)
        r->ledger.entries[k] = 0.0;
    r->evaluations = r->steps = r->steps_beside = 0;
    r->waits = 0;
    r->first_violation = 0;
    r->events_at_instant = r->finished = r->violated_once = r->dithered = r->interrupted = 0;
    r->status = OK;
    r->stage = ADVANCE;
    certificate_open(&r->certificate);
    extremes_reset(&r->extremes);
    tangent_free(r->tangent);
    r->tangent = NULL;
}

/* Go on in a mode behind the pending event, with the zeros in r->behind. Those known before stay known behind an event at the same
 * instant, and where nothing happens so soon that rounding alone may part the two times (AS_SOON). Too many events at one instant
 * end the run.
 */
void run_take(Run *r, Buffers *b, int mode, int happened, const int *kinds, const int *parts)
{
    const Mode *left = r->mode;
    const int *before = left->codes;
    const int again = r->next.t == r->known_since;
    const long first = b->event_count;
    int i, k;
    tangent_cross(r, r->pending_event, left, r->modes[mode]);
    if (again || (happened == 0 && r->next.t - r->known_since <= AS_SOON * EPS * r->next.t)) {
        for (k = 0; k < r->key_count; k++)
            if (r->behind[k] >= 0)
                r->known[k] = r->behind[k];
        r->events_at_instant += 1;
        if (r->events_at_instant > EVENTS_AT_ONE_INSTANT) {
            copy_state(r, &r->next, &r->state);
            r->status = ACCUMULATION;
            return;
        }
    } else {
        for (k = 0; k < r->key_count; k++)
            r->known[k] = r->behind[k] >= 0 ? r->behind[k] : 0;
        r->events_at_instant = 0;
    }
    copy_state(r, &r->next, &r->state);
    use_mode(r, mode);
    r->known_since = r->state.t;
    ledger_cross(r, &r->state, before, r->mode->codes);
    for (i = 0; i < happened; i++) {
        record_event(r, b, kinds[i], parts[i], r->before_v, r->before_w);
        if (kinds[i] == VIOLATION_BEGIN)
            note_violation(r, b);
    }
    if (again && !r->finished)
        review_zeros(r, left);
    record_zeros(r, b, first);
    if (!r->finished)
        enter(r);
    if (!r->finished && r->status == OK && r->pending_end >= r->t_end)
        finish(r, b);
}

static int is_finite(const Run *r, const State *s)
{
    Real total = s->w;
    int c;
    for (c = 0; c < r->bodies; c++)
        total = total + s->x[c] + s->v[c];
    return isfinite(total);
}

/* How long after its start the flow reaches the zero of the event of a rigid stop, which is not on the grid of time: one Newton
 * step from the time on that grid, unless it leads further than to the next.
 */
static Real meeting(Run *r, const Event *e)
{
    Real tau = r->pending_end - r->t0, value, slope, noise, step;
    if (r->closed) {
        closed_form_evaluate(r, tau);
        closed_form_jets(r, 2);
        value = event_derivative(r, e, 0);
        slope = event_derivative(r, e, 1);
    } else if (!taylor_near_zero(r, e, tau, &value, &slope, &noise)) {
        return tau;
    }
    if (!(slope < 0))
        return tau;
    step = value / slope;
    return fabs(step) <= nextafter(r->pending_end, INFINITY) - r->pending_end ? tau - step : tau;
}

/* The time of an event, which is rounded to the grid of time; with `dither` = k > 0 the next time on that grid. For the n-th event it
 * is later where an even number of binary digits 1 of n stand k places before another (k = 1: Rudin and Shapiro), else earlier: as
 * uncorrelated as random signs.
 */
static Real dithered(Run *r)
{
    unsigned ones;
    int odd = 0;
    Real at;
    if (!r->dither || r->pending_end <= r->t0)
        return r->pending_end;
    r->dithered += 1;
    for (ones = r->dithered & (r->dithered >> r->dither); ones; ones &= ones - 1)
        odd = !odd;
    at = nextafter(r->pending_end, odd ? -INFINITY : INFINITY);
    return r->t0 < at && at <= r->t_end ? at : r->pending_end;
}

/* Take the state at the end of the stretch, once: there, or at the very instant of an impact. So a speed grows or shrinks by
 * nothing but the impact, however short the stretch is against the grid of time. No rounding moves a state that is struck where
 * the stretch begins.
 */
void run_arrive(Run *r)
{
    const Event *e = r->pending_event == NOTHING ? NULL : &r->mode->events[r->pending_event];
    Real at;
    if (r->arrived)
        return;
    r->arrived = 1;
    at = e == NULL ? r->pending_end : dithered(r);
    r->pending_tau = e != NULL && e->kind == STRIKE ? meeting(r, e) : at - r->t0;
    if (e != NULL && e->kind == STRIKE && r->pending_tau == 0) {
        copy_state(r, &r->state, &r->next);
        r->next.t = at;
    } else {
        state_after(r, at, r->pending_tau, &r->next);
    }
    memcpy(r->before_v, r->next.v, sizeof(Real) * (size_t)r->bodies);
    r->before_w = r->next.w;
}

/* State at the end of the stretch; 0 where it is not finite. */
static int arrive(Run *r)
{
    run_arrive(r);
    if (is_finite(r, &r->next))
        return 1;
    r->status = DIVERGED;
    return 0;
}

/* Let the flow find the end of the next stretch, and open it for all that is gathered along it. */
static void open_stretch(Run *r)
{
    double steps = r->steps;
    r->pending_end = flow_advance(r, r->t_end, &r->pending_event);
    r->arrived = 0;
    r->spent += r->steps - steps;
    extremes_open(r);
    ledger_open(r);
    tangent_begin_stretch(r);
}

/* Whether a run would never end, stretch by stretch within its rounding. */
static int stands_still(Run *r)
{
    if (r->state.t > r->progress_deadline) {
        r->progress_deadline = r->state.t + PROGRESS * r->t_end;
        r->stretches = 0;
        return 0;
    }
    r->stretches += 1;
    return r->stretches > MOST_STRETCHES * (binary_exponent(EPS) / -52.0);
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
        case SAMPLE: record_begin(r); done = record_samples(r, b); break;
        case SECTION: done = section_gather(r, b, r->pending_end); break;
        case ARRIVE: done = arrive(r); break;
        case EXTREMES: done = extremes_until(r, r->next.t, 1); break;
        case LEDGER: done = ledger_gather(r); break;
        case TANGENT: done = tangent_gather(r); break;
        }
        if (!done)
            return 0;
    }
    r->stage = ADVANCE;
    return 1;
}

/* Where no event ended the stretch: the Taylor flow needs a new expansion, the closed form holds. */
static void carry_on(Run *r, Buffers *b)
{
    copy_state(r, &r->next, &r->state);
    if (r->pending_end < r->t_end && !r->closed) {
        memset(r->known, 0, sizeof(int) * (size_t)r->key_count);
        kick(r);
        r->waits = r->abreast && suits_lanes(r);
        if (!r->waits)
            taylor_continue(r, &r->state);
    }
    if (b && r->pending_end >= r->t_end)
        finish(r, b);
}

/* Take the pending event by a rule that came meanwhile; 0 where it is still undecided. */
static int ruled_meanwhile(Run *r, Buffers *b)
{
    if (r->status != UNDECIDED)
        return 1;
    r->status = OK;
    if (rule_take(r, b))
        return 1;
    r->status = UNDECIDED;
    return 0;
}

/* Expand anew where a signal has ended the expansion; what it has ended elsewhere goes on by itself. A run that waits and is advanced
 * alone takes its step by itself.
 */
static void enter_again(Run *r)
{
    const int flow = r->interrupted == FLOW;
    r->interrupted = 0;
    if (r->waits && !r->abreast) {
        r->waits = 0;
        taylor_continue(r, &r->state);
    }
    if (flow)
        taylor_enter(r, &r->state);
}

/* Whether the buffer has room for all that one event can record. */
static int room_for_events(const Run *r, const Buffers *b)
{
    return b->event_count + 3 + 3 * r->parts < b->event_room;
}

/* Stretch by stretch as far as `run_advance` goes, or to where the run waits for a step that is taken beside others. */
static void go_on(Run *r, Buffers *b)
{
    while (!r->waits && !r->finished && r->status == OK && !r->interrupted && r->spent < r->work_at_once && r->state.t < r->pause) {
        if (!room_for_events(r, b))
            return;
        if (r->stage == ADVANCE && stands_still(r)) {
            r->status = STANDSTILL;
            return;
        }
        if (!stretch(r, b))
            return;
        r->spent += 1;
        if (r->pending_event == NOTHING)
            carry_on(r, b);
        else if (!rule_take(r, b))
            r->status = UNDECIDED;
    }
}

/* Advance until the run ends, pauses or fails, or the room or the work of this call is spent. An event without a rule leaves the
 * status UNDECIDED: Python takes it, or makes its rule.
 */
void run_advance(Run *r, Buffers *b)
{
    r->spent = 0;
    enter_again(r);
    if (ruled_meanwhile(r, b))
        go_on(r, b);
}

#ifndef LIMBS
/* Advance several runs, each as by itself, with their steps in lanes where these suit: as many as there are lanes, and where one has come
 * as far as it goes the next one in its place. When none is left for a free lane, and one has stopped that is not at its end, the
 * others wait for the next call. widest: lanes in a vector at most.
 */
void runs_advance(Run **runs, Buffers **buffers, int count, int widest)
{
    Lanes lanes;
    Run *of[RUNS_AT_ONCE] = {NULL};
    Buffers *filled[RUNS_AT_ONCE] = {NULL};
    int next = 0, stopped, i;
    unsigned waiting;
    lanes_open(&lanes, runs, count, widest);
    for (;;) {
        waiting = 0;
        stopped = 0;
        for (i = 0; i < RUNS_AT_ONCE; i++) {
            if (of[i])
                go_on(of[i], filled[i]);
            while (next < count && !(of[i] && of[i]->waits)) {
                of[i] = runs[next];
                filled[i] = buffers[next++];
                run_advance(of[i], filled[i]);
            }
            if (of[i] && of[i]->waits)
                waiting |= 1u << i;
            else
                stopped |= of[i] && !of[i]->finished;
        }
        if (!waiting || stopped)
            break;
        lanes_step(&lanes, of, waiting);
    }
    for (i = 0; i < count; i++)
        runs[i]->abreast = 0;
}
#endif

/* Time that the run has been worked out to [s]: within a long stretch ahead of its state. */
Real run_worked_to(const Run *r)
{
    if (r->stage == TANGENT && r->tangent)
        return tangent_worked_to(r);
    return r->stage == LEDGER && r->ledger.wanted ? r->t0 + r->ledger.tau : r->state.t;
}

/* State at t, as a sample there: events up to t are taken; 0 where it has to be called again, -1 where Python decides the pending
 * event or no step moves time.
 */
int run_state_at(Run *r, Buffers *b, Real t, State *out)
{
    enter_again(r);
    if (!ruled_meanwhile(r, b))
        return -1;
    while (!r->finished && r->status == OK && !r->interrupted) {
        double steps = r->steps;
        r->pending_end = flow_advance(r, r->t_end, &r->pending_event);
        r->arrived = 0;
        if (r->pending_end > t || r->pending_end >= r->t_end || !arrive(r))
            break;
        if (r->pending_event == NOTHING) {
            carry_on(r, NULL);
        } else if (!rule_take(r, b)) {
            r->status = UNDECIDED;
            return -1;
        }
        r->spent += r->steps - steps + 1;
        if (r->spent > r->work_at_once || !room_for_events(r, b))
            return 0;
    }
    if (r->interrupted)
        return 0;
    if (r->status == SINGULAR)
        return -1;
    flow_state(r, t, out);
    return 1;
}
