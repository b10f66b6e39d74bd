/* The tangent bundle from packed numbers, in the order in which vibsim/engine/tangent/packing_tangent.py writes them. */
#include <stdlib.h>
#include <string.h>

#include "modes.h"
#include "zalloc.h"
#include "tangent.h"

static int *read_indices(Reader *in, int count, int high)
{
    int *values = zalloc((size_t)count, sizeof(int)), i;
    for (i = 0; values && i < count; i++)
        values[i] = read_index(in, 0, high);
    return values;
}

/* A second flow, for expansions within a step. */
static int alloc_spare(const Run *r, TaylorTangent *of)
{
    size_t row = 2 * ((size_t)r->bodies + 3), columns = (size_t)r->columns, i;
    Taylor *f = &of->spare;
    *f = r->taylor;
    f->tapes.series = f->base_tapes.series = NULL;
    f->tapes.values = f->base_tapes.values = NULL;
    f->tapes.ops = f->base_tapes.ops = f->tapes.tape = f->base_tapes.tape = f->tapes.latest = 0;
    f->table = zalloc((SERIES + 1) * row, sizeof(Real));
    f->sine = zalloc(4 * (size_t)SERIES, sizeof(Real));
    f->load = zalloc(columns * SERIES, sizeof(Real));
    f->loaded_on = zalloc(columns, sizeof(Real *));
#ifdef FIXED_SERIES
    f->fixed = fixed_table_new(SERIES, row); /* the digits of the rotor are of one expansion after the other */
    if (!f->fixed)
        return 0;
#endif
    if (!f->table || !f->sine || !f->load || !f->loaded_on)
        return 0;
    f->cosine = f->sine + SERIES;
    f->w_back = f->cosine + SERIES;
    f->a1_back = f->w_back + SERIES;
    f->values = f->table + SERIES * row;
    f->checked = NULL;
    for (i = 0; i < columns; i++)
        f->loaded_on[i] = r->taylor.loaded_on[i] ? f->load + i * SERIES : NULL;
    return 1;
}

/* What rotors on bodies need, and a second set of their series. */
static int alloc_rotors(const Run *r, TaylorTangent *of)
{
    const size_t count = (size_t)r->rotors.count;
    Rotors *o = &of->spare_rotors;
    *o = r->rotors;
    o->sine = zalloc(6 * count * TAPE_WIDTH, sizeof(Real));
    o->mass = zalloc(5 * count, sizeof(Real));
    o->leaders = zalloc(count + 1, sizeof(int));
    of->pushed = zalloc(TANGENT_GROUP * count * SERIES, sizeof *of->pushed);
    of->torques = zalloc(count, sizeof *of->torques);
    if (!o->sine || !o->mass || !o->leaders || !of->pushed || !of->torques)
        return 0;
    o->cosine = series_along(o->sine, o->count);
    o->acceleration = series_along(o->cosine, o->count);
    o->speed = series_along(o->acceleration, o->count);
    of->turning = series_along(o->speed, o->count);
    of->pull = series_along(of->turning, o->count);
    o->mobility = o->mass + count;
    o->torque = o->mobility + count;
    o->pulled = o->torque + count;
    o->lean = o->pulled + count;
    return 1;
}

static int alloc_all(const Run *r, Tangent *b)
{
    size_t count = (size_t)b->count, size = (size_t)b->size, stride = (size_t)b->stride, columns = (size_t)r->columns;
    size_t coordinates = 2 * columns;
    b->columns = zalloc(2 * count, sizeof(int));
    b->lost = zalloc(count, sizeof(int));
    b->vectors = zalloc(2 * size * stride, sizeof(Real));
    b->sums = zalloc(2 * count, sizeof(Real));
    b->rows = zalloc((SPANS + 1) * (1 + count), sizeof(Real));
    b->fitted = zalloc((count + size + columns + 1) * size, sizeof(Real));
    b->q = zalloc((2 * coordinates + 2) * stride, sizeof(Real));
    b->accelerations = zalloc(3 * columns + size, sizeof(Real));
    b->moving = zalloc(coordinates, sizeof(Moving));
    b->taylor.series = zalloc(TANGENT_GROUP * (2 * columns + 1) * SERIES, sizeof *b->taylor.series);
    b->taylor.joint = zalloc(SERIES, sizeof *b->taylor.joint);
    b->taylor.force = zalloc(2 * columns, sizeof *b->taylor.force);
    b->seat = zalloc(columns, sizeof(int));
    b->tangencies.fastest = zalloc(3 * (size_t)b->stop_count, sizeof(Real));
    if (!b->columns || !b->lost || !b->vectors || !b->sums || !b->rows || !b->fitted || !b->q || !b->accelerations || !b->moving ||
        !b->taylor.series || !b->taylor.joint || !b->taylor.force || !b->seat || !b->tangencies.fastest)
        return 0;
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
    return alloc_spare(r, &b->taylor) && alloc_rotors(r, &b->taylor) && tangent_alloc_formulas(r, b);
}

/* Ends and laws of stops and frictions. */
static int read_parts(const Run *r, Tangent *b, Reader *in)
{
    int last = r->columns - 1, i;
    b->stops = zalloc((size_t)b->stop_count, sizeof(StopEnds));
    b->frictions = zalloc((size_t)b->friction_count, sizeof(FrictionEnds));
    if (!b->stops || !b->frictions)
        return 0;
    for (i = 0; i < b->stop_count; i++) {
        b->stops[i].P = read_index(in, 0, last);
        b->stops[i].Q = read_index(in, 0, last);
        b->stops[i].c = read_double(in);
    }
    for (i = 0; i < b->friction_count; i++) {
        b->frictions[i].P = read_index(in, 0, last);
        b->frictions[i].Q = read_index(in, 0, last);
        b->frictions[i].forward = read_double(in);
        b->frictions[i].backward = read_double(in);
    }
    return 1;
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
    b->weights = zalloc((size_t)b->size, sizeof(Real));
    if (!b->components || !b->shift_from || !b->shift_to || !b->references || !b->weights || !alloc_all(r, b) ||
        !read_parts(r, b, in))
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
        Real *more = regrown(of->entries, sizeof(Real) * (size_t)r->slope_entries);
        if (!more)
            return 0;
        of->entries = more;
        of->entry_room = r->slope_entries;
    }
    return alloc_tapes(&of->spare.tapes, r->taylor.tapes.ops) && alloc_tapes(&of->spare.base_tapes, r->taylor.base_tapes.ops) &&
           alloc_tapes(&of->step, r->slope_ops) && alloc_tapes(&of->here, r->slope_ops);
}

int tangent_read(Run *r, Reader *in)
{
    r->tangent = zalloc(1, sizeof(Tangent));
    return r->tangent && read_bundle(r, r->tangent, in);
}

void tangent_free(Tangent *b)
{
    if (!b)
        return;
    free(b->components);
    free(b->shift_from);
    free(b->shift_to);
    free(b->references);
    free(b->weights);
    free(b->stops);
    free(b->frictions);
    free(b->columns);
    free(b->lost);
    free(b->vectors);
    free(b->sums);
    free(b->rows);
    free(b->fitted);
    free(b->q);
    free(b->accelerations);
    free(b->moving);
    free(b->taylor.series);
    free(b->taylor.force);
    free(b->taylor.spare.table);
    free(b->taylor.spare.sine);
    free(b->taylor.joint);
#ifdef FIXED_SERIES
    fixed_table_free(b->taylor.spare.fixed);
#endif
    free(b->taylor.spare.load);
    free(b->taylor.spare.tapes.series);
    free(b->taylor.spare.tapes.values);
    free(b->taylor.spare.base_tapes.series);
    free(b->taylor.spare.base_tapes.values);
    free(b->taylor.step.series);
    free(b->taylor.step.values);
    free(b->taylor.here.series);
    free(b->taylor.here.values);
    free(b->taylor.entries);
    free(b->taylor.spare_rotors.sine);
    free(b->taylor.spare_rotors.mass);
    free(b->taylor.spare_rotors.leaders);
    free(b->taylor.pushed);
    free(b->taylor.torques);
    free(b->taylor.spare.loaded_on);
    free(b->seat);
    free(b->tangencies.fastest);
    free(b);
}
