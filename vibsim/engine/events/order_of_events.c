/* Whether the order of two events is a question whose functions have one value and one slope: rounding does not tell it then, and the
 * first in the list of events is taken first.
 */
#include "engine.h"

#define MOST_BODIES 64 /* of a scene whose bodies are told apart */

/* Whether a column is at rest in the mode of now: the ground, what is tied to it, or a base that a formula has not set into motion. */
static int rests(const Run *r, int column)
{
    const Taylor *f = &r->taylor;
    const int leader = r->mode->leader[column];
    int n;
    if (leader == r->bodies)
        return r->mode->drift[column] == 0;
    if (leader < r->bodies || r->mode->base_values.op_count == 0 || r->mode->drift[column] != 0)
        return 0;
    for (n = 0; n < f->order + 2; n++)
        if (f->table[n * f->stride + f->rates + base_column(r)] != 0)
            return 0;
    return 1;
}

/* Whether two columns have one velocity: they are tied to each other, by no belt that moves, or are both at rest. */
static int move_alike(const Run *r, int one, int other)
{
    const Mode *m = r->mode;
    if (one == other || (rests(r, one) && rests(r, other)))
        return 1;
    return m->leader[one] == m->leader[other] && m->drift[one] == m->drift[other] && m->follower_count == 0;
}

/* Whether two terms of event functions are one, perhaps with their ends named the other way round. */
static int are_one_term(const Run *r, const Term *a, const Term *b)
{
    const int same = a->coefficient == b->coefficient, turned = a->coefficient == -b->coefficient;
    if (a->kind != b->kind)
        return 0;
    if (a->kind == RATE)
        return (same && move_alike(r, a->P, b->P) && move_alike(r, a->Q, b->Q)) ||
               (turned && move_alike(r, a->P, b->Q) && move_alike(r, a->Q, b->P));
    return (same && a->P == b->P && a->Q == b->Q) || (a->kind == DIFFERENCE && turned && a->P == b->Q && a->Q == b->P);
}

/* Whether two event functions are one with two names, which vanish together. */
static int are_one(const Run *r, const Event *one, const Event *other)
{
    const Term *terms = r->mode->terms;
    int i;
    if (one->terms != other->terms || one->constant != other->constant)
        return 0;
    for (i = 0; i < one->terms; i++)
        if (!are_one_term(r, &terms[one->first + i], &terms[other->first + i]))
            return 0;
    return 1;
}

/* Whether an event function has a formula that reads the motion, or one of the time alone if `of_time`. */
static int has_formula(const Mode *m, const Event *e, int of_time)
{
    int i;
    for (i = 0; i < e->terms; i++) {
        const Term *term = &m->terms[e->first + i];
        if (term->kind == FORMULA && (m->tape.ops[m->tape.outputs[term->P]].when <= AHEAD) == of_time)
            return 1;
    }
    return 0;
}

/* Whether what follows an event asks for no other: contact that begins or ends, a limit that is passed, while no friction holds that
 * the jump of a damper's force might overload.
 */
static int only_passes(const Mode *m, const Event *e)
{
    int i;
    if (e->kind != GAP && e->kind != PUSH && e->kind != CLEARANCE)
        return 0;
    for (i = 0; i < m->event_count; i++)
        if (m->events[i].kind == HOLD)
            return 0;
    return 1;
}

/* Put the bodies of two columns in one set; ground and base are in none. */
static void join_sets(const Run *r, int *set, int one, int other)
{
    int c, from;
    if (one < 0 || other < 0 || one >= r->bodies || other >= r->bodies || set[one] == set[other])
        return;
    from = set[other];
    for (c = 0; c < r->bodies; c++)
        if (set[c] == from)
            set[c] = set[one];
}

/* The ends of a term of an event function; NOTHING where it has one alone. */
static void ends_of(const Mode *m, const Term *t, int *P, int *Q)
{
    *P = t->kind == COUPLING ? m->couplings[t->P].P : t->P;
    *Q = t->kind == COUPLING ? m->couplings[t->P].Q : t->kind == DIFFERENCE || t->kind == RATE ? t->Q : NOTHING;
}

/* The set of the bodies that an event function reads; NOTHING where it reads none. */
static int set_of(const Run *r, const int *set, const Event *e)
{
    int P, Q, i;
    for (i = 0; i < e->terms; i++) {
        ends_of(r->mode, &r->mode->terms[e->first + i], &P, &Q);
        if (P >= 0 && P < r->bodies)
            return set[P];
        if (Q >= 0 && Q < r->bodies)
            return set[Q];
    }
    return NOTHING;
}

/* Whether two events are of bodies that no link, stop or friction joins, through others or at once; without formulas. */
static int are_apart(const Run *r, const Event *one, const Event *other)
{
    const Mode *m = r->mode;
    int set[MOST_BODIES], P, Q, i, k;
    if (m->tape.op_count > 0 || r->bodies > MOST_BODIES)
        return 0;
    for (i = 0; i < r->bodies; i++)
        set[i] = i;
    for (i = 0; i < r->bodies; i++)
        join_sets(r, set, m->leader[i], i);
    for (i = 0; i < m->coupling_count; i++)
        join_sets(r, set, m->couplings[i].P, m->couplings[i].Q);
    for (i = 0; i < m->event_count; i++)
        for (k = 0; k < m->events[i].terms; k++) {
            ends_of(m, &m->terms[m->events[i].first + k], &P, &Q);
            join_sets(r, set, P, Q);
        }
    P = set_of(r, set, one);
    Q = set_of(r, set, other);
    return P != NOTHING && Q != NOTHING && P != Q;
}

int order_is_open(const Run *r, const Event *one, const Event *other)
{
    const Mode *m = r->mode;
    if (are_one(r, one, other) || (only_passes(m, one) && only_passes(m, other)))
        return 0;
    if (has_formula(m, one, 0) || has_formula(m, other, 0))
        return has_formula(m, one, 1) || has_formula(m, other, 1);
    return !are_apart(r, one, other);
}
