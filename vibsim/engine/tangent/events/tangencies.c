/* Events that are crossed almost tangentially; vibsim/engine/tangent/tangencies.py says what they are, and judges those that
 * Python decides.
 */
#include "columns.h"
#include "tangent.h"

#define CLOSE 1e-6 /* share below which a crossing counts as a tangency: a rate of 1/1000 of the largest */

void tangencies_forget(Tangencies *near)
{
    near->count = 0;
    near->closest = 1.0;
    near->closest_time = 0.0;
    near->undefined = 0;
    near->undefined_time = 0.0;
}

/* Learn of an event at t that has no derivative. */
void tangencies_refuse(Tangencies *near, Real t)
{
    if (near->undefined == 0)
        near->undefined_time = t;
    near->undefined++;
}

/* x_P - x_Q and v_P - v_Q of a stop. */
static void between(const Run *r, const Mode *m, const StopEnds *stop, const State *state, Real *distance, Real *rate)
{
    Real X, V;
    base_motion_at(r, m, state->t, &X, &V);
    *distance = column_value(r, state->x, stop->P, X) - column_value(r, state->x, stop->Q, X);
    *rate = column_value(r, state->v, stop->P, V) - column_value(r, state->v, stop->Q, V);
}

/* Learn how fast the ends of the stops move against each other. */
void tangencies_pass_by(Run *r, const State *state)
{
    Tangencies *near = &r->tangent->tangencies;
    int i;
    for (i = 0; i < r->tangent->stop_count; i++) {
        Real distance, rate, speed;
        between(r, r->mode, &r->tangent->stops[i], state, &distance, &rate);
        speed = fabs(rate) + near->rate * fabs(distance);
        near->fastest[i] = speed > near->fastest[i] ? speed : near->fastest[i];
        speed = fabs(rate) + near->rate * fabs(distance - near->struck[i]);
        near->since[i] = speed > near->since[i] ? speed : near->since[i];
    }
}

/* Learn of an impact on stop number i that led to a state. */
void tangencies_struck_at(Run *r, int i, const State *state)
{
    Tangencies *near = &r->tangent->tangencies;
    Real rate;
    between(r, r->mode, &r->tangent->stops[i], state, &near->struck[i], &rate);
    near->since[i] = fabs(rate);
}

/* Deceleration of a sliding that ends, over the largest with which it can end in sticking. */
static Real stopping_share(const Run *r, const Event *event, const State *state, const Mode *before)
{
    Tangent *b = r->tangent;
    Real largest;
    int c;
    reversal_accelerations(r, before, state, event->part, b->accelerations);
    for (c = 0; c < r->bodies; c++) {
        b->vector[c] = 0.0;
        b->vector[r->bodies + c] = b->accelerations[c];
    }
    largest = gradient(r, before, event, b->vector, 1);
    return largest != 0 ? -event_rate_at(r, state, before, event) / largest : 1.0;
}

/* Judge an event by the square of its rate over that of the whole motion: contact of a stop by the fastest motion of its ends, the
 * end of sliding by the largest deceleration with which it can end in sticking.
 */
void tangencies_judge(Run *r, const Event *event, const State *state, const Mode *before, const Mode *after)
{
    Tangent *b = r->tangent;
    Tangencies *near = &b->tangencies;
    int i = event->part;
    Real share, distance;
    if (event->kind == GAP && near->fastest[i] > 0 && before->codes[i] != after->codes[i]) {
        between(r, before, &b->stops[i], state, &distance, &share);
        share = share / near->fastest[i];
    } else if (event->kind == SLIDE && after->codes[b->stop_count + i] == 0) {
        share = stopping_share(r, event, state, before);
    } else {
        return;
    }
    share = share * share;
    tangencies_note(near, share < CLOSE, share, state->t);
}

void tangencies_note(Tangencies *near, int count, Real share, Real t)
{
    near->count += count;
    if (share < near->closest) {
        near->closest = share;
        near->closest_time = t;
    }
}
