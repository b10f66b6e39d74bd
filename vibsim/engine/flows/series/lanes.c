/* Runs side by side: the next Taylor steps of up to RUNS_AT_ONCE runs of small scenes with a motor, each in a lane of its own.
 *
 * A processor takes one operation for all lanes of a vector at once. In each lane these are the operations of the run by itself
 * (taylor_expansion.c, step_length.c), in their order, so that the bits are the same. Beside that lanes tell which event functions
 * are sure to stay positive on the whole step, by sums that are above those of polynomial_root.c, so that no zeros are looked for
 * there. A lane whose numbers are not usual (zero, not finite, a large angle) is computed by the run itself.
 *
 * Which vectors there are is asked when runs are to share lanes: it changes no bits.
 */
#include "lanes.h"
#include "inlining.h"
#include "numbers.h"

#define SLACK 100 /* roundings of the sum of all magnitudes of an event function, more than two orders of summation can differ by */

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi" /* no vector is passed between functions that are not made one */

#pragma GCC push_options
#pragma GCC target("avx2")
#define WIDTH 4
#include "lanes_of_width.h"

/* The rows of four lanes, from number `first` on, into the tables of their runs, the last one to where the columns were asked for last;
 * second, third: places of columns 1 and 2 of those.
 */
static void give_tables(const Lanes *l, int first, int rows, int second, int third, Taylor *const *of)
{
    const Bits4 even = {0, 4, 2, 6}, odd = {1, 5, 3, 7}, low = {0, 1, 4, 5}, high = {2, 3, 6, 7};
    int n;
    for (n = 0; n < rows; n++) {
        const ByLane *at = l->table[n];
        const Vector4 a = vector4(at[BODY] + first), b = vector4(at[second] + first), c = vector4(at[third] + first);
        const Vector4 d = vector4(at[BODY_RATE] + first), e = vector4(at[BODY_RATE + second] + first), f = vector4(at[BODY_RATE + third] + first);
        const Vector4 ab[] = {__builtin_shuffle(a, b, even), __builtin_shuffle(a, b, odd)};
        const Vector4 cd[] = {__builtin_shuffle(c, d, even), __builtin_shuffle(c, d, odd)};
        const Vector4 ef[] = {__builtin_shuffle(e, f, even), __builtin_shuffle(e, f, odd)};
        int i;
        for (i = 0; i < 2; i++) {
            const Vector4 one = __builtin_shuffle(ab[i], cd[i], low), other = __builtin_shuffle(ab[i], cd[i], high);
            double *to = n < rows - 1 ? of[i]->table + COLUMNS * n : of[i]->latest;
            memcpy(to, &one, sizeof one);
            memcpy(to + 4, &ef[i], sizeof(double[2]));
            to = n < rows - 1 ? of[i + 2]->table + COLUMNS * n : of[i + 2]->latest;
            memcpy(to, &other, sizeof other);
            memcpy(to + 4, (const double *)&ef[i] + 2, sizeof(double[2]));
        }
    }
}
#undef WIDTH
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f")
#define WIDTH 8
#include "lanes_of_width.h"
#undef WIDTH
#pragma GCC pop_options

/* Place of a column of the table among the COLUMNS; that of one body is x, phi, ground. */
static int place_of(const Run *r, int column)
{
    static const int of_one_body[] = {BODY, ANGLE, FAR, BODY_RATE, SPEED, FAR_RATE};
    return r->bodies == 2 ? column : of_one_body[column];
}

/* Add factor (a - b) of two columns of the table, below 0 for the ground, to an event function in lane i. */
static void add_difference(const Run *r, Watched *to, int i, double factor, int a, int b)
{
    const int columns[] = {a, b};
    int k;
    for (k = 0; k < 2; k++, factor = -factor)
        if (columns[k] >= 0) {
            const int c = place_of(r, columns[k]);
            to->factor[c][i] += factor;
            to->used[c] = 1;
        }
}

/* Write an event function of the mode in lane i as a sum of columns. Where it is none, its zeros are looked for in any case; so are those of
 * rigid stops, which may be struck at the start of a step, and of switches, which may rest at their zero.
 */
static void watch(const Run *r, const Event *e, Watched *to, int i)
{
    int k;
    for (k = 0; k < COLUMNS; k++)
        to->factor[k][i] = 0;
    to->constant[i] = e->constant;
    to->turns[i] = e->turns;
    to->known[i] = e->terms > 0 && e->kind != STRIKE && e->kind != SWITCH ? 0 : NAN;
    for (k = 0; k < e->terms; k++) {
        const Term *t = &r->mode->terms[e->first + k];
        const Coupling *q = t->kind == COUPLING ? &r->mode->couplings[t->P] : NULL;
        if (t->kind == DIFFERENCE || t->kind == RATE) {
            add_difference(r, to, i, t->coefficient, t->from, t->to);
        } else if (q) {
            add_difference(r, to, i, t->coefficient * q->k, q->from, q->to);
            add_difference(r, to, i, t->coefficient * q->c, q->from + r->taylor.rates, q->to + r->taylor.rates);
            to->constant[i] += t->coefficient * q->offset;
        } else {
            to->known[i] = NAN;
        }
    }
}

/* Take the numbers of the mode that a run is in into lane i. */
static void take_mode(Lanes *l, int i, Run *r)
{
    const Mode *m = r->mode;
    int k;
    l->runs[i] = r;
    l->modes[i] = m;
    l->k[i] = m->small.k;
    l->c[i] = m->small.c;
    l->offset[i] = m->small.offset;
    l->constant[i] = m->small_constants[0];
    l->constant_far[i] = m->small_constants[1];
    l->moves[i] = m->shape == TWO_FREE;
    l->mobility_far[i] = m->shape == TWO_FREE ? m->mobility[1] : 0.0;
    l->mass[i] = m->carried + r->m3;
    l->inertia[i] = r->inertia;
    l->unbalance[i] = r->unbalance;
    l->drag[i] = r->drag;
    l->stall[i] = r->M0;
    l->tolerance[i] = r->tolerance_exponent;
    for (k = 0; k < m->event_count && k < MOST_WATCHED; k++)
        watch(r, &m->events[k], &l->watched[k], i);
}

/* Take the state from which a run goes on into lane i, and begin its step. */
static void take_state(Lanes *l, int i, Run *r)
{
    const State *s = &r->state;
    int k;
    if (l->runs[i] != r || l->modes[i] != r->mode)
        take_mode(l, i, r);
    l->start[BODY][i] = s->x[0];
    l->start[BODY_RATE][i] = s->v[0];
    l->start[FAR][i] = r->bodies == 2 ? s->x[1] : 0.0;
    l->start[FAR_RATE][i] = r->bodies != 2 ? 0.0 : r->mode->shape == TWO_FREE ? s->v[1] : 0.0 + r->mode->drift[1];
    l->start[ANGLE][i] = s->phase;
    l->start[SPEED][i] = s->w;
    l->margin[i] = r->certificate.margin;
    l->t0[i] = s->t;
    for (k = 0; k < r->mode->event_count && k < MOST_WATCHED; k++)
        if (l->watched[k].known[i] >= 0)
            l->watched[k].known[i] = r->known[r->mode->events[k].key];
    taylor_open(r, s);
    r->taylor.nearest = 0.0;
}

/* Lanes in a vector of this processor, at most `widest`; 0 where there are none. */
int lanes_in_a_vector(int widest)
{
    return widest >= 8 && __builtin_cpu_supports("avx512f") ? 8 : widest >= 4 && __builtin_cpu_supports("avx2") ? 4 : 0;
}

/* Let those runs share lanes that are of the form of the first such one; as many lanes in a vector as this processor has, at most `widest`. */
void lanes_open(Lanes *l, Run **runs, int count, int widest)
{
    const Run *first = NULL;
    int i;
    memset(l, 0, sizeof *l);
    l->width = lanes_in_a_vector(widest);
    for (i = 0; i < count; i++) {
        Run *r = runs[i];
        r->abreast = l->width > 0 && r->has_motor && r->bodies <= 2 && !r->has_base && r->tangent == NULL;
        first = first || !r->abreast ? first : r;
        r->abreast = r->abreast && r->bodies == first->bodies && r->taylor.most == first->taylor.most;
    }
}

/* Whether the next step of a run that shares lanes is taken there: in a mode of a small scene, under no load. */
int suits_lanes(const Run *r)
{
    const Mode *m = r->mode;
    return m->shape != ANY && m->shape != FORMULAS && m->carried > 0 && m->tied_count == 0 && r->taylor.loaded_count == 0 &&
           r->taylor.rates == 3 && r->taylor.order == r->taylor.most && r->taylor.order > LEADING_TERMS;
}

/* The next step of each of RUNS_AT_ONCE runs whose bit of `waiting` is set. */
void lanes_step(Lanes *l, Run **runs, unsigned waiting)
{
    Real nothing[(SERIES + 1) * COLUMNS];
    Taylor none, *of[RUNS_AT_ONCE], *f = NULL;
    int i, second = FAR;
    if ((waiting & (waiting - 1)) == 0) { /* one alone */
        for (i = 0; !(waiting >> i & 1); i++)
            ;
        runs[i]->waits = 0;
        taylor_continue(runs[i], &runs[i]->state);
        return;
    }
    none.table = none.latest = nothing;
    l->watched_count = 0;
    for (i = 0; i < RUNS_AT_ONCE; i++) {
        of[i] = &none;
        if (waiting >> i & 1) {
            const int events = runs[i]->mode->event_count < MOST_WATCHED ? runs[i]->mode->event_count : MOST_WATCHED;
            take_state(l, i, runs[i]);
            l->watched_count = events > l->watched_count ? events : l->watched_count;
            of[i] = f = &runs[i]->taylor;
            second = runs[i]->bodies == 2 ? FAR : ANGLE;
        }
    }
    if (l->width == 8)
        steps_of_8(l, 0, f->inverse, f->most);
    for (i = 0; i < RUNS_AT_ONCE; i += 4)
        if (waiting >> i & 0xf) {
            if (l->width == 4)
                steps_of_4(l, i, f->inverse, f->most);
            give_tables(l, i, f->most + 3, second, FAR + ANGLE - second, of + i);
        }
    for (i = 0; i < RUNS_AT_ONCE; i++) {
        Run *r = runs[i];
        if (!(waiting >> i & 1))
            continue;
        r->waits = 0;
        if (l->regular[i]) {
            r->steps += 1;
            r->steps_beside += 1;
            r->taylor.h = l->h[i];
            r->taylor.clear = (unsigned)l->clear[i];
            r->taylor.latest_at = r->taylor.spin_rate_at = l->length[i];
            r->taylor.spin_rate = l->spin_rate[i];
        } else {
            taylor_continue(r, &r->state);
        }
    }
}
#else
int lanes_in_a_vector(int widest)
{
    (void)widest;
    return 0;
}

void lanes_open(Lanes *l, Run **runs, int count, int widest)
{
    int i;
    (void)widest;
    l->width = 0;
    for (i = 0; i < count; i++)
        runs[i]->abreast = 0;
}

int suits_lanes(const Run *r)
{
    (void)r;
    return 0;
}

void lanes_step(Lanes *l, Run **runs, unsigned waiting)
{
    (void)l;
    (void)runs;
    (void)waiting;
}
#endif
