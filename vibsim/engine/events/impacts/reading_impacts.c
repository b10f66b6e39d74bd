/* What impacts on rigid stops are told by: read as Python writes it. */
#include "modes.h"

/* The numbers in which vibsim/engine/ledger_integrals.py writes them, once or, of as many parts, again; 0 without memory or where they
 * are none.
 */
int impacts_read(Run *r, Reader *in)
{
    Impacts *b = &r->impacts;
    int stops = read_index(in, 0, r->parts), frictions = read_index(in, 0, r->parts - r->clearances - stops);
    int bounds = read_index(in, 0, r->parts - stops - frictions), i;
    if (b->stops && (stops != b->stop_count || frictions != b->friction_count || bounds != b->bound_count))
        return 0;
    in->owner = r->masses;
    if (!b->stops) {
        b->stop_count = stops;
        b->friction_count = frictions;
        b->bound_count = bounds;
        b->frictions = room(in, frictions, sizeof(Rubbing));
        b->bounds = room(in, bounds, sizeof(Bound));
        b->codes = room(in, r->parts, sizeof(int));
        b->kinds = room(in, frictions + 1, sizeof(int));
        b->parts = room(in, frictions + 1, sizeof(int));
        b->stops = room(in, stops, sizeof(RigidStop));
    }
    if (in->short_of)
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
    return read_through(in);
}
