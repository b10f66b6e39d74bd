/* The Taylor flow; twin of vibsim/engine/taylor.py. */
#include <string.h>

#include "certificate.h"
#include "engine.h"
#include "numbers.h"
#include "pair.h"

#define LEADING 4
#define INLINE static inline __attribute__((always_inline))

void taylor_set(Run *r)
{
    Taylor *f = &r->taylor;
    int n;
    f->unbalance = r->has_motor ? r->m3 * r->e : 0.0;
    f->inverse[0] = 0.0;
    for (n = 1; n <= f->order + 2; n++)
        f->inverse[n] = 1 / (double)n;
    if (r->has_motor) {
        f->drag = r->M0 / r->Omega0;
        f->inertia = r->J + f->unbalance * r->e;
    }
}

static void sine_and_cosine(const Harmonic *term, double t, double *turns)
{
    double angle = turn_angle(term->cycles, term->cycles_lo, t) + term->phase;
    turns[0] = sin(angle);
    turns[1] = cos(angle);
    turns[2] = -turns[0];
    turns[3] = -turns[1];
}

static void expand_base(Run *r, double t)
{
    Taylor *f = &r->taylor;
    int stride = 2 * r->columns, at = r->columns - 1, i, k;
    for (i = 0; i < r->base_count; i++) {
        const Harmonic *term = &r->base[i];
        double turns[4], factor = term->amplitude, *row = f->table;
        sine_and_cosine(term, t, turns);
        for (k = 0; k < f->order + 2; k++, row += stride) {
            row[at] = row[at] + factor * turns[k % 4];
            factor = factor * term->omega;
            row[r->columns + at] = row[r->columns + at] + factor * turns[(k + 1) % 4];
            factor = factor * f->inverse[k + 1 < f->order + 2 ? k + 1 : f->order + 2];
        }
    }
}

static void expand_loads(Run *r, double t)
{
    Taylor *f = &r->taylor;
    int i, j, k;
    for (i = 0; i < f->loaded_count; i++)
        memset(f->load + f->loaded[i] * SERIES, 0, sizeof(double) * (size_t)f->order);
    for (i = 0; i < r->force_count; i++) {
        const Force *force = &r->forces[i];
        double *series = f->load + force->on * SERIES;
        for (j = 0; j < force->count; j++) {
            const Harmonic *term = &force->terms[j];
            double turns[4], factor = term->amplitude;
            sine_and_cosine(term, t, turns);
            for (k = 0; k < f->order; k++) {
                series[k] = series[k] + factor * turns[k % 4];
                factor = factor * term->omega * f->inverse[k + 1];
            }
        }
        series[0] = series[0] + force->constant;
    }
}

/* Coefficient n of the force of a coupling. */
INLINE double coupling_force(const Coupling *c, const double *row, int P, int Q, int columns, int n)
{
    double force = c->k * (row[P] - row[Q]) + c->c * (row[columns + P] - row[columns + Q]);
    return n == 0 ? force + c->offset : force;
}

/* All orders; `bodies` and `pair` (the one coupling there may be joins columns 0 and 1) are known at compile time where
 * the scene is small.
 */
INLINE void expand_orders(Run *r, const int bodies, const int pair, const int motor)
{
    Taylor *f = &r->taylor;
    const Mode *m = r->mode;
    const int p = f->order, columns = bodies + 2, stride = 2 * columns;
    const int couplings = m->coupling_count, on = motor ? m->leader[r->motor_on] : 0;
    const double unbalance = f->unbalance, drag = f->drag, carried = m->carried;
    double small[4], *F = pair ? small : r->force, *row = f->table, *last;
    double *sine = f->sine, *cosine = f->cosine, *w = f->w, *w_back = f->w_back, *a1_back = f->a1_back;
    double coupling = 0, to_a1 = 0, to_w = 0, cross = 0, sw = 0, previous = 0, tail = 0, torque = 0;
    int n, i, c;
    if (motor) {
        coupling = unbalance * sine[0];
        if (carried > 0) {
            double mass = carried + r->m3, inverse_det = 1 / (mass * f->inertia - coupling * coupling);
            to_a1 = f->inertia * inverse_det;
            to_w = mass * inverse_det;
            cross = coupling * inverse_det;
        }
        sw = sine[0] * w[0];
    }
    for (n = 0; n < p; n++, row += stride) {
        const double inverse = f->inverse[n + 1];
        double *next = row + stride;
        for (c = 0; c < columns; c++)
            F[c] = 0.0;
        if (motor) {
            const double *wn = w_back + (p - n), *an = a1_back + (p + 1 - n); /* wn[i] = w[n - i], an[i] = a1[n - 1 - i] */
            Pair cws = make_pair(0, 0), tails = cws, backs = cws;
            double cw, back;
            for (i = 1; i + 1 < n; i += 2) {
                Pair speeds = load_pair(wn + i), sines = load_pair(sine + i + 1);
                cws = add_product(cws, load_pair(cosine + i), speeds);
                tails = add_product(tails, sines, speeds);
                backs = add_product(backs, sines, load_pair(an + i));
            }
            if (i < n) { /* the odd chain has one term more; the even one adds 0 * 0 */
                Pair speed = make_pair(wn[i], 0), following = make_pair(sine[i + 1], 0);
                cws = add_product(cws, make_pair(cosine[i], 0), speed);
                tails = add_product(tails, following, speed);
                backs = add_product(backs, following, make_pair(an[i], 0));
            }
            cw = sum_of_pair(cws);
            tail = sum_of_pair(tails);
            back = sum_of_pair(backs);
            cosine[n + 1] = -(sw * inverse);
            if (n > 0) {
                cw = cw + (cosine[0] * w[n] + cosine[n] * w[0]);
                tail = tail + sine[1] * w[n];
                back = back + sine[1] * previous;
            } else {
                cw = cosine[0] * w[0];
            }
            sine[n + 1] = cw * inverse;
            tail = tail + sine[n + 1] * w[0];
            torque = unbalance * back - drag * w[n];
            if (n == 0)
                torque = torque + r->M0;
            F[on] = F[on] + unbalance * ((n + 1) * tail);
        }
        for (i = 0; i < f->loaded_count; i++) {
            int column = f->loaded[i];
            F[m->leader[column]] = F[m->leader[column]] + f->load[column * SERIES + n];
        }
        if (pair) {
            if (couplings > 0) {
                double force = coupling_force(m->couplings, row, 0, 1, columns, n);
                F[0] = F[0] - force;
                F[1] = F[1] + force;
            }
        } else {
            for (i = 0; i < couplings; i++) {
                const Coupling *q = &m->couplings[i];
                double force = coupling_force(q, row, q->P, q->Q, columns, n);
                F[q->to_P] = F[q->to_P] - force;
                F[q->to_Q] = F[q->to_Q] + force;
            }
        }
        if (n == 0)
            for (i = 0; i < m->constant_count; i++) {
                int to = m->leader[m->constant_columns[i]];
                F[to] = F[to] + m->constants[i];
            }
        if (motor) {
            double thrust = F[on];
            if (carried > 0) {
                previous = to_a1 * thrust + cross * torque;
                w[n + 1] = (to_w * torque + cross * thrust) * inverse;
            } else {
                previous = on == columns - 1 ? (n + 1) * next[columns + columns - 1] : 0.0;
                w[n + 1] = (torque + coupling * previous) / f->inertia * inverse;
            }
            w_back[p - n - 1] = w[n + 1];
            a1_back[p - n] = f->a1[n] = previous;
            f->phi[n + 1] = w[n] * inverse;
            sw = tail + sine[0] * w[n + 1];
        }
        for (c = 0; c < bodies; c++) {
            const int leader = m->leader[c];
            next[c] = row[columns + c] * inverse;
            if (leader >= bodies)
                next[columns + c] = leader == bodies ? 0.0 : next[columns + columns - 1];
            else
                next[columns + c] = motor && leader == on ? previous * inverse : F[leader] * m->mobility[leader] * inverse;
        }
    }
    last = row + stride;
    for (c = 0; c < bodies; c++) {
        last[c] = row[columns + c] * f->inverse[p + 1];
        last[columns + c] = 0.0;
    }
    if (motor)
        f->phi[p + 1] = w[p] * f->inverse[p + 1];
}

#define SHAPE __attribute__((noinline)) static void
SHAPE expand_two(Run *r) { expand_orders(r, 2, 1, 0); }
SHAPE expand_two_with_motor(Run *r) { expand_orders(r, 2, 1, 1); }
SHAPE expand_any(Run *r) { expand_orders(r, r->bodies, 0, 0); }
SHAPE expand_any_with_motor(Run *r) { expand_orders(r, r->bodies, 0, 1); }

static int block_size(const Run *r, const double *row)
{
    double total = fabs(row[r->columns]);
    int c;
    for (c = 1; c < r->bodies; c++)
        total = total + fabs(row[r->columns + c]);
    if (r->base_count > 0)
        total = total + fabs(row[2 * r->columns - 1]);
    return binary_exponent(total);
}

static double longest_step(const Run *r, const int *leading, const int *following, double longest)
{
    int order = r->taylor.order, i, m;
    for (i = 0; i < 2; i++) {
        int last = order - 1 + i;
        if (following[i] > -2000) {
            double best = (r->tolerance_exponent + (leading[0] - following[i])) / last;
            for (m = 1; m < LEADING; m++) {
                double candidate = (r->tolerance_exponent + (leading[m] - following[i])) / (last - m);
                best = candidate > best ? candidate : best;
            }
            longest = best < longest ? best : longest;
        }
    }
    return longest;
}

static double step_length(const Run *r)
{
    const Taylor *f = &r->taylor;
    int leading[LEADING], following[2], m, stride = 2 * r->columns;
    double longest = 1000.0;
    for (m = 0; m < LEADING; m++)
        leading[m] = block_size(r, f->table + m * stride);
    for (m = 0; m < 2; m++)
        following[m] = block_size(r, f->table + (f->order - 1 + m) * stride);
    longest = longest_step(r, leading, following, longest);
    if (r->has_motor) {
        for (m = 0; m < LEADING; m++)
            leading[m] = binary_exponent(fabs(f->w[m]));
        for (m = 0; m < 2; m++)
            following[m] = binary_exponent(fabs(f->w[f->order - 1 + m]));
        longest = longest_step(r, leading, following, longest);
    }
    return longest < 1000.0 ? power_of_two(longest) : INFINITY;
}

void taylor_enter(Run *r, const State *state)
{
    Taylor *f = &r->taylor;
    const Mode *m = r->mode;
    int columns = r->columns, c;
    double *first = f->table;
    r->closed = 0;
    r->t0 = state->t;
    f->turns = state->turns;
    if (r->base_count > 0) {
        int k, stride = 2 * columns;
        for (k = 0; k < f->order + 2; k++)
            f->table[k * stride + columns - 1] = f->table[k * stride + 2 * columns - 1] = 0.0;
        expand_base(r, state->t);
    }
    for (c = 0; c < r->bodies; c++) {
        int leader = m->leader[c];
        first[c] = state->x[c];
        first[columns + c] = leader >= r->bodies ? first[columns + leader] + m->drift[c] : state->v[c];
    }
    expand_loads(r, state->t);
    if (r->has_motor) {
        f->w[0] = f->w_back[f->order] = state->w;
        f->phi[0] = state->phase;
        f->sine[0] = sin(state->phase);
        f->cosine[0] = cos(state->phase);
    }
    if (m->simple)
        (r->has_motor ? expand_two_with_motor : expand_two)(r);
    else
        (r->has_motor ? expand_any_with_motor : expand_any)(r);
    r->steps += 1;
    f->h = step_length(r);
}

/* Series of the load on a column: its forces, and what a motor on it exerts while it is tied to the ground or the base. */
static void load_on(const Run *r, int column, double *out)
{
    const Taylor *f = &r->taylor;
    double sw[SERIES];
    int n, i;
    for (n = 0; n < f->order; n++)
        out[n] = f->load[column * SERIES + n];
    if (!r->has_motor || r->motor_on != column)
        return;
    for (n = 0; n <= f->order; n++) {
        sw[n] = 0.0;
        for (i = 0; i <= n; i++)
            sw[n] = sw[n] + f->sine[i] * f->w[n - i];
    }
    for (n = 0; n < f->order; n++)
        out[n] = out[n] + (f->unbalance * ((n + 1) * sw[n + 1]) - r->m3 * f->a1[n]);
}

/* Coefficients of a term over the step; returns their number. */
static int term_series(const Run *r, const Term *t, double *out)
{
    const Taylor *f = &r->taylor;
    const int p = f->order, columns = r->columns, stride = 2 * columns;
    const double *row = f->table, factor = t->coefficient;
    int n;
    switch (t->kind) {
    case DIFFERENCE:
        for (n = 0; n < p + 2; n++, row += stride)
            out[n] = factor * (row[t->P] - row[t->Q]);
        return p + 2;
    case RATE:
        row += columns;
        for (n = 0; n < p + 1; n++, row += stride)
            out[n] = factor * (row[t->P] - row[t->Q]);
        return p + 1;
    case COUPLING: {
        const Coupling *c = &r->mode->couplings[t->P];
        for (n = 0; n < p + 1; n++, row += stride)
            out[n] = factor * coupling_force(c, row, c->P, c->Q, columns, n);
        return p + 1;
    }
    case ACCELERATION:
        row += columns + stride;
        for (n = 0; n < p; n++, row += stride)
            out[n] = factor * ((n + 1) * row[t->P]);
        return p;
    default:
        load_on(r, t->P, out);
        for (n = 0; n < p; n++)
            out[n] = factor * out[n];
        return p;
    }
}

/* Coefficients of an event function over the step; returns their number. */
int taylor_polynomial(const Run *r, const Event *e, double *out)
{
    double more[SERIES];
    int count, i, n;
    if (e->terms == 0) {
        memset(out, 0, sizeof(double) * (size_t)(r->taylor.order + 1));
        out[0] = e->constant;
        return r->taylor.order + 1;
    }
    count = term_series(r, r->mode->terms + e->first, out);
    for (i = 1; i < e->terms; i++) {
        int other = term_series(r, r->mode->terms + e->first + i, more);
        count = other < count ? other : count;
        for (n = 0; n < count; n++)
            out[n] = out[n] + more[n];
    }
    out[0] = out[0] + e->constant;
    return count;
}

double taylor_advance(Run *r, double limit, int *event)
{
    const Taylor *f = &r->taylor;
    const Mode *m = r->mode;
    double length = limit - r->t0, h = f->h < length ? f->h : length;
    double end = f->h >= length ? limit : r->t0 + h, coefficients[SERIES], t = 0;
    int i;
    *event = NOTHING;
    if (end <= r->t0) {
        doubt(&r->certificate, r->t0);
        return nextafter(r->t0, INFINITY);
    }
    for (i = 0; i < m->event_count; i++) {
        const Event *e = &m->events[i];
        int count = taylor_polynomial(r, e, coefficients);
        int outcome = polynomial_first_root(&r->certificate, coefficients, count, r->known[e->key], r->t0, h, e->turns, &t);
        if (outcome != POSITIVE && (t < end || (outcome == ZERO && *event == NOTHING))) {
            end = t;
            *event = outcome == ZERO ? i : NOTHING;
            h = end - r->t0;
        }
        if (h == 0) /* an event at the start: no other can come before it */
            break;
    }
    return end;
}

/* `count` neighbouring columns of the table at tau: `horner` row by row. */
INLINE void dense_block(const double *table, int rows, const int count, int stride, double tau, double *out)
{
    double square = tau * tau, high[4], low[4];
    int n, k;
    for (k = 0; k < count; k++) {
        high[k] = table[(rows - 1) * stride + k];
        low[k] = table[(rows - 2) * stride + k];
    }
    for (n = rows - 3; n > 0; n -= 2) {
        for (k = 0; k < count; k++)
            high[k] = high[k] * square + table[n * stride + k];
        for (k = 0; k < count; k++)
            low[k] = low[k] * square + table[(n - 1) * stride + k];
    }
    for (k = 0; k < count; k++)
        out[k] = rows % 2 == 0 ? low[k] + tau * high[k] : (high[k] * square + table[k]) + tau * low[k];
}

static void dense_columns(const Run *r, int first, double tau, double *out)
{
    const Taylor *f = &r->taylor;
    int rows = f->order + 2, stride = 2 * r->columns, c = 0;
    for (; c + 2 <= r->bodies; c += 2)
        dense_block(f->table + first + c, rows, 2, stride, tau, out + c);
    if (c < r->bodies)
        dense_block(f->table + first + c, rows, 1, stride, tau, out + c);
}

void taylor_state_after(Run *r, double tau, State *out)
{
    Taylor *f = &r->taylor;
    double turns;
    out->t = r->t0 + tau;
    dense_columns(r, 0, tau, out->x);
    dense_columns(r, r->columns, tau, out->v);
    out->phase = out->turns = out->w = 0.0;
    if (r->has_motor) {
        f->w[f->order + 1] = 0.0;
        out->phase = reduce_angle(horner(f->phi, f->order + 2, tau), &turns);
        out->turns = f->turns + turns;
        out->w = horner(f->w, f->order + 2, tau);
    }
}
