/* The stroboscopic section: the exact state at the end of every period of what drives a scene, read off the flow as it passes.
 *
 * A period ends at t = k T of forces and base, and where the angle of a motor, or of the rotor that turns a scene, passes 2 pi k
 * forwards. Reading it changes no trajectory.
 *
 * The extremes of a period end there too.
 */
#include "engine.h"
#include "numbers.h"

#define ITERATIONS 60 /* of a passage: Newton steps, safeguarded by bisection */
#define LAST_PERIOD 9007199254740992.0 /* 2^53: behind it whole numbers of periods are no doubles */

/* End of the next period [s], a whole number of turns by a frequency of two doubles, cycles + cycles_lo: to first order in the
 * second.
 */
static Real period_end(const Section *s)
{
    Real t = s->next * s->turns / s->cycles;
    return t - t * (s->cycles_lo / s->cycles);
}

/* The angle of a rotor that lies behind the turn in which the stretch begins. */
static Real whole_turns(const Run *r)
{
    Real turns = floor(r->state.x[r->section.rotor - 1] / TURN);
    return whole_turns_angle(turns);
}

/* The angle of motor or rotor, counted in the turn in which the stretch begins. */
static Real angle_of(const Run *r, const State *s)
{
    if (r->section.rotor > 0)
        return s->x[r->section.rotor - 1] - whole_turns(r);
    return s->phase + (s->turns - r->state.turns) * TURN;
}

static Real angle_at(Run *r, Real t)
{
    flow_state(r, t, &r->scratch);
    return angle_of(r, &r->scratch);
}

/* Time in the stretch at which the angle passes `target` forwards: Newton steps, and bisection where they leave the interval. */
static Real passage(Run *r, Real end, Real target)
{
    Real low = r->state.t, high = end, t = low + (high - low) / 2;
    int i;
    for (i = 0; i < ITERATIONS; i++) {
        Real error = angle_at(r, t) - target, speed, ahead;
        if (error < 0)
            low = t;
        else
            high = t;
        speed = r->section.rotor > 0 ? r->scratch.v[r->section.rotor - 1] : r->scratch.w;
        ahead = speed > 0 ? t - error / speed : low;
        if (!(low < ahead && ahead < high))
            ahead = low + (high - low) / 2;
        if (ahead == t || !(low < ahead && ahead < high))
            return high;
        t = ahead;
    }
    return high;
}

/* Write the state at t as a point of the section, with the extremes of the period that ends there. */
static void keep(Run *r, Buffers *b, Real t)
{
    Real *row = b->section + b->section_count++;
    flow_state(r, t, &r->scratch);
    write_state(r, row, b->section_room, &r->scratch);
    extremes_close(r, row + (3 + 2 * r->bodies) * b->section_room, b->section_room);
}

/* Begin with the first period that ends behind the state of now and not before `section_from`; with a rotor the turn to begin with
 * is that of the stretch.
 */
void section_start(Run *r)
{
    Section *s = &r->section;
    const Real from = fmax(r->state.t, r->section_from);
    s->next = s->rotor > 0 ? 0 : 1;
    if (s->turns > 0 && from > 0) {
        s->next = floor(from * s->cycles / s->turns);
        s->next = s->next > 1 ? s->next : 1;
        while ((period_end(s) <= r->state.t || period_end(s) < from) && s->next < LAST_PERIOD)
            s->next += 1;
    }
}

/* The angle at the end of the stretch. */
static Real last_angle(Run *r, Real end)
{
    run_arrive(r);
    if (r->next.t == end && r->pending_tau == end - r->t0)
        return angle_of(r, &r->next);
    return angle_at(r, end); /* the state was taken at the very instant of an impact */
}

/* Keep the point at which the angle passes `target`; the extremes of the turn end there. */
static void keep_turn(Run *r, Buffers *b, Real end, Real target)
{
    Real t = passage(r, end, target);
    extremes_until(r, t, 0);
    keep(r, b, t);
}

/* Of a stretch without bound of its turns: `next` is the turn to go on with where the buffer was full. */
static int gather_turns_of_rotor(Run *r, Buffers *b, Real end)
{
    Section *s = &r->section;
    Real first = angle_of(r, &r->state), last = last_angle(r, end);
    for (; whole_turns_angle(s->next) <= last; s->next += 1) {
        Real target = whole_turns_angle(s->next);
        if (first < target) {
            if (b->section_count >= b->section_room)
                return 0;
            keep_turn(r, b, end, target);
        }
    }
    s->next = 0;
    return 1;
}

/* Points of the section within the stretch in hand, behind its start and up to its end; 0 where the buffer is full before. Of a
 * motor at most two whole turns are passed in one stretch: those at 0 and 2 pi, counted in the turn of its start.
 */
int section_gather(Run *r, Buffers *b, Real end)
{
    Section *s = &r->section;
    if (b->section_room == 0 || end < r->section_from)
        return 1;
    if (r->has_motor) {
        Real first = r->state.phase, last;
        int turn;
        if (b->section_count + 2 > b->section_room)
            return 0;
        last = last_angle(r, end);
        for (turn = 0; turn < 2; turn++) {
            Real target = whole_turns_angle(turn);
            if (first < target && target <= last)
                keep_turn(r, b, end, target);
        }
        return 1;
    }
    if (s->rotor > 0)
        return gather_turns_of_rotor(r, b, end);
    for (; s->turns > 0 && period_end(s) <= end && s->next < LAST_PERIOD; s->next += 1) {
        if (b->section_count >= b->section_room || !extremes_until(r, period_end(s), 1))
            return 0;
        keep(r, b, period_end(s));
    }
    return 1;
}
