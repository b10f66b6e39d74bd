/* In place of the files in tangent/: a run of many digits carries no disturbances, and is never told of any. */
#include "modes.h"
#include "tangent.h"

void tangent_open(Run *) {}
void tangent_begin_stretch(Run *) {}
void tangent_cross(Run *, int, const Mode *, const Mode *) {}
void tangent_free(struct Tangent *) {}
void seats_of(const Run *, const Mode *) {}

int tangent_gather(Run *)
{
    return 1;
}

Real tangent_worked_to(const Run *r)
{
    return r->state.t;
}

int tangent_read(Run *, Reader *)
{
    return 0;
}

int tangent_alloc_falls(struct Tangent *, int)
{
    return 1;
}

int tangent_alloc_formulas(const Run *, struct Tangent *)
{
    return 1;
}
