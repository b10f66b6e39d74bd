/* What a run writes: samples at regular times, and events with the state in front of them. */
#include <string.h>

#include "engine.h"
#include "numbers.h"

#define ZERO_UNIT 0x1p-20 /* of an order of a zero that is told beside a side, as in formula_rows.py */

static Real sample_time(const Run *r, long long i)
{
    return ((double)i * (double)r->every_num) / (double)r->every_den; /* a double in every number type */
}

/* Index of the first sample at or after t. */
long long sample_index(const Run *r, Real t)
{
    long long i = (long long)(t * r->every_den / r->every_num);
    while (i > 0 && sample_time(r, i - 1) >= t)
        i--;
    while (sample_time(r, i) < t)
        i++;
    return i;
}

void write_state(const Run *r, Real *row, long room, const State *s)
{
    int c;
    row[0] = s->t;
    for (c = 0; c < r->bodies; c++) {
        row[(1 + 2 * c) * room] = s->x[c];
        row[(2 + 2 * c) * room] = s->v[c];
    }
    row += (1 + 2 * r->bodies) * room;
    row[0] = unwind(s->phase, s->turns);
    row[room] = s->w;
}

/* What each part does in the mode of now, `count` times. */
void write_codes(const Run *r, signed char *row, long room, int count)
{
    int i;
    for (i = 0; i < r->parts; i++)
        memset(row + i * room, (signed char)r->mode->codes[i], (size_t)count);
}

/* The rows of an event that tell the sides of switches, in their order. */
static Real *sides_of_event(const Run *r, const Buffers *b, long i)
{
    return b->events + (5 + 3 * r->bodies) * b->event_room + i;
}

/* Keep an event; v, w: velocities of the bodies and speed of the rotor in front of it. */
void record_event(Run *r, Buffers *b, int kind, int part, const Real *v, Real w)
{
    long i = b->event_count++, room = b->event_room;
    Real *before = b->events + (4 + 2 * r->bodies) * room + i, *sides = sides_of_event(r, b, i);
    int c;
    r->counts[kind] += 1;
    write_state(r, b->events + i, room, &r->state);
    b->events[(3 + 2 * r->bodies) * room + i] = r->state.phase;
    for (c = 0; c < r->bodies; c++)
        before[c * room] = v[c];
    before[r->bodies * room] = w;
    for (c = 0; c < r->switches; c++)
        sides[c * room] = c < r->mode->side_count ? r->mode->sides[c] : 0.0;
    b->event_codes[i] = (signed char)kind;
    b->event_codes[room + i] = (signed char)part;
    write_codes(r, b->event_codes + 2 * room + i, room, 1);
}

/* Add to the sides that the events from number `first` on tell the zeros at which the mode of now begins: ZERO_UNIT for each order of one
 * at the lower end of a side, and less by as much for one at the upper end.
 */
void record_zeros(const Run *r, Buffers *b, long first)
{
    const Mode *m = r->mode;
    int k;
    for (; r->switches > 0 && first < b->event_count; first++) {
        Real *sides = sides_of_event(r, b, first);
        for (k = 0; k < m->event_count; k++) {
            const Event *e = &m->events[k];
            const double zero = e->kind == SWITCH && e->part < r->switches ? ZERO_UNIT * r->known[e->key] : 0.0;
            if (zero > 0)
                sides[e->part * b->event_room] += m->terms[e->first].coefficient > 0 ? zero : -zero;
        }
    }
}

/* The first sample may be where the closed form was evaluated last. */
static void sample_closed_form(Run *r, const Real *times, const Real *tau, int count, Real *row, long room)
{
    const int here = tau[0] == r->closed_form.tau, n = r->bodies;
    Real X[TIMES_AT_ONCE], V[TIMES_AT_ONCE];
    int i, c;
    if (here) {
        flow_state(r, times[0], &r->scratch);
        write_state(r, row, room, &r->scratch);
    }
    if (count == here)
        return;
    closed_form_many(r, tau + here, count - here);
    closed_form_base(r, X, V);
    for (c = 0; c < n; c++)
        closed_form_body(r, c, X, V, row + here + (1 + 2 * c) * room, row + here + (2 + 2 * c) * room);
    for (i = here; i < count; i++) {
        row[i] = times[i];
        row[i + (1 + 2 * n) * room] = row[i + (2 + 2 * n) * room] = 0.0;
    }
}

static void sample_at(Run *r, Buffers *b, const Real *times, int count)
{
    Real tau[TIMES_AT_ONCE], *row = b->samples + b->sample_count;
    int i;
    for (i = 0; i < count; i++)
        tau[i] = times[i] - r->t0;
    if (r->closed) {
        sample_closed_form(r, times, tau, count, row, b->sample_room);
    } else {
        memcpy(row, times, sizeof(Real) * (size_t)count);
        taylor_samples(r, tau, count, row, b->sample_room);
    }
    write_codes(r, b->sample_modes + b->sample_count, b->sample_room, count);
    b->sample_count += count;
    r->next_sample += count;
}

/* The state at the time from which samples are recorded, where this stretch is the first that reaches it. */
void record_begin(Run *r)
{
    if (r->at_begin.t < 0 && r->samples_from >= r->state.t && r->pending_end >= r->samples_from)
        flow_state(r, r->samples_from, &r->at_begin);
}

/* Samples in [now, end), or up to and including the end of the run; 0 when the buffer is full before that. */
int record_samples(Run *r, Buffers *b)
{
    const Real end = r->pending_end;
    const int last = end >= r->t_end;
    const double last_time = (double)end;
    Real times[TIMES_AT_ONCE], t = sample_time(r, r->next_sample);
    while (t < end || (last && t <= last_time)) {
        long space = b->sample_room - b->sample_count;
        int count = 0;
        while (count < TIMES_AT_ONCE && count < space && (t < end || (last && t <= last_time))) {
            times[count++] = t;
            t = sample_time(r, r->next_sample + count);
        }
        if (count == 0)
            return 0;
        sample_at(r, b, times, count);
    }
    return 1;
}
