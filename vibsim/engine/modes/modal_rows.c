/* The closed form of a mode from packed numbers, and what of its coordinates event functions read. */
#include "modes.h"
#include "numbers.h"

static void read_place(Reader *in, Place *p, int shares, int fixed, const Share *all)
{
    p->first_share = read_index(in, 0, shares);
    p->shares = read_index(in, 0, shares - p->first_share);
    p->first_fixed = read_index(in, 0, fixed);
    p->fixed = read_index(in, 0, fixed - p->first_fixed);
    p->base = read_index(in, -1, 1);
    p->share = all + p->first_share;
}

/* Room for the series of oscillator number i of a coordinate. */
static void place_series(Coordinate *c, Oscillator *o, int i)
{
    o->steady_series = c->series + 3 * i * SERIES_TERMS;
    o->real_series = o->steady_series + SERIES_TERMS;
    o->imag_series = o->real_series + SERIES_TERMS;
}

/* What of a coordinate depends on the frequencies of its drives. */
static void tune_coordinate(const Run *r, Coordinate *c)
{
    int i, n;
    for (i = 0; i < c->drive_count; i++) {
        Drive *drive = &c->drives[i];
        Real omega = r->harmonics[drive->harmonic].omega, size = drive->size / 2;
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

static Real smaller(Real a, Real b)
{
    return b < a ? b : a;
}

/* The same of a closed form, with its window and pace. */
void modal_tune(const Run *r, Modal *m)
{
    int bounded = r->harmonic_count > 0, i, k;
    Real window = INFINITY;
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

static void read_coordinate(Reader *in, const Run *r, Coordinate *c, Terms *terms, int sources, int shifts)
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
    c->drives = room(in, r->harmonic_count, sizeof(Drive));
    terms->drives = room(in, r->harmonic_count, sizeof(Real));
    if (in->short_of)
        return;
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
    c->series = room(in, 3 * (c->drive_count > 0 ? c->drive_count : 1) * SERIES_TERMS, sizeof(Real));
    if (in->short_of)
        return;
    place_series(c, &c->oscillator, 0);
    for (h = 0; h < c->drive_count; h++)
        place_series(c, &c->drives[h].oscillator, h);
}

Modal *modal_read(const Run *r, Reader *in, int pairs, int events)
{
    Modal *m;
    int sources, shifts, shares, fixed, i;
    int count = read_index(in, 0, 2 * r->bodies + 2);
    sources = read_index(in, 0, MOST);
    shifts = read_index(in, 0, MOST);
    shares = read_index(in, 0, MOST);
    fixed = read_index(in, 0, MOST);
    m = room(in, 1, sizeof *m);
    if (in->short_of)
        return NULL;
    m->count = count;
    m->coordinates = room(in, count, sizeof(Coordinate));
    m->sources = room(in, sources, sizeof(Source));
    m->shifts = room(in, shifts, sizeof(Shift));
    m->places = room(in, r->columns + pairs, sizeof(Place));
    m->shares = room(in, shares, sizeof(Share));
    m->fixed = room(in, fixed, sizeof(Fixed));
    m->terms = room(in, count, sizeof(Terms));
    m->reaches = room(in, events, sizeof(Reach));
    if (in->short_of)
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
    for (i = 0; i < count && !in->short_of; i++)
        read_coordinate(in, r, &m->coordinates[i], &m->terms[i], sources, shifts);
    if (!in->short_of)
        modal_tune(r, m);
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

void modal_prepare(Mode *m)
{
    int i;
    for (i = 0; i < m->modal->count; i++)
        m->modal->coordinates[i].depth = RATE_ALONE;
    for (i = 0; i < m->event_count; i++)
        function_prepare(m, &m->events[i]);
    reaches_set(m);
}
