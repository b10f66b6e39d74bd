/* A scene from packed numbers, in the order in which vibsim/engine/modes/packing.py writes them. */
#include "certificate.h"
#include "modes.h"
#include "numbers.h"

static void read_harmonic(Reader *in, Harmonic *h)
{
    h->amplitude = read_double(in);
    h->omega = read_double(in);
    h->cycles = read_double(in);
    h->cycles_lo = read_double(in);
    h->phase = read_double(in);
}

static void alloc_flows(Run *r, Reader *in)
{
    Taylor *f = &r->taylor;
    ClosedForm *c = &r->closed_form;
    size_t n = (size_t)r->bodies, columns = n + 2, row = 2 * (n + 3), coordinates = 2 * n + 2, harmonics = (size_t)r->harmonic_count + 1, i;
    f->table = room(in, (SERIES + 4) * row, sizeof(Real));
    f->loaded_on = room(in, columns, sizeof(Real *));
    f->load = room(in, columns * SERIES, sizeof(Real));
    f->inverse = room(in, 5 * (size_t)(SERIES + 1), sizeof(Real));
    r->force = room(in, columns, sizeof(Real));
    r->state.x = room(in, 9 * n, sizeof(Real));
    c->motions = room(in, coordinates, sizeof(Motion));
    c->responses = room(in, coordinates * harmonics, sizeof(Response));
    c->sin0 = room(in, harmonics * 6, sizeof(Real));
    c->x0 = room(in, 3 * columns, sizeof(Real));
    c->scales[0] = room(in, MEASURES * coordinates, sizeof(Scale));
    c->times.cosine = room(in, 2 * (harmonics + coordinates), sizeof *c->times.cosine);
#ifdef FIXED_SERIES
    f->rotor = room(in, BLOCKS, sizeof *f->rotor);
    f->fixed = fixed_table_new(SERIES, row);
    in->short_of = in->short_of || !f->fixed;
#endif
    if (in->short_of)
        return;
    for (i = 1; i < MEASURES; i++)
        c->scales[i] = c->scales[0] + i * coordinates;
    f->values = f->table + SERIES * row;
    f->checked = f->values + row;
    f->latest = f->checked + 2 * row;
    f->sine = f->inverse + SERIES + 1;
    f->cosine = f->sine + SERIES;
    f->w_back = f->cosine + SERIES;
    f->a1_back = f->w_back + SERIES;
    r->state.v = r->state.x + n;
    r->next.x = r->state.x + 2 * n;
    r->next.v = r->state.x + 3 * n;
    r->scratch.x = r->state.x + 4 * n;
    r->scratch.v = r->state.x + 5 * n;
    r->before_v = r->state.x + 6 * n;
    r->at_begin.x = r->state.x + 7 * n;
    r->at_begin.v = r->state.x + 8 * n;
    r->pause = INFINITY;
    for (i = 0; i < coordinates; i++)
        c->motions[i].responses = c->responses + i * harmonics;
    c->times.sine = c->times.cosine + harmonics;
    c->times.q = c->times.sine + harmonics;
    c->times.u = c->times.q + coordinates;
    c->cos0 = c->sin0 + harmonics;
    c->sines = c->cos0 + harmonics;
    c->cosines = c->sines + harmonics;
    c->sine = c->cosines + harmonics;
    c->cosine = c->sine + harmonics;
    c->v0 = c->x0 + columns;
    c->rest = c->v0 + columns;
    c->search.settled = power_of_two(binary_exponent(EPS) / 3.0);
}

void place_rotors(Rotors *o)
{
    o->cosine = series_along(o->sine, o->count);
    o->acceleration = series_along(o->cosine, o->count);
    o->speed = series_along(o->acceleration, o->count);
    o->mobility = o->mass + o->count;
    o->torque = o->mobility + o->count;
    o->pulled = o->torque + o->count;
    o->lean = o->pulled + o->count;
}

/* Memory for rotors on bodies, columns by themselves, and what formulas read. */
static void alloc_rotors(Run *r, Reader *in)
{
    Rotors *o = &r->rotors;
    TapeInputs *at = &r->taylor.tapes.at, *blur = &r->taylor.tapes.blur, *between = &r->taylor.tapes.between;
    const size_t count = (size_t)o->count, columns = (size_t)r->columns;
    r->alone = room(in, r->alone_count, sizeof(int));
    o->of = room(in, count, sizeof(RotorOn));
    o->sine = room(in, 4 * count * TAPE_WIDTH, sizeof(Real));
    o->mass = room(in, 5 * count, sizeof(Real));
    o->leaders = room(in, count + 1, sizeof(int));
    r->taylor.acceleration = room(in, 7 * columns, sizeof(Real));
    if (in->short_of)
        return;
    place_rotors(o);
    at->x = r->taylor.acceleration + columns;
    at->v = at->x + columns;
    blur->x = at->v + columns;
    blur->v = blur->x + columns;
    between->x = blur->v + columns;
    between->v = between->x + columns;
}

/* What a scene counts, and room for it. */
static int scene_shape(Run *r, Reader *in)
{
    int i, j;
    r->bodies = read_index(in, 1, MOST);
    r->columns = r->bodies + 2;
    r->parts = read_index(in, 0, MOST);
    r->clearances = read_index(in, 0, r->parts);
    r->switches = read_index(in, 0, MOST); /* of formulas */
    r->harmonic_count = read_index(in, 0, MOST);
    r->force_count = read_index(in, 0, MOST);
    r->base_count = read_index(in, 0, MOST);
    r->has_motor = read_index(in, 0, 1);
    r->motor_on = read_index(in, 0, r->bodies - 1);
    r->has_base = read_index(in, r->base_count > 0, 2); /* 2: by a formula of its velocity */
    r->rest_columns = read_index(in, r->has_base ? 2 : 0, 2);
    r->stop_on_violation = read_index(in, 0, 1);
    r->taylor.order = read_index(in, 2, MAX_ORDER);
    r->rotors.count = read_index(in, 0, r->bodies);
    r->alone_count = read_index(in, 0, r->bodies);
    r->masses = (Real *)zalloc_for(NULL, (size_t)r->bodies, sizeof(Real)); /* which own all that has the shape of the scene */
    in->owner = r->masses;
    if (in->short_of || !r->masses)
        return 0;
    r->harmonics = room(in, r->harmonic_count, sizeof(Harmonic));
    r->forces = room(in, r->force_count, sizeof(Force));
    r->base = room(in, r->base_count, sizeof(Harmonic));
    r->taylor.loaded = room(in, r->bodies, sizeof(int));
    alloc_flows(r, in);
    alloc_rotors(r, in);
    if (in->short_of)
        return 0;
    for (i = 0; i < r->harmonic_count; i++)
        r->harmonics[i].harmonic = i;
    for (i = 0; i < r->base_count; i++)
        r->base[i].harmonic = read_index(in, -1, r->harmonic_count - 1);
    for (i = 0; i < r->force_count; i++) {
        Force *f = &r->forces[i];
        f->on = read_index(in, 0, r->bodies - 1);
        f->count = read_index(in, 0, MOST);
        f->terms = room(in, f->count, sizeof(Harmonic));
        if (in->short_of)
            return 0;
        for (j = 0; j < f->count; j++)
            f->terms[j].harmonic = read_index(in, -1, r->harmonic_count - 1);
    }
    for (i = 0; i < r->rotors.count; i++) {
        r->rotors.of[i].column = read_index(in, 0, r->bodies - 1);
        r->rotors.of[i].on = read_index(in, 0, r->bodies - 1);
    }
    for (i = 0; i < r->alone_count; i++)
        r->alone[i] = read_index(in, 0, r->bodies - 1);
    return 1;
}

/* The numbers of a scene of that shape. */
static void scene_numbers(Run *r, Reader *in)
{
    int i, j;
    r->m3 = read_double(in);
    r->e = read_double(in);
    r->M0 = read_double(in);
    r->unbalance = read_double(in);
    r->inertia = read_double(in);
    r->drag = read_double(in);
    r->tolerance_exponent = (double)read_double(in);
    r->t_end = read_double(in);
    r->every_num = read_double(in);
    r->every_den = read_double(in);
    for (i = 0; i < r->bodies; i++)
        r->masses[i] = read_double(in);
    for (i = 0; i < r->harmonic_count; i++)
        read_harmonic(in, &r->harmonics[i]);
    for (i = 0; i < r->base_count; i++)
        read_harmonic(in, &r->base[i]);
    for (i = 0; i < r->force_count; i++) {
        r->forces[i].constant = read_double(in);
        for (j = 0; j < r->forces[i].count; j++)
            read_harmonic(in, &r->forces[i].terms[j]);
    }
    for (i = 0; i < r->rotors.count; i++) {
        r->rotors.of[i].unbalance = read_double(in);
        r->rotors.of[i].inertia = read_double(in);
        r->rotors.of[i].lightness = 1 / r->rotors.of[i].inertia;
    }
}

int scene_read(Run *r, Reader *in)
{
    int i, j;
    if (!scene_shape(r, in))
        return 0;
    scene_numbers(r, in);
    for (i = 0; i < r->bodies; i++) { /* in the order of the columns */
        int any = 0;
        for (j = 0; j < r->force_count; j++)
            any = any || r->forces[j].on == i;
        if (any) {
            r->taylor.loaded[r->taylor.loaded_count++] = i;
            r->taylor.loaded_on[i] = r->taylor.load + i * SERIES;
        }
    }
    r->work_at_once = WORK_AT_ONCE / (1.0 + (r->bodies + r->parts + r->harmonic_count) / 8);
#ifdef WORDS_BY_RUN
    {
        const double more = (1 - unit_roundoff.exponent) / 300.0; /* order and words grow with the bits */
        r->work_at_once /= 16 * more * more * more;
    }
#endif
    certificate_open(&r->certificate);
    taylor_set(r);
    return read_through(in);
}

int scene_retune(Run *r, Reader *in)
{
    int i;
    scene_numbers(r, in);
    taylor_set(r);
    for (i = 0; i < r->mode_count; i++) {
        Mode *m = r->modes[i];
        m->carried = r->has_motor ? m->group_mass[m->leader[r->motor_on]] : 0.0;
        if (m->modal) {
            modal_tune(r, m->modal);
            reaches_set(m);
        }
    }
    return read_through(in);
}
