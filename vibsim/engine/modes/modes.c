/* Scenes and modes from packed numbers, in the order in which vibsim/engine/modes/packing.py writes them. */
#include <stdlib.h>
#include <string.h>

#include "certificate.h"
#include "friction_laws.h"
#include "modes.h"
#include "numbers.h"

enum { MOST = 100000 }; /* of anything in a scene or a mode */

static void *room(size_t count, size_t size)
{
    return calloc(count ? count : 1, size);
}

static void read_harmonic(Reader *in, Harmonic *h)
{
    h->amplitude = read_double(in);
    h->omega = read_double(in);
    h->cycles = read_double(in);
    h->cycles_lo = read_double(in);
    h->phase = read_double(in);
}

static int room_for_flows(Run *r)
{
    Taylor *f = &r->taylor;
    ClosedForm *c = &r->closed_form;
    size_t n = (size_t)r->bodies, columns = n + 2, row = 2 * (n + 3), coordinates = 2 * n + 2, harmonics = (size_t)r->harmonic_count + 1, i;
    f->table = room((SERIES + 1) * row, sizeof(double));
    f->loaded_on = room(columns, sizeof(double *));
    f->load = room(columns * SERIES, sizeof(double));
    r->force = room(columns, sizeof(double));
    r->state.x = room(7 * n, sizeof(double));
    c->motions = room(coordinates, sizeof(Motion));
    c->responses = room(coordinates * harmonics, sizeof(Response));
    c->sin0 = room(harmonics * 6, sizeof(double));
    c->x0 = room(3 * columns, sizeof(double));
    c->scales[0] = room(MEASURES * coordinates, sizeof(Scale));
    c->times.cosine = room(2 * (harmonics + coordinates), sizeof *c->times.cosine);
    if (!f->table || !f->loaded_on || !f->load || !r->force || !r->state.x || !c->motions || !c->responses || !c->sin0 || !c->x0 ||
        !c->scales[0] || !c->times.cosine)
        return 0;
    for (i = 1; i < MEASURES; i++)
        c->scales[i] = c->scales[0] + i * coordinates;
    f->values = f->table + SERIES * row;
    r->state.v = r->state.x + n;
    r->next.x = r->state.x + 2 * n;
    r->next.v = r->state.x + 3 * n;
    r->scratch.x = r->state.x + 4 * n;
    r->scratch.v = r->state.x + 5 * n;
    r->before_v = r->state.x + 6 * n;
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
    return 1;
}

/* What a scene counts, and room for it. */
static int scene_shape(Run *r, Reader *in)
{
    int i, j;
    r->bodies = read_index(in, 1, MOST);
    r->columns = r->bodies + 2;
    r->parts = read_index(in, 0, MOST);
    r->clearances = read_index(in, 0, r->parts);
    r->harmonic_count = read_index(in, 0, MOST);
    r->force_count = read_index(in, 0, MOST);
    r->base_count = read_index(in, 0, MOST);
    r->has_motor = read_index(in, 0, 1);
    r->motor_on = read_index(in, 0, r->bodies - 1);
    r->rest_columns = read_index(in, r->base_count > 0 ? 2 : 0, 2);
    r->stop_on_violation = read_index(in, 0, 1);
    r->taylor.order = read_index(in, 2, MAX_ORDER);
    if (in->short_of)
        return 0;
    r->masses = room((size_t)r->bodies, sizeof(double));
    r->harmonics = room((size_t)r->harmonic_count, sizeof(Harmonic));
    r->forces = room((size_t)r->force_count, sizeof(Force));
    r->base = room((size_t)r->base_count, sizeof(Harmonic));
    r->taylor.loaded = room((size_t)r->bodies, sizeof(int));
    if (!r->masses || !r->harmonics || !r->forces || !r->base || !r->taylor.loaded || !room_for_flows(r))
        return 0;
    for (i = 0; i < r->harmonic_count; i++)
        r->harmonics[i].harmonic = i;
    for (i = 0; i < r->base_count; i++)
        r->base[i].harmonic = read_index(in, -1, r->harmonic_count - 1);
    for (i = 0; i < r->force_count; i++) {
        Force *f = &r->forces[i];
        f->on = read_index(in, 0, r->bodies - 1);
        f->count = read_index(in, 0, MOST);
        f->terms = in->short_of ? NULL : room((size_t)f->count, sizeof(Harmonic));
        if (!f->terms)
            return 0;
        for (j = 0; j < f->count; j++)
            f->terms[j].harmonic = read_index(in, -1, r->harmonic_count - 1);
    }
    return 1;
}

/* The numbers of a scene of that shape. */
static void scene_numbers(Run *r, Reader *in)
{
    int i, j;
    r->m3 = read_double(in);
    r->e = read_double(in);
    r->J = read_double(in);
    r->M0 = read_double(in);
    r->Omega0 = read_double(in);
    r->tolerance_exponent = read_double(in);
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
    certificate_open(&r->certificate);
    taylor_set(r);
    return read_through(in);
}

/* Where a difference of columns or rates is in the table of Taylor series; the ground is zero and need not be there. */
static void place_term(const Run *r, Term *t)
{
    int rates = t->kind == RATE ? r->taylor.rates : 0;
    t->from = t->to = -1;
    if (t->kind != DIFFERENCE && t->kind != RATE)
        return;
    if (t->P != r->bodies)
        t->from = column_in_table(r, t->P) + rates;
    if (t->Q != r->bodies)
        t->to = column_in_table(r, t->Q) + rates;
}

static void read_terms(Reader *in, Term *terms, int count, const Run *r, const Mode *m, int pairs)
{
    int i;
    for (i = 0; i < count; i++) {
        terms[i].kind = read_index(in, DIFFERENCE, FALL);
        terms[i].P = read_index(in, 0, (terms[i].kind == COUPLING ? m->coupling_count : terms[i].kind == FALL ? m->fall_count : r->columns) - 1);
        terms[i].Q = read_index(in, -1, r->columns - 1);
        if ((terms[i].kind == DIFFERENCE || terms[i].kind == RATE) && terms[i].Q < 0)
            in->short_of = 1;
        place_term(r, &terms[i]);
        terms[i].pair = read_index(in, -1, pairs - 1);
        if (pairs > 0 && (terms[i].kind == DIFFERENCE || terms[i].kind == RATE) && terms[i].pair < 0)
            in->short_of = 1;
        terms[i].coefficient = read_double(in);
    }
}

static void read_place(Reader *in, Place *p, int shares, int fixed, const Share *all)
{
    p->first_share = read_index(in, 0, shares);
    p->shares = read_index(in, 0, shares - p->first_share);
    p->first_fixed = read_index(in, 0, fixed);
    p->fixed = read_index(in, 0, fixed - p->first_fixed);
    p->base = read_index(in, -1, 1);
    p->share = all + p->first_share;
}

/* What of a coordinate depends on the frequencies of its drives. */
static void tune_coordinate(const Run *r, Coordinate *c)
{
    int i, n;
    for (i = 0; i < c->drive_count; i++) {
        Drive *drive = &c->drives[i];
        double omega = r->harmonics[drive->harmonic].omega, size = drive->size / 2;
        oscillator_set(&drive->oscillator, c->a, c->b, omega);
        for (n = 0; n < JET_ORDER + 3; n++) {
            c->forced[n] = i == 0 ? size : c->forced[n] + size;
            size = size * omega;
        }
    }
    if (c->drive_count > 0)
        c->oscillator = c->drives[0].oscillator;
    else
        oscillator_set(&c->oscillator, c->a, c->b, 0.0);
}

static double smaller(double a, double b)
{
    return b < a ? b : a;
}

/* The same of a closed form, with its window and pace. */
static void tune_modal(const Run *r, Modal *m)
{
    int bounded = r->harmonic_count > 0, i, k;
    double window = INFINITY;
    m->pace = 0.0;
    for (i = 0; i < m->count; i++) {
        Coordinate *c = &m->coordinates[i];
        tune_coordinate(r, c);
        m->pace = c->oscillator.w0 > m->pace ? c->oscillator.w0 : m->pace;
        bounded = bounded || !c->is_free;
        if (!c->is_free)
            window = smaller(window, c->oscillator.window);
        for (k = 1; !c->is_free && k < c->drive_count; k++)
            window = smaller(window, c->drives[k].oscillator.window);
    }
    for (i = 0; i < r->harmonic_count; i++)
        window = smaller(window, 1.5 / r->harmonics[i].omega);
    m->window = bounded ? window : UNHURRIED;
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
            tune_modal(r, m->modal);
            reaches_set(m);
        }
    }
    return read_through(in);
}

static int read_coordinate(Reader *in, const Run *r, Coordinate *c, Terms *terms, int sources, int shifts)
{
    int h;
    c->is_free = read_index(in, 0, 1);
    c->first_source = read_index(in, 0, sources);
    c->sources = read_index(in, 0, sources - c->first_source);
    c->first_shift = read_index(in, 0, shifts);
    c->shifts = read_index(in, 0, shifts - c->first_shift);
    c->a = read_double(in);
    c->b = read_double(in);
    c->load = read_double(in);
    terms->load = read_double(in);
    c->drives = room((size_t)r->harmonic_count, sizeof(Drive));
    terms->drives = room((size_t)r->harmonic_count, sizeof(double));
    if (!c->drives || !terms->drives)
        return 0;
    for (h = 0; h < r->harmonic_count; h++)
        c->drives[h].sine = read_double(in);
    for (h = 0; h < r->harmonic_count; h++)
        c->drives[h].cosine = read_double(in);
    for (h = 0; h < r->harmonic_count; h++)
        terms->drives[h] = read_double(in);
    for (h = 0; h < r->harmonic_count; h++) {
        Drive *drive = &c->drives[c->drive_count];
        if (c->drives[h].sine == 0 && c->drives[h].cosine == 0)
            continue;
        drive->sine = c->drives[h].sine;
        drive->cosine = c->drives[h].cosine;
        terms->drives[c->drive_count] = terms->drives[h];
        drive->harmonic = h;
        drive->size = fabs(drive->sine) + fabs(drive->cosine);
        c->drive_count++;
    }
    return 1;
}

static Modal *modal_read(const Run *r, Reader *in, int pairs, int events)
{
    Modal *m;
    int sources, shifts, shares, fixed, i;
    int count = read_index(in, 0, 2 * r->bodies + 2);
    sources = read_index(in, 0, MOST);
    shifts = read_index(in, 0, MOST);
    shares = read_index(in, 0, MOST);
    fixed = read_index(in, 0, MOST);
    if (in->short_of || (m = room(1, sizeof *m)) == NULL)
        return NULL;
    m->count = count;
    m->coordinates = room((size_t)count, sizeof(Coordinate));
    m->sources = room((size_t)sources, sizeof(Source));
    m->shifts = room((size_t)shifts, sizeof(Shift));
    m->places = room((size_t)(r->columns + pairs), sizeof(Place));
    m->shares = room((size_t)shares, sizeof(Share));
    m->fixed = room((size_t)fixed, sizeof(Fixed));
    m->terms = room((size_t)count, sizeof(Terms));
    m->reaches = room((size_t)events, sizeof(Reach));
    if (!m->coordinates || !m->terms || !m->reaches || !m->sources || !m->shifts || !m->places || !m->shares || !m->fixed)
        return m;
    m->pairs = m->places + r->columns;
    for (i = 0; i < sources; i++) {
        m->sources[i].P = read_index(in, 0, r->columns - 1);
        m->sources[i].Q = read_index(in, -1, r->columns - 1);
        m->sources[i].weight = read_double(in);
    }
    for (i = 0; i < shifts; i++) {
        m->shifts[i].first = read_index(in, 0, fixed);
        m->shifts[i].count = read_index(in, 0, fixed - m->shifts[i].first);
        m->shifts[i].factor = read_double(in);
    }
    for (i = 0; i < shares; i++) {
        m->shares[i].m = read_index(in, 0, count - 1);
        m->shares[i].share = read_double(in);
    }
    for (i = 0; i < fixed; i++) {
        m->fixed[i].column = read_index(in, 0, r->columns - 1);
        m->fixed[i].sign = read_index(in, -2, 2);
    }
    for (i = 0; i < r->columns + pairs; i++)
        read_place(in, &m->places[i], shares, fixed, m->shares);
    for (i = 0; i < count; i++)
        if (!read_coordinate(in, r, &m->coordinates[i], &m->terms[i], sources, shifts)) {
            in->short_of = 1;
            return m;
        }
    if (!in->short_of)
        tune_modal(r, m);
    return m;
}

/* Raise the depth of the coordinates that a place is made of. */
static void reach(Modal *modal, const Place *p, int depth)
{
    int i;
    for (i = 0; i < p->shares; i++) {
        Coordinate *c = &modal->coordinates[p->share[i].m];
        c->depth = depth > c->depth ? depth : c->depth;
    }
}

/* Depths of the coordinates by the terms that event functions are made of; `less` where they make a slope. */
static void reach_terms(Mode *m, const Term *terms, int count, int less)
{
    int i;
    for (i = 0; i < count; i++) {
        const Term *t = &terms[i];
        if (t->kind == DIFFERENCE || t->kind == RATE)
            reach(m->modal, &m->modal->pairs[t->pair], (t->kind == RATE) - less);
        else if (t->kind == COUPLING)
            reach(m->modal, &m->modal->pairs[m->couplings[t->P].pair], 1 - less);
        else if (t->kind == ACCELERATION)
            reach(m->modal, &m->modal->places[t->P], 2 - less);
    }
}

static const Single no_single = {0, 0, 0, 0, 0, 0, NOTHING, 0, NOTHING};

static Single single_of(const Mode *m, const Term *terms, int count)
{
    Single s = no_single;
    const Place *p;
    if (count != 1 || terms->kind > COUPLING)
        return s;
    p = &m->modal->pairs[terms->kind == COUPLING ? m->couplings[terms->P].pair : terms->pair];
    if (p->shares < 1 || p->shares > 2 || p->fixed || p->base)
        return s;
    s.kind = terms->kind;
    s.coefficient = terms->coefficient;
    s.m = p->share[0].m;
    s.share = p->share[0].share;
    if (p->shares > 1) {
        s.other = p->share[1].m;
        s.other_share = p->share[1].share;
    }
    if (s.kind == COUPLING) {
        s.k = m->couplings[terms->P].k;
        s.c = m->couplings[terms->P].c;
        s.offset = m->couplings[terms->P].offset;
    }
    return s;
}

/* What of the coordinates' derivatives a function of the rows reads, and how. */
void function_prepare(Mode *m, Event *e)
{
    int rates_alone = e->slopes > 0, k;
    e->single = no_single;
    if (!m->modal)
        return;
    for (k = 0; k < e->terms; k++)
        rates_alone = rates_alone && m->terms[e->first + k].kind <= RATE;
    if (!rates_alone) /* else nothing beyond order 1, which is always there */
        reach_terms(m, m->terms + e->first, e->terms, 0);
    e->single = single_of(m, m->terms + e->first, e->terms);
    for (k = 0; k < e->slopes; k++) {
        Slope *s = &m->slopes[e->first_slope + k];
        reach_terms(m, m->terms + s->first, s->terms, 1);
        s->single = single_of(m, m->terms + s->first, s->terms);
    }
}

static void prepare_events(Mode *m)
{
    int i;
    for (i = 0; i < m->modal->count; i++)
        m->modal->coordinates[i].depth = RATE_ALONE;
    for (i = 0; i < m->event_count; i++)
        function_prepare(m, &m->events[i]);
    reaches_set(m);
}

/* The shape of the recurrences that suits a mode: at most one coupling, of body 0 and one other column. */
static void take_shape(const Run *r, Mode *m)
{
    int small = r->base_count == 0 && m->coupling_count < 2 && m->fall_count == 0 && m->leader[0] == 0, i;
    m->untied = 1;
    for (i = 0; i < r->bodies; i++)
        m->untied = m->untied && m->leader[i] == i;
    m->shape = ANY;
    if (m->coupling_count > 0)
        small = small && m->couplings[0].P == 0 && m->couplings[0].Q == 1;
    small = small && r->taylor.rates == 3 && (!r->has_motor || r->motor_on == 0);
    if (!small || r->bodies > 2)
        return;
    m->shape = r->bodies == 1 ? ONE : m->leader[1] == 1 ? TWO_FREE : m->leader[1] == 2 ? TWO_HELD : ANY;
    if (m->coupling_count > 0)
        m->small = m->couplings[0];
    for (i = 0; i < m->constant_count; i++)
        if (m->constant_columns[i] < 2)
            m->small_constants[m->constant_columns[i]] = m->constants[i];
}

int room_for_series(double (**series)[SERIES], int count)
{
    double(*more)[SERIES] = realloc(*series, sizeof *more * (size_t)count);
    *series = more ? more : *series;
    return more != NULL;
}

/* Room for the series of so many falling frictions. */
static int room_for_falls(Run *r, int count)
{
    if (count <= r->fall_room)
        return 1;
    if (!room_for_series(&r->taylor.arguments, count) || !room_for_series(&r->taylor.falls, count))
        return 0;
    if (r->tangent && !tangent_room_for_falls(r->tangent, count))
        return 0;
    r->fall_room = count;
    return 1;
}

static void read_fall(Reader *in, const Run *r, const Mode *m, Falling *one)
{
    one->law = read_index(in, 0, LAWS - 1);
    one->P = read_index(in, 0, r->columns - 1);
    one->Q = read_index(in, 0, r->columns - 1);
    one->on_P = read_double(in);
    one->rate = read_double(in);
    one->drift = read_double(in);
    one->to_P = m->leader[one->P];
    one->to_Q = m->leader[one->Q];
    one->from = one->P == r->bodies ? -1 : column_in_table(r, one->P) + r->taylor.rates;
    one->to = one->Q == r->bodies ? -1 : column_in_table(r, one->Q) + r->taylor.rates;
    if (one->from >= r->taylor.stride || one->to >= r->taylor.stride)
        in->short_of = 1;
}

Mode *mode_read(Run *r, Reader *in)
{
    Mode *m = room(1, sizeof *m);
    int terms, slopes, slope_constants, pairs, i;
    if (!m)
        return NULL;
    m->coupling_count = read_index(in, 0, MOST);
    m->fall_count = read_index(in, 0, r->parts);
    m->event_count = read_index(in, 0, MOST);
    m->constant_count = read_index(in, 0, MOST);
    terms = read_index(in, 0, MOST);
    slopes = read_index(in, 0, MOST);
    slope_constants = read_index(in, 0, MOST);
    pairs = read_index(in, 0, MOST);
    if (in->short_of)
        return m;
    m->couplings = room((size_t)m->coupling_count, sizeof(Coupling));
    m->falls = room((size_t)m->fall_count, sizeof(Falling));
    m->events = room((size_t)m->event_count, sizeof(Event));
    m->terms = room((size_t)terms, sizeof(Term));
    m->slopes = room((size_t)slopes, sizeof(Slope));
    m->mobility = room((size_t)(3 * r->columns), sizeof(double));
    m->constants = room((size_t)(m->constant_count + slope_constants), sizeof(double));
    m->leader = room((size_t)(r->columns + m->constant_count + r->parts + r->bodies), sizeof(int));
    if (!m->couplings || !m->falls || !room_for_falls(r, m->fall_count) || !m->events || !m->terms || !m->slopes || !m->mobility || !m->constants || !m->leader) {
        in->short_of = 1;
        return m;
    }
    m->group_mass = m->mobility + r->columns;
    m->drift = m->group_mass + r->columns;
    m->slope_constants = m->constants + m->constant_count;
    m->constant_columns = m->leader + r->columns;
    m->codes = m->constant_columns + m->constant_count;
    m->tied = m->codes + r->parts;
    for (i = 0; i < r->parts; i++)
        m->codes[i] = read_index(in, -1, 3);
    for (i = 0; i < r->columns; i++) {
        m->leader[i] = read_index(in, 0, r->columns - 1);
        m->mobility[i] = read_double(in);
        m->group_mass[i] = read_double(in);
        m->drift[i] = read_double(in);
    }
    for (i = 0; i < r->taylor.loaded_count; i++) {
        int column = r->taylor.loaded[i], c, together = 0;
        for (c = 0; c < r->columns; c++)
            together += m->leader[c] == m->leader[column];
        if (together > 1)
            m->tied[m->tied_count++] = column;
    }
    m->carried = r->has_motor ? m->group_mass[m->leader[r->motor_on]] : 0.0;
    for (i = 0; i < m->coupling_count; i++) {
        Coupling *c = &m->couplings[i];
        c->P = read_index(in, 0, r->columns - 1);
        c->Q = read_index(in, 0, r->columns - 1);
        c->pair = read_index(in, pairs > 0 ? 0 : -1, pairs - 1);
        c->to_P = m->leader[c->P];
        c->to_Q = m->leader[c->Q];
        c->k = read_double(in);
        c->c = read_double(in);
        c->offset = read_double(in);
        c->from = column_in_table(r, c->P);
        c->to = column_in_table(r, c->Q);
        if (c->from >= r->taylor.rates || c->to >= r->taylor.rates)
            in->short_of = 1;
    }
    for (i = 0; i < m->fall_count; i++)
        read_fall(in, r, m, &m->falls[i]);
    for (i = 0; i < m->constant_count; i++) {
        m->constant_columns[i] = read_index(in, 0, r->bodies - 1);
        m->constants[i] = read_double(in);
    }
    take_shape(r, m);
    for (i = 0; i < slope_constants; i++)
        m->slope_constants[i] = read_double(in);
    read_terms(in, m->terms, terms, r, m, pairs);
    for (i = 0; i < slopes; i++) {
        Slope *s = &m->slopes[i];
        s->first = read_index(in, 0, terms);
        s->terms = read_index(in, 0, terms - s->first);
        s->first_constant = read_index(in, 0, slope_constants);
        s->constants = read_index(in, 0, slope_constants - s->first_constant);
        s->mass = read_double(in);
        s->factor = read_double(in);
    }
    for (i = 0; i < m->event_count; i++) {
        Event *e = &m->events[i];
        e->kind = read_index(in, GAP, STRIKE);
        e->part = read_index(in, 0, MOST);
        e->key = read_index(in, 0, MOST);
        e->turns = read_index(in, 0, 1);
        e->first = read_index(in, 0, terms);
        e->terms = read_index(in, 0, terms - e->first);
        e->first_slope = read_index(in, 0, slopes);
        e->slopes = read_index(in, 0, slopes - e->first_slope);
        e->constant = read_double(in);
        e->size = read_double(in);
        e->rule = ASK;
    }
    if (!in->short_of && read_index(in, 0, 1)) {
        m->modal = modal_read(r, in, pairs, m->event_count);
        if (!m->modal)
            in->short_of = 1;
        if (!in->short_of)
            prepare_events(m);
    }
    return m;
}

void mode_free(Mode *m)
{
    int i;
    if (!m)
        return;
    if (m->modal) {
        for (i = 0; m->modal->coordinates && i < m->modal->count; i++)
            free(m->modal->coordinates[i].drives);
        for (i = 0; m->modal->terms && i < m->modal->count; i++)
            free(m->modal->terms[i].drives);
        free(m->modal->coordinates);
        free(m->modal->terms);
        free(m->modal->reaches);
        free(m->modal->sources);
        free(m->modal->shifts);
        free(m->modal->places);
        free(m->modal->shares);
        free(m->modal->fixed);
        free(m->modal);
    }
    meters_free(&m->meters);
    free(m->couplings);
    free(m->falls);
    free(m->events);
    free(m->terms);
    free(m->slopes);
    free(m->mobility);
    free(m->constants);
    free(m->leader);
    free(m);
}

static int grown(void **array, size_t before, size_t after, size_t size)
{
    char *more = realloc(*array, after * size);
    if (!more)
        return 0;
    memset(more + before * size, 0, (after - before) * size);
    *array = more;
    return 1;
}

/* Add a mode; its number, or -1 without memory. Sets how many keys of zeros there are. */
int mode_add(Run *r, Mode *m)
{
    Search *s = &r->closed_form.search;
    int keys = r->key_count, events = r->event_room, i;
    for (i = 0; i < m->event_count; i++)
        keys = m->events[i].key >= keys ? m->events[i].key + 1 : keys;
    if (!grown((void **)&r->modes, (size_t)r->mode_count, (size_t)r->mode_count + 1, sizeof(Mode *)) ||
        !grown((void **)&r->known, (size_t)r->key_count, (size_t)keys + 1, sizeof(int)) ||
        !grown((void **)&r->behind, (size_t)r->key_count, (size_t)keys + 1, sizeof(int)))
        return -1;
    r->key_count = keys;
    if (m->event_count > events) {
        if (!grown((void **)&s->watched, (size_t)events, (size_t)m->event_count, sizeof *s->watched) ||
            !grown((void **)&s->blurs, (size_t)events, (size_t)m->event_count, sizeof(Blur)) ||
            !grown((void **)&s->events, (size_t)events, (size_t)m->event_count, sizeof(int)))
            return -1;
        r->event_room = m->event_count;
    }
    r->modes[r->mode_count] = m;
    return r->mode_count++;
}

int mode_renew(Run *r, int number, Mode *m)
{
    Mode *before = r->modes[number];
    int i;
    if (m->event_count != before->event_count || before->meters.meters)
        return 0;
    for (i = 0; i < m->event_count; i++) {
        Event *e = &m->events[i], *one = &before->events[i];
        int same = e->kind == one->kind && e->key == one->key && e->terms == one->terms, k;
        for (k = 0; same && k < e->terms; k++)
            same = m->terms[e->first + k].kind == before->terms[one->first + k].kind;
        if (!same)
            return 0;
        e->rule = one->rule;
        e->target = one->target;
        e->other = one->other;
        e->hold = one->hold;
        e->event = one->event;
        e->event_part = one->event_part;
        e->event_key = one->event_key;
        e->order = one->order;
    }
    mode_free(before);
    r->modes[number] = m;
    return 1;
}

void run_free(Run *r)
{
    int i;
    for (i = 0; i < r->mode_count; i++)
        mode_free(r->modes[i]);
    for (i = 0; r->forces && i < r->force_count; i++)
        free(r->forces[i].terms);
    ledger_free(&r->ledger);
    tangent_free(r->tangent);
    extremes_free(&r->extremes);
    blows_free(&r->blows);
    free(r->modes);
    free(r->known);
    free(r->behind);
    free(r->masses);
    free(r->harmonics);
    free(r->forces);
    free(r->base);
    free(r->force);
    free(r->state.x);
    free(r->taylor.table);
    free(r->taylor.load);
    free(r->taylor.arguments);
    free(r->taylor.falls);
    free(r->taylor.loaded_on);
    free(r->taylor.loaded);
    free(r->closed_form.motions);
    free(r->closed_form.responses);
    free(r->closed_form.sin0);
    free(r->closed_form.x0);
    free(r->closed_form.scales[0]);
    free(r->closed_form.times.cosine);
    free(r->closed_form.search.watched);
    free(r->closed_form.search.blurs);
    free(r->closed_form.search.events);
}
