/* Ledgers and the integrals of modes from packed numbers, in the order in which vibsim/engine/ledger_integrals.py writes them. */
#include <stdlib.h>
#include <string.h>

#include "modes.h"

/* Memory for the entries and what is read at the nodes; 0 without memory or where the numbers are no ledger. */
int ledger_read(Run *r, Reader *in)
{
    Ledger *l = &r->ledger;
    int i;
    l->count = read_index(in, 0, MOST);
    l->jump_count = read_index(in, 0, r->parts);
    in->owner = r->masses;
    l->entries = room(in, l->count, sizeof(Real));
    l->open = room(in, l->count, sizeof(Real));
    l->jumps = room(in, l->jump_count, sizeof(Jump));
    l->nodes.v = room(in, r->columns + r->force_count + 1, sizeof *l->nodes.v);
    if (in->short_of)
        return 0;
    l->nodes.force = l->nodes.v + r->columns;
    for (i = 0; i < l->jump_count; i++) {
        Jump *j = &l->jumps[i];
        j->stop = read_index(in, 0, r->parts - 1);
        j->entry = read_index(in, 0, l->count - 1);
        j->P = read_index(in, 0, r->columns - 1);
        j->Q = read_index(in, 0, r->columns - 1);
        j->sense = read_index(in, -1, 1);
        j->gap = read_double(in);
        j->k = read_double(in);
    }
    l->wanted = 1;
    return read_through(in);
}

/* Room for the series and values of so many functions; 0 without memory. */
static int alloc_functions(Nodes *at, int count)
{
    const size_t before = (size_t)at->function_room, after = (size_t)count;
    if (count <= at->function_room)
        return 1;
    if (!grow((void **)&at->series, before, after, SERIES * sizeof(Real)) || !grow((void **)&at->function, before, after, sizeof *at->function) ||
        !grow((void **)&at->lengths, before, after, sizeof(int)))
        return 0;
    at->function_room = count;
    return 1;
}

/* The functions of the rows that integrals read; their terms follow those of the event functions, from number `first` on. */
static void read_functions(Run *r, Mode *m, Reader *in, int first)
{
    int i, k;
    for (i = 0; i < m->integrals.function_count; i++) {
        Event *e = &m->integrals.functions[i];
        int count = read_index(in, 0, MOST);
        e->kind = HOLD;
        e->first = first;
        e->constant = read_double(in);
        for (k = 0; k < count && !in->short_of; k++) {
            Term *t = &m->terms[first++];
            t->kind = read_index(in, COUPLING, FORMULA);
            t->P = read_index(in, 0, named_by(r, m, t->kind) - 1);
            t->Q = t->pair = -1;
            t->coefficient = read_double(in);
        }
        e->terms = count;
        if (!in->short_of)
            function_prepare(m, e);
    }
}

/* The integrals of mode `m`; 0 without memory, or where the numbers are no integrals (look at the reader). */
int integrals_read(Run *r, Mode *m, Reader *in)
{
    LedgerIntegrals *to = &m->integrals;
    const int terms = m->term_count;
    int more, i;
    in->owner = m;
    to->count = read_index(in, 0, MOST);
    to->function_count = read_index(in, 0, MOST);
    more = read_index(in, 0, MOST);
    to->integrals = room(in, to->count, sizeof(LedgerIntegral));
    to->functions = room(in, to->function_count, sizeof(Event));
    to->reads = room(in, r->columns, sizeof(int));
    if (in->short_of || !grow((void **)&m->terms, (size_t)terms, (size_t)(terms + more + 1), sizeof(Term)) || !alloc_functions(&r->ledger.nodes, to->function_count))
        return 0;
    for (i = 0; i < to->count; i++) {
        LedgerIntegral *one = &to->integrals[i];
        int of_force;
        one->kind = read_index(in, SQUARE, RUB);
        in->short_of = in->short_of || (one->kind == TORQUE && !r->has_motor);
        of_force = one->kind == WORK || one->kind == IMPULSE;
        one->entry = read_index(in, 0, r->ledger.count - 1);
        one->P = read_index(in, one->kind == FUNCTION || one->kind == IMPULSE || one->kind == TORQUE ? -1 : 0, r->columns - 1);
        one->Q = read_index(in, one->kind == SQUARE || one->kind == SLIP || one->kind == RUB ? 0 : -1, r->columns - 1);
        one->source = read_index(in, of_force || one->kind == FUNCTION || one->kind == RUB ? 0 : -1, (of_force ? r->force_count : to->function_count) - 1);
        one->factor = read_double(in);
        one->drift = read_double(in);
        if (one->P >= 0)
            to->reads[one->P] = 1;
        if (one->Q >= 0)
            to->reads[one->Q] = 1;
        to->forces = to->forces || of_force;
        to->spins = to->spins || one->kind == TORQUE;
    }
    read_functions(r, m, in, terms);
    return read_through(in);
}

void ledger_free(Ledger *l)
{
    free(l->nodes.series);
    free(l->nodes.function);
    free(l->nodes.lengths);
}
