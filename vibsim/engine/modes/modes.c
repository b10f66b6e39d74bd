/* The rows of a mode from packed numbers, in the order in which vibsim/engine/modes/packing.py writes them. */
#include "modes.h"

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

int named_by(const Run *r, const Mode *m, int kind)
{
    switch (kind) {
    case COUPLING: return m->coupling_count;
    case FORMULA: return m->tape.output_count;
    default: return r->columns;
    }
}

static void read_terms(Reader *in, Term *terms, int count, const Run *r, const Mode *m, int pairs)
{
    int i;
    for (i = 0; i < count; i++) {
        terms[i].kind = read_index(in, DIFFERENCE, FORMULA);
        terms[i].P = read_index(in, 0, named_by(r, m, terms[i].kind) - 1);
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

/* The shape of the recurrences that suits a mode: at most one coupling, of body 0 and one other column. */
static void take_shape(const Run *r, Mode *m)
{
    int small = !r->has_base && m->coupling_count < 2 && m->leader[0] == 0, i;
    m->untied = 1;
    for (i = 0; i < r->bodies; i++)
        m->untied = m->untied && m->leader[i] == i;
    m->shape = m->tape.op_count > 0 || r->rotors.count > 0 ? FORMULAS : ANY;
    if (m->shape == FORMULAS)
        return;
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

Mode *mode_read(Run *r, Reader *in)
{
    Mode *m = (Mode *)zalloc_for(NULL, 1, sizeof *m);
    int terms, slopes, slope_constants, pairs, ops, base_ops, i;
    if (!m)
        return NULL;
    in->owner = m;
    m->coupling_count = read_index(in, 0, MOST);
    m->event_count = read_index(in, 0, MOST);
    m->side_count = read_index(in, 0, MOST);
    m->constant_count = read_index(in, 0, MOST);
    terms = m->term_count = read_index(in, 0, MOST);
    slopes = read_index(in, 0, MOST);
    slope_constants = read_index(in, 0, MOST);
    pairs = read_index(in, 0, MOST);
    ops = read_index(in, 0, MOST);
    base_ops = read_index(in, 0, r->has_base ? MOST : 0);
    if (in->short_of)
        return m;
    m->couplings = room(in, m->coupling_count, sizeof(Coupling));
    m->events = room(in, m->event_count, sizeof(Event));
    m->terms = zalloc((size_t)terms, sizeof(Term)); /* which may grow */
    m->slopes = room(in, slopes, sizeof(Slope));
    m->mobility = room(in, 3 * r->columns + m->side_count, sizeof(Real));
    m->constants = room(in, m->constant_count + slope_constants, sizeof(Real));
    m->leader = room(in, r->columns + m->constant_count + r->parts + r->bodies, sizeof(int));
    in->short_of = in->short_of || !m->terms;
    if (in->short_of)
        return m;
    m->group_mass = m->mobility + r->columns;
    m->drift = m->group_mass + r->columns;
    m->sides = m->drift + r->columns;
    m->slope_constants = m->constants + m->constant_count;
    m->constant_columns = m->leader + r->columns;
    m->codes = m->constant_columns + m->constant_count;
    m->tied = m->codes + r->parts;
    for (i = 0; i < r->parts; i++)
        m->codes[i] = read_index(in, -1, 3);
    for (i = 0; i < m->side_count; i++)
        m->sides[i] = read_double(in);
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
    for (i = 0; i < m->constant_count; i++) {
        m->constant_columns[i] = read_index(in, 0, r->bodies - 1);
        m->constants[i] = read_double(in);
    }
    if (ops + base_ops > 0 && !formulas_read(r, in, m, ops, base_ops)) {
        in->short_of = 1;
        return m;
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
        e->kind = read_index(in, GAP, DOMAIN_EDGE);
        m->switch_count += e->kind == SWITCH;
        e->part = read_index(in, 0, MOST);
        e->key = read_index(in, 0, MOST);
        e->turns = read_index(in, 0, 1);
        e->first = read_index(in, 0, terms);
        e->terms = read_index(in, 0, terms - e->first);
        e->first_slope = read_index(in, 0, slopes);
        e->slopes = read_index(in, 0, slopes - e->first_slope);
        e->constant = read_double(in);
        e->size = read_double(in);
        e->rule.kind = DECIDE_IN_PYTHON;
    }
    if (!in->short_of && read_index(in, 0, 1)) {
        m->modal = modal_read(r, in, pairs, m->event_count);
        if (!m->modal || m->tape.op_count > 0)
            in->short_of = 1;
        if (!in->short_of)
            modal_prepare(m);
    }
    return m;
}
