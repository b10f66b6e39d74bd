/* Zeros too flat for the closed form: stretches at whose start more derivatives of an event function are zero than it takes, go by
 * Taylor series. At the end of a chain whose other end is driven every body between makes two more derivatives zero. In Taylor
 * series they are exactly zero; in modal coordinates rounding stands in for them.
 */
#include <stddef.h>

#include "engine.h"

/* x_P - x_Q of two columns that move alike; whether they do: not so the base, column n + 1. */
static int still_distance(const Run *r, const State *s, int P, int Q, Real *apart)
{
    const int n = r->bodies;
    if (P > n || Q > n || (P < n ? s->v[P] : 0.0) != (Q < n ? s->v[Q] : 0.0))
        return 0;
    *apart = (P < n ? s->x[P] : 0.0) - (Q < n ? s->x[Q] : 0.0);
    return 1;
}

/* The force of a coupling whose ends move alike; whether they do. */
static int still_force(const Run *r, const Coupling *one, const State *s, Real *force)
{
    Real apart;
    if (!still_distance(r, s, one->P, one->Q, &apart))
        return 0;
    *force = one->k * apart + one->offset;
    return 1;
}

/* Whether no force acts on a group, nor begins to. */
static int is_left_alone(const Run *r, int leader, const State *s)
{
    const Mode *m = r->mode;
    Real force;
    int i;
    if (leader >= r->bodies)
        return leader == r->bodies;
    for (i = 0; i < r->force_count; i++)
        if (m->leader[r->forces[i].on] == leader)
            return 0;
    for (i = 0; i < m->constant_count; i++)
        if (m->leader[m->constant_columns[i]] == leader)
            return 0;
    for (i = 0; i < m->coupling_count; i++) {
        const Coupling *one = &m->couplings[i];
        if ((m->leader[one->P] == leader || m->leader[one->Q] == leader) && (!still_force(r, one, s, &force) || force != 0))
            return 0;
    }
    return 1;
}

/* Whether an event function is zero because all that it is made of stands still. */
static int rests_at_zero(const Run *r, const Event *e, const State *s)
{
    Real total = 0.0;
    int i;
    for (i = 0; i < e->terms; i++) {
        const Term *t = &r->mode->terms[e->first + i];
        Real value;
        switch (t->kind) {
        case COUPLING:
            if (!still_force(r, &r->mode->couplings[t->P], s, &value))
                return 0;
            break;
        case DIFFERENCE:
            if (!still_distance(r, s, t->P, t->Q, &value))
                return 0;
            break;
        case ACCELERATION:
            if (!is_left_alone(r, r->mode->leader[t->P], s))
                return 0;
            continue;
        default:
            return 0;
        }
        total = total + t->coefficient * value;
    }
    return e->terms > 0 && total + e->constant == 0;
}

/* Whether an event function of a mode with a closed form may leave zero with more zero derivatives than that takes. */
int leaves_flat(const Run *r, const State *state)
{
    const Mode *m = r->mode;
    int i;
    for (i = 0; closed_form_dimension(r) > FLAT_ORDER && i < m->event_count; i++)
        if (r->known[m->events[i].key] >= FLAT_ORDER || rests_at_zero(r, &m->events[i], state))
            return 1;
    return 0;
}
