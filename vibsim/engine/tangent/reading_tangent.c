/* The tangent bundle from packed numbers, in the order in which vibsim/engine/tangent/packing_tangent.py writes them. */
#include <stdlib.h>
#include <string.h>

#include "modes.h"
#include "tangent.h"

static int *read_indices(Reader *in, int count, int high)
{
    int *values = room(in, count, sizeof(int)), i;
    for (i = 0; i < count && !in->short_of; i++)
        values[i] = read_index(in, 0, high);
    return values;
}

/* A second flow, for expansions within a step. */
static void alloc_spare(const Run *r, TaylorTangent *of, Reader *in)
{
    size_t row = 2 * ((size_t)r->bodies + 3), columns = (size_t)r->columns, i;
    Taylor *f = &of->spare;
    *f = r->taylor;
    f->tapes.series = f->base_tapes.series = NULL;
    f->tapes.values = f->base_tapes.values = NULL;
    f->tapes.ops = f->base_tapes.ops = f->tapes.tape = f->base_tapes.tape = f->tapes.latest = 0;
    f->table = room(in, (SERIES + 1) * row, sizeof(Real));
    f->sine = room(in, 4 * (size_t)SERIES, sizeof(Real));
    f->load = room(in, columns * SERIES, sizeof(Real));
    f->loaded_on = room(in, columns, sizeof(Real *));
#ifdef FIXED_SERIES
    f->fixed = fixed_table_new(SERIES, row); /* the digits of the rotor are of one expansion after the other */
    in->short_of = in->short_of || !f->fixed;
#endif
    if (in->short_of)
        return;
    f->cosine = f->sine + SERIES;
    f->w_back = f->cosine + SERIES;
    f->a1_back = f->w_back + SERIES;
    f->values = f->table + SERIES * row;
    f->checked = NULL;
    for (i = 0; i < columns; i++)
        f->loaded_on[i] = r->taylor.loaded_on[i] ? f->load + i * SERIES : NULL;
}

/* What rotors on bodies need, and a second set of their series. */
static void alloc_rotors(const Run *r, TaylorTangent *of, Reader *in)
{
    const size_t count = (size_t)r->rotors.count;
    Rotors *o = &of->spare_rotors;
    *o = r->rotors;
    o->sine = room(in, 6 * count * TAPE_WIDTH, sizeof(Real));
    o->mass = room(in, 5 * count, sizeof(Real));
    o->leaders = room(in, count + 1, sizeof(int));
    of->pushed = room(in, TANGENT_GROUP * count * SERIES, sizeof *of->pushed);
    of->torques = room(in, count, sizeof *of->torques);
    if (in->short_of)
        return;
    place_rotors(o);
    of->turning = series_along(o->speed, o->count);
    of->pull = series_along(of->turning, o->count);
}

static void alloc_all(const Run *r, Tangent *b, Reader *in)
{
    size_t count = (size_t)b->count, size = (size_t)b->size, stride = (size_t)b->stride, columns = (size_t)r->columns;
    size_t coordinates = 2 * columns;
    b->columns = room(in, 2 * count, sizeof(int));
    b->lost = room(in, count, sizeof(int));
    b->vectors = room(in, 2 * size * stride, sizeof(Real));
    b->sums = room(in, 2 * count, sizeof(Real));
    b->rows = room(in, (SPANS + 1) * (1 + count), sizeof(Real));
    b->fitted = room(in, (count + size + columns + 1) * size, sizeof(Real));
    b->q = room(in, (2 * coordinates + 2) * stride, sizeof(Real));
    b->accelerations = room(in, 3 * columns + size, sizeof(Real));
    b->moving = room(in, coordinates, sizeof(Moving));
    b->taylor.series = room(in, TANGENT_GROUP * (2 * columns + 1) * SERIES, sizeof *b->taylor.series);
    b->taylor.joint = room(in, SERIES, sizeof *b->taylor.joint);
    b->taylor.force = room(in, 2 * columns, sizeof *b->taylor.force);
    b->seat = room(in, columns, sizeof(int));
    b->tangencies.fastest = room(in, 3 * (size_t)b->stop_count, sizeof(Real));
    if (in->short_of)
        return;
    b->tangencies.since = b->tangencies.fastest + b->stop_count;
    b->tangencies.struck = b->tangencies.since + b->stop_count;
    b->over_columns = b->columns + count;
    b->over = b->sums + count;
    b->moved = b->vectors + size * stride;
    b->candidates = b->fitted + count * size;
    b->vector = b->candidates + (size + columns) * size;
    b->u = b->q + coordinates * stride;
    b->line = b->u + coordinates * stride;
    b->zeros = b->line + stride;
    b->other_accelerations = b->accelerations + columns;
    b->force = b->other_accelerations + columns;
    b->jump = b->force + columns;
    alloc_spare(r, &b->taylor, in);
    alloc_rotors(r, &b->taylor, in);
}

/* Ends and laws of stops and frictions. */
static void read_parts(const Run *r, Tangent *b, Reader *in)
{
    int last = r->columns - 1, i;
    b->stops = room(in, b->stop_count, sizeof(StopEnds));
    b->frictions = room(in, b->friction_count, sizeof(FrictionEnds));
    for (i = 0; i < b->stop_count && !in->short_of; i++) {
        b->stops[i].P = read_index(in, 0, last);
        b->stops[i].Q = read_index(in, 0, last);
        b->stops[i].c = read_double(in);
    }
    for (i = 0; i < b->friction_count && !in->short_of; i++) {
        b->frictions[i].P = read_index(in, 0, last);
        b->frictions[i].Q = read_index(in, 0, last);
        b->frictions[i].forward = read_double(in);
        b->frictions[i].backward = read_double(in);
    }
}

static int read_bundle(Run *r, Tangent *b, Reader *in)
{
    int i, k;
    b->size = 2 * r->bodies + 2 * r->has_motor;
    b->given = read_index(in, 0, 1);
    b->count = read_index(in, 1, 1000000);
    b->stop_count = read_index(in, 0, r->parts);
    b->friction_count = read_index(in, 0, r->parts - b->stop_count);
    b->component_count = read_index(in, b->given ? 1 : b->count, b->size);
    b->shift_count = read_index(in, 0, r->bodies);
    b->reference_count = read_index(in, 0, r->bodies);
    if (in->short_of || (!b->given && b->count > b->component_count) || (b->given && b->count > in->double_count / b->size))
        return 0;
    b->stride = b->count + b->count % 2;
    b->complete = !b->given && b->count == b->component_count;
    b->components = read_indices(in, b->component_count, b->size - 1);
    b->shift_from = read_indices(in, b->shift_count, r->bodies - 1);
    b->shift_to = read_indices(in, b->shift_count, r->bodies - 1);
    b->references = read_indices(in, b->reference_count, r->bodies - 1);
    b->weights = room(in, b->size, sizeof(Real));
    alloc_all(r, b, in);
    read_parts(r, b, in);
    if (in->short_of || !tangent_alloc_formulas(r, b))
        return 0;
    b->begin = read_double(in);
    b->taylor.reach = read_double(in);
    b->tangencies.rate = read_double(in);
    for (k = 0; k < b->size; k++)
        b->weights[k] = read_double(in);
    for (i = 0; b->given && i < b->count; i++)
        for (k = 0; k < b->size; k++)
            b->vectors[k * b->stride + i] = read_double(in);
    tangencies_forget(&b->tangencies);
    return read_through(in);
}

/* Memory for the series along the tapes of the modes met so far; 0 without memory. */
int tangent_alloc_formulas(const Run *r, Tangent *b)
{
    TaylorTangent *of = &b->taylor;
    if (r->slope_entries > of->entry_room) {
        if (!grow((void **)&of->entries, (size_t)of->entry_room, (size_t)r->slope_entries, sizeof(Real)))
            return 0;
        of->entry_room = r->slope_entries;
    }
    return alloc_tapes(&of->spare.tapes, r->taylor.tapes.ops) && alloc_tapes(&of->spare.base_tapes, r->taylor.base_tapes.ops) &&
           alloc_tapes(&of->step, r->slope_ops) && alloc_tapes(&of->here, r->slope_ops);
}

int tangent_read(Run *r, Reader *in)
{
    r->tangent = (Tangent *)zalloc_for(NULL, 1, sizeof(Tangent));
    in->owner = r->tangent;
    return r->tangent && read_bundle(r, r->tangent, in);
}

void tangent_free(Tangent *b)
{
    if (!b)
        return;
    free_tapes(&b->taylor.spare.tapes);
    free_tapes(&b->taylor.spare.base_tapes);
    free_tapes(&b->taylor.step);
    free_tapes(&b->taylor.here);
    free(b->taylor.entries);
#ifdef FIXED_SERIES
    fixed_table_free(b->taylor.spare.fixed);
#endif
    free_owner(b);
}
