/* What impacts on rigid stops are told by: read as Python writes it, kept and freed. */
#include <stdlib.h>
#include <string.h>

#include "modes.h"
#include "zalloc.h"

static int alloc_impacts(Run *r, int stops, int frictions, int bounds)
{
    Impacts *b = &r->impacts;
    impacts_free(b);
    b->stops = zalloc((size_t)stops + 1, sizeof(RigidStop));
    b->frictions = zalloc((size_t)frictions + 1, sizeof(Rubbing));
    b->bounds = zalloc((size_t)bounds + 1, sizeof(Bound));
    b->codes = zalloc((size_t)(r->parts + 2 * (frictions + 1)), sizeof(int));
    if (!b->stops || !b->frictions || !b->bounds || !b->codes)
        return 0;
    b->kinds = b->codes + r->parts;
    b->parts = b->kinds + frictions + 1;
    return 1;
}

/* The numbers in which vibsim/engine/ledger_integrals.py writes them; 0 without memory or where they are none. */
int impacts_read(Run *r, Reader *in)
{
    Impacts *b = &r->impacts;
    int stops = read_index(in, 0, r->parts), frictions = read_index(in, 0, r->parts - r->clearances - stops);
    int bounds = read_index(in, 0, r->parts - stops - frictions), i;
    if (in->short_of || !alloc_impacts(r, stops, frictions, bounds))
        return 0;
    b->early = read_index(in, 0, 1);
    for (i = 0; i < stops; i++) {
        RigidStop *s = &b->stops[i];
        s->stop = read_index(in, 0, r->parts - 1);
        s->P = read_index(in, 0, r->columns - 1);
        s->Q = read_index(in, 0, r->columns - 1);
        s->sense = read_index(in, -1, 1);
        s->loss = read_index(in, -1, r->ledger.count - 1);
        s->work = read_index(in, -1, r->ledger.count - 1);
        s->impulse = read_index(in, -1, r->ledger.count - 1);
        s->gap = read_double(in);
        s->e = read_double(in);
    }
    for (i = 0; i < frictions; i++) {
        b->frictions[i].P = read_index(in, 0, r->columns - 1);
        b->frictions[i].Q = read_index(in, 0, r->columns - 1);
        b->frictions[i].belt = read_double(in);
    }
    for (i = 0; i < bounds; i++) {
        b->bounds[i].P = read_index(in, 0, r->columns - 1);
        b->bounds[i].Q = read_index(in, 0, r->columns - 1);
        b->bounds[i].sense = read_index(in, -1, 1);
        b->bounds[i].gap = read_double(in);
    }
    b->stop_count = stops;
    b->friction_count = frictions;
    b->bound_count = bounds;
    return read_through(in);
}

void impacts_free(Impacts *b)
{
    free(b->stops);
    free(b->frictions);
    free(b->bounds);
    free(b->codes);
    memset(b, 0, sizeof *b);
}
