/* How far the close measure of rounding may at most be above a few times the plain one (see rounding.c).
 *
 * Whatever the time, a release C swings by 3 at the most, an impulse response S by 4 / w0 and a harmonic response by (5 + 4 omega
 * / w0) / |Z|, and their rates by some times more, the sum of all rates. So the bound is a sum over what the segment starts from,
 * of which each mode knows the weights.
 */
#include "engine.h"

#define FASTER 4 /* times the sum of all rates: how much further a rate swings */

/* The sum of one and factor times another. */
static Reach plus(Reach one, Real factor, Reach other)
{
    one.place = one.place + factor * other.place;
    one.speed = one.speed + factor * other.speed;
    one.rest = one.rest + factor * other.rest;
    return one;
}

/* Bound of the terms of H where it is a quotient. */
static Real response_reach(const Oscillator *o, Real longest)
{
    return (5 + o->omega * longest) * (fabs(o->inverse_r) + fabs(o->inverse_i));
}

/* The reaches of a coordinate, its rate and its acceleration. Where its own terms cancel, the plain measure may be as small as it
 * likes while the coordinate grows without end: of a free mass with its velocity, under a load that is a sum, and in resonance.
 * There the reach is endless: nothing is told.
 */
static void reaches_of(const Modal *modal, const Coordinate *c, Terms *of)
{
    const Oscillator *o = &c->oscillator;
    const int held = o->w0 > 0, wanders = c->is_free && c->sources > 1;
    Real start = 0.0, shifts = 0.0, longest = 0.0, driven = 0.0, terms = 0.0, pace = o->w0 + 2 * o->a, steady = 4 * o->per_b;
    Reach *q = &of->reaches[0], *u = &of->reaches[1], *a = &of->reaches[2];
    int cancels = 0, resonates = 0, i;
    for (i = 0; i < c->sources; i++)
        start = start + fabs(modal->sources[c->first_source + i].weight);
    for (i = 0; i < c->shifts; i++) {
        const Shift *shift = &modal->shifts[c->first_shift + i];
        shifts = shifts + fabs(shift->factor) * shift->count;
    }
    if (!c->is_free)
        longest = held ? 4 / o->w0 : 1 / (2 * o->a);
    for (i = 0; i < c->drive_count; i++) {
        const Drive *drive = &c->drives[i];
        pace = pace + drive->oscillator.omega;
        driven = driven + of->drives[i] * response_reach(&drive->oscillator, longest);
        terms = terms + of->drives[i];
        cancels = cancels || of->drives[i] > 2 * drive->size;
        resonates = resonates || drive->oscillator.zz == 0;
    }
    q->place = start + shifts * steady;
    q->speed = start * longest;
    q->rest = of->load * steady + driven;
    u->place = u->rest = a->speed = 0.0;
    u->speed = 9 * start;
    *u = plus(*u, FASTER * pace, *q);
    a->place = shifts;
    a->rest = of->load + terms;
    *a = plus(*a, FASTER * pace, *u);
    if (cancels || (!held && (wanders || of->load > 2 * fabs(c->load))))
        q->rest = UNHURRIED;
    if (cancels)
        u->rest = UNHURRIED;
    if (cancels || resonates)
        a->rest = UNHURRIED;
}

/* Of what a place has of the coordinates, of their rates (order 1) or accelerations (2). */
static Reach shares_reach(const Modal *modal, const Place *p, int order)
{
    Reach total = {0.0, 0.0, 0.0};
    int i;
    for (i = 0; i < p->shares; i++)
        total = plus(total, fabs(p->share[i].share), modal->terms[p->share[i].m].reaches[order]);
    return total;
}

/* Of a term of an event function, without its coefficient. */
static Reach term_reach(const Mode *m, const Term *t)
{
    const Modal *modal = m->modal;
    Reach total = {0.0, 0.0, 0.0};
    switch (t->kind) {
    case DIFFERENCE:
    case RATE:
        return shares_reach(modal, &modal->pairs[t->pair], t->kind == RATE);
    case COUPLING: {
        const Coupling *c = &m->couplings[t->P];
        total = plus(total, c->k, shares_reach(modal, &modal->pairs[c->pair], 0));
        return plus(total, c->c, shares_reach(modal, &modal->pairs[c->pair], 1));
    }
    case ACCELERATION:
        return shares_reach(modal, &modal->places[t->P], 2);
    default:
        return total;
    }
}

/* Of the coordinates and event functions of a mode. */
void reaches_set(Mode *m)
{
    int i, k;
    for (i = 0; i < m->modal->count; i++)
        reaches_of(m->modal, &m->modal->coordinates[i], &m->modal->terms[i]);
    for (i = 0; i < m->event_count; i++) {
        const Event *e = &m->events[i];
        Reach total = {0.0, 0.0, 0.0};
        for (k = 0; k < e->terms; k++)
            total = plus(total, fabs(m->terms[e->first + k].coefficient), term_reach(m, &m->terms[e->first + k]));
        m->modal->reaches[i] = total;
    }
}
