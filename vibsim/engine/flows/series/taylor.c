/* The Taylor flow: any mode, polynomials of high order from step to step.
 *
 * Inside a mode the motion is analytic and its Taylor coefficients follow by recurrence from the balance of forces of each group
 * of bodies. One step gives the state to round-off and a polynomial that is the dense output and carries the event search.
 */
#include "certificate.h"
#include "engine.h"
#include "inlining.h"
#include "numbers.h"
#include "pair.h"

/* A step of order 20 at full tolerance takes at most 1.32 rad of the fastest rate (h^20 / 20! = 2^-53): there eight nodes miss
 * 5e-17 of the power of a velocity, (2 h)^16 (8!)^4 / (2 * 17 (16!)^3); 3e-15 at order 22.
 */
#define FEW_NODES_ORDER 20
/* Share of the numbers that a switch compares. A state came to its limit at a rounded time, so that they differ by less; a judgement. */
#define AT_LIMIT 0x1p-40

/* Sizes, step limits of the quadrature and inverses that all steps of a run share. */
void taylor_set(Run *r)
{
    Taylor *f = &r->taylor;
    int n;
    f->rates = r->bodies + 1 + r->rest_columns;
    f->stride = 2 * f->rates;
    f->longest = INFINITY;
    f->most = f->order;
    for (n = 0; n < r->harmonic_count; n++)
        f->longest = 3 / r->harmonics[n].omega < f->longest ? 3 / r->harmonics[n].omega : f->longest;
    f->few_nodes = f->order <= FEW_NODES_ORDER && f->longest == INFINITY;
    f->inverse[0] = 0.0;
    for (n = 1; n <= f->order + 2; n++)
        f->inverse[n] = 1 / (Real)n;
}

#ifdef FIXED_SERIES
/* Expand at `state` by the digits that the expansion before in this mode tells of. Where they do not suffice, those that this one tells
 * of are taken, and at last all words.
 */
static void expand_by_digits(Run *r, const State *state)
{
    enum { MOST_TRIES = 3 };
    Taylor *f = &r->taylor;
    double spare = -1;
    int tries;
    for (tries = 1; spare < 0; tries++) {
        f->scales = r->mode->scales.most > 0 && tries < MOST_TRIES ? &r->mode->scales : NULL;
        f->rest.first = 0;
        spare = f->scales ? -1 : 0;
        taylor_expand(r, state);
        f->h = step_length(r);
        if (spare < 0)
            spare = bits_to_spare(r);
        set_digits(r, spare);
    }
}
#endif

/* Begin a step at `state`, of which nothing is known yet. */
void taylor_open(Run *r, const State *state)
{
    Taylor *f = &r->taylor;
    r->closed = 0;
    r->t0 = state->t;
    f->checked_at = f->latest_at = f->spin_rate_at = 0.0;
    f->turns = state->turns;
    f->clear = 0;
}

/* Expand the motion at `state` in the mode of now. What is tied to the ground or the base moves as that does and as belts carry
 * it; belts by formulas are in its velocity already.
 */
INLINE void expand_at(Run *r, const State *state)
{
    Taylor *f = &r->taylor;
    const Mode *m = r->mode;
    Real *first = f->table, *rates = first + f->rates;
    int c;
    taylor_open(r, state);
    if (r->has_base)
        taylor_expand_base(r, state->t);
    for (c = 0; c < r->bodies; c++) {
        int leader = m->leader[c];
        first[c] = state->x[c];
        rates[c] = leader < r->bodies ? state->v[c] : (leader == r->bodies ? 0.0 : rates[base_column(r)]) + m->drift[c];
    }
    for (c = 0; c < m->follower_count; c++)
        rates[m->followers[c].column] = state->v[m->followers[c].column];
    if (f->loaded_count > 0)
        taylor_expand_loads(r, state->t);
#ifdef FIXED_SERIES
    f->fixed->made = 0;
    if (r->has_motor) {
        expand_by_digits(r, state);
        return;
    }
    f->scales = NULL;
#endif
    taylor_expand(r, state);
    f->h = step_length(r);
}

void taylor_look(Run *r, const State *state)
{
    r->taylor.nearest = 0.0;
#ifndef WORDS_BY_RUN
    r->taylor.order = r->taylor.most;
#endif
    expand_at(r, state);
}

/* Expand the motion at `state`; 0 where a signal has ended that before the last order. */
static int expand_unless_interrupted(Run *r, const State *state)
{
    r->hears = 1;
    expand_at(r, state);
    r->hears = 0;
    return !r->interrupted;
}

/* Whether the series of the base, by a formula with powers, overflow. */
static int base_overflows(const Run *r)
{
    const Taylor *f = &r->taylor;
    return r->mode->base_tape.powers && !isfinite(f->table[(f->order + 1) * f->stride + f->rates + base_column(r)]);
}

/* Expand the motion at `state` for a step. With formulas the step is shortened until at its end they agree with their series;
 * where that fails because the series of a power overflow near a zero of its base, once more with that zero taken to be here.
 */
static void take_step(Run *r, const State *state)
{
    Taylor *f = &r->taylor;
    f->nearest = 0.0;
    if (!expand_unless_interrupted(r, state))
        return;
    r->steps += 1;
    if (r->mode->tape.op_count == 0)
        return;
    shorten_step(r);
    tune_order(r);
    if (base_overflows(r))
        f->nearest = overflowing_zero(&r->mode->base_tape, &f->base_tapes, f->order + 3);
    else if (r->status == SINGULAR)
        f->nearest = overflowing_zero(&r->mode->tape, &f->tapes, f->order);
    if (f->nearest > 0) {
        r->status = OK;
        if (expand_unless_interrupted(r, state))
            shorten_step(r);
    }
}

void taylor_enter(Run *r, const State *state)
{
    Taylor *f = &r->taylor;
    f->order = f->next = f->most;
    f->since = 0;
    take_step(r, state);
}

void taylor_continue(Run *r, const State *state)
{
    r->taylor.order = r->taylor.next;
    take_step(r, state);
}

/* Value, slope and rounding bound of an event function at tau, but for its known zeros; 0 where it rests at zero. */
int taylor_near_zero(const Run *r, const Event *e, Real tau, Real *value, Real *slope, Real *noise)
{
    Series coefficients;
    int count = taylor_polynomial(r, e, coefficients);
    return polynomial_near_zero(coefficients, count, r->known[e->key], tau, taylor_magnitude(r, e), value, slope, noise);
}

/* Whether a function falls from where it is: its first coefficient that is not zero is negative. */
static int closes(const Real *coefficients, int count)
{
    int n = 0;
    while (n < count && coefficients[n] == 0)
        n++;
    return n < count && coefficients[n] < 0;
}

/* Whether the base or a belt moves by a formula. Who decides what follows an event takes their velocities on the side of a switch that the
 * time is on, whichever side the mode still is on.
 */
static int moved_by_formula(const Mode *m)
{
    int i;
    for (i = 0; i < m->event_count; i++) {
        const Event *e = &m->events[i];
        if (e->kind == SLIDE && e->terms > 1)
            return 1;
    }
    return m->base_values.op_count > 0 || m->follower_count > 0;
}

/* Whether event function number i is among those that stay positive on the whole step. */
static int is_clear(unsigned clear, int i)
{
    return i < MOST_WATCHED && clear >> i & 1;
}

/* Doubt that the zero of `first`, at time `end`, is the first, where that of another event may come as soon. A touch is in doubt
 * by itself. Returns the event to be taken: a switch that is due there as well goes before all others where it may move base or belts.
 */
static int certify_order(Run *r, int first, Real end)
{
    const Mode *m = r->mode;
    Real tau = end - r->t0, value = 0, slope = 0, noise = 0, other, fall, blur, latest;
    unsigned clear;
    int chosen = first, i;
    taylor_near_zero(r, &m->events[first], tau, &value, &slope, &noise);
    if (slope >= 0)
        return first;
    latest = latest_zero(value, slope, noise, end);
    clear = latest <= r->t0 + r->taylor.h ? r->taylor.clear : 0;
    for (i = 0; i < m->event_count; i++) {
        const Event *e = &m->events[i];
        if (i == first || is_clear(clear, i) || !taylor_near_zero(r, e, tau, &other, &fall, &blur) ||
            !may_vanish_by(other, fall, blur, latest))
            continue;
        if (!(other == value && fall == slope) || order_is_open(r, &m->events[first], e))
            doubt(&r->certificate, r->t0, end, WHICH_IS_FIRST, first, i);
        if (e->kind == SWITCH && m->events[chosen].kind != SWITCH && end + other / -fall <= end && moved_by_formula(m))
            chosen = i;
    }
    return chosen;
}

/* Whether what a switch reads does not change, at zero but for what rounding has left: it turns neither now nor in this step. So is
 * a state that rests at the limit which the switch compares it with.
 */
static int rests_at_limit(const Run *r, const Event *e, const Real *coefficients, int count)
{
    int n = 1;
    if (e->kind != SWITCH)
        return 0;
    while (n < count && coefficients[n] == 0)
        n++;
    return n >= count && fabs(coefficients[0]) <= AT_LIMIT * taylor_magnitude(r, e);
}

/* One step to its end, to the first event within it or to `limit`; returns the time, and in `event` its number or NOTHING. A rigid
 * stop that closes from exactly zero is struck at the start of the step. Each zero that is found shortens the step for the event
 * functions behind it.
 */
Real taylor_advance(Run *r, Real limit, int *event)
{
    const Taylor *f = &r->taylor;
    const Mode *m = r->mode;
    Real length = limit - r->t0, h = f->h < length ? f->h : length;
    Real end = f->h >= length ? limit : r->t0 + h, t = 0;
    Series coefficients;
    int i;
    *event = NOTHING;
    if (end <= r->t0) {
        doubt(&r->certificate, r->t0, r->t0, TOO_SHORT_STEPS, NOTHING, NOTHING);
        return nextafter(r->t0, INFINITY);
    }
    for (i = 0; i < m->event_count; i++) {
        const Event *e = &m->events[i];
        int count, outcome;
        if (is_clear(f->clear, i))
            continue;
        count = taylor_polynomial(r, e, coefficients);
        if (e->kind == STRIKE && r->known[e->key] == 0 && coefficients[0] == 0 && closes(coefficients, count)) {
            *event = i;
            return r->t0;
        }
        if (e->kind == STRIKE && r->known[e->key] == 0) {
            Real nearer = polynomial_nearer(coefficients, count, r->t0, h, taylor_magnitude(r, e));
            if (nearer < h) {
                end = r->t0 + nearer;
                *event = NOTHING;
                h = end - r->t0;
            }
        }
        if (rests_at_limit(r, e, coefficients, count))
            continue;
        r->certificate.watched = i;
        outcome = polynomial_first_root(&r->certificate, coefficients, count, r->known[e->key], r->t0, h, e->turns,
                                        e->kind == STRIKE, &t);
        r->spent += outcome == UNFINISHED ? MARCH_LIMIT : 0;
        if (outcome != POSITIVE && (t < end || (outcome == ZERO && *event == NOTHING))) {
            end = t;
            *event = outcome == ZERO ? i : NOTHING;
            h = end - r->t0;
        }
        if (h == 0) /* an event at the start: no other can come before it */
            break;
    }
    if (*event != NOTHING)
        *event = certify_order(r, *event, end);
    return end;
}

enum { SMALL_PAIRS = 3, MOST_PAIRS = 4, MOST_TIMES = 2 }; /* SMALL_PAIRS: of columns of a small scene */

/* Columns of the table at `times` times tau, `horner` row by row: `count` pairs of columns; one time is `apart` from the other. */
INLINE void dense_block(const Real *table, int rows, const int count, int stride, const int times, const Real *tau, Real *out, int apart)
{
    const Real *row = table + (rows - 1) * stride;
    Pair high[MOST_PAIRS][MOST_TIMES], low[MOST_PAIRS][MOST_TIMES], time[MOST_TIMES], square[MOST_TIMES];
    int n, k, i;
    for (i = 0; i < times; i++) {
        time[i] = twice(tau[i]);
        square[i] = twice(tau[i] * tau[i]);
    }
    for (k = 0; k < count; k++)
        for (i = 0; i < times; i++) {
            high[k][i] = load_pair(row + 2 * k);
            low[k][i] = load_pair(row - stride + 2 * k);
        }
    row -= 2 * stride;
    for (n = rows - 3; n > 0; n -= 2, row -= 2 * stride)
        for (k = 0; k < count; k++) {
            const Pair first = load_pair(row + 2 * k), second = load_pair(row - stride + 2 * k);
            for (i = 0; i < times; i++) {
                high[k][i] = add_product(first, high[k][i], square[i]);
                low[k][i] = add_product(second, low[k][i], square[i]);
            }
        }
    for (k = 0; k < count; k++)
        for (i = 0; i < times; i++) {
            if (rows % 2 != 0)
                high[k][i] = add_product(load_pair(table + 2 * k), high[k][i], square[i]);
            store_pair(out + i * apart + 2 * k,
                       rows % 2 == 0 ? add_product(low[k][i], time[i], high[k][i]) : add_product(high[k][i], time[i], low[k][i]));
        }
}

/* All columns of the table at `times` times; small scenes at once, others by blocks of columns. */
INLINE void dense_rows(const Taylor *f, const int times, const Real *tau, Real *out)
{
    int rows = f->order + 2, pairs = f->stride / 2, k;
    if (pairs == SMALL_PAIRS) {
        dense_block(f->table, rows, SMALL_PAIRS, 2 * SMALL_PAIRS, times, tau, out, 2 * SMALL_PAIRS);
        return;
    }
    for (k = 0; k + MOST_PAIRS <= pairs; k += MOST_PAIRS, out += 2 * MOST_PAIRS)
        dense_block(f->table + 2 * k, rows, MOST_PAIRS, f->stride, times, tau, out, f->stride);
    for (; k < pairs; k++, out += 2)
        dense_block(f->table + 2 * k, rows, 1, f->stride, times, tau, out, f->stride);
}

#ifdef FIXED_SERIES
/* Value of one column, `horner` as `dense_block` does. */
APART Real column_value(const Taylor *f, int c, const Real &tau)
{
    Series coefficients;
    int n;
    for (n = 0; n < f->order + 2; n++)
        coefficients[n] = f->table[n * f->stride + c];
    return horner(coefficients, f->order + 2, tau);
}

void taylor_values(const Taylor *f, Real tau, Real *out)
{
    uint64_t time[LIMBS];
    int c;
    if (!f->fixed->made && isfinite(f->h) && f->h > 0)
        fixed_table_make(f->fixed, f->table, f->order + 2, f->stride, f->h);
    if (!f->fixed->made || !fixed_time(f->fixed, tau, time)) {
        dense_rows(f, 1, &tau, out);
        return;
    }
    for (c = 0; c < f->rates; c++) {
        int right = fixed_values(f->fixed, time, f->order + 2, c, f->rates, &out[c], &out[c + f->rates]);
        if (!(right & 1))
            out[c] = column_value(f, c, tau);
        if (!(right & 2))
            out[c + f->rates] = column_value(f, c + f->rates, tau);
    }
}

void taylor_values_twice(const Taylor *f, const Real *tau, Real *out)
{
    taylor_values(f, tau[0], out);
    taylor_values(f, tau[1], out + f->stride);
}
#else
void taylor_values(const Taylor *f, Real tau, Real *out)
{
    dense_rows(f, 1, &tau, out);
}

void taylor_values_twice(const Taylor *f, const Real *tau, Real *out)
{
    dense_rows(f, 2, tau, out);
}
#endif

/* Rate of the speed of the rotor; at the expansion point the first coefficient, as above. */
Real taylor_spin_rate(const Run *r, Real tau)
{
    const Taylor *f = &r->taylor;
    const Real *w = f->table + f->rates + r->bodies;
    Real rate = f->order * w[f->order * f->stride];
    int n;
#ifndef LIMBS
    if (tau == 0 && w[f->stride] != 0)
        return w[f->stride];
    if (tau != 0 && tau == f->spin_rate_at)
        return f->spin_rate;
#endif
    for (n = f->order - 1; n > 0; n--)
        rate = rate * tau + n * w[n * f->stride];
    return rate;
}

/* One row of the table into a column of samples, as `write_state` does. */
static void write_values(const Run *r, const Real *values, Real *column, long room)
{
    const Taylor *f = &r->taylor;
    const Real *rates = values + f->rates;
    const int n = r->bodies;
    int c;
    for (c = 0; c < n; c++) {
        column[(1 + 2 * c) * room] = values[c];
        column[(2 + 2 * c) * room] = rates[c];
    }
    column[(1 + 2 * n) * room] = column[(2 + 2 * n) * room] = 0.0;
    if (r->has_motor) {
        Real turns, phase = reduce_angle(values[n], &turns);
        column[(1 + 2 * n) * room] = unwind(phase, f->turns + turns);
        column[(2 + 2 * n) * room] = rates[n];
    }
}

/* Writes states at times tau of the step into rows as `write_state` does. */
void taylor_samples(Run *r, const Real *tau, int count, Real *row, long room)
{
    const Taylor *f = &r->taylor;
    Real two[MOST_TIMES * 2 * SMALL_PAIRS];
    int i = 0;
    for (; f->stride == 2 * SMALL_PAIRS && i + 2 <= count; i += 2) {
        taylor_values_twice(f, tau + i, two);
        write_values(r, two, row + i, room);
        write_values(r, two + 2 * SMALL_PAIRS, row + i + 1, room);
    }
    for (; i < count; i++) {
        taylor_values(f, tau[i], f->values);
        write_values(r, f->values, row + i, room);
    }
}

/* All columns of the table a time tau after the expansion point, which need not be on the grid of time. Where formulas were compared
 * there already, or the columns were asked for last, the values of then serve.
 */
const Real *taylor_columns(Run *r, Real tau)
{
    Taylor *f = &r->taylor;
    if (tau != 0 && tau == f->checked_at)
        return f->checked;
    if (tau == 0 || tau != f->latest_at) {
        taylor_values(f, tau, f->latest);
        f->latest_at = tau;
    }
    return f->latest;
}

/* The same at the expansion point. In doubles they are the first coefficients: the others add 0, which changes nothing but the sign
 * of a zero, and would leave no number of a motion that diverges.
 */
const Real *taylor_columns_at_start(Run *r)
{
#ifndef LIMBS
    const Taylor *f = &r->taylor;
    int c, signs = 0;
    for (c = 0; c < f->stride; c++)
        signs |= f->table[c] == 0 && signbit(f->table[c]);
    if (!signs)
        return f->table;
#endif
    return taylor_columns(r, 0.0);
}

void taylor_state_after(Run *r, Real tau, State *out)
{
    const Taylor *f = &r->taylor;
    const Real *values = taylor_columns(r, tau), *rates = values + f->rates;
    Real turns;
    int c;
    out->t = r->t0 + tau;
    for (c = 0; c < r->bodies; c++) {
        out->x[c] = values[c];
        out->v[c] = rates[c];
    }
    out->phase = out->turns = out->w = 0.0;
    if (r->has_motor) {
        out->phase = reduce_angle(values[r->bodies], &turns);
        out->turns = f->turns + turns;
        out->w = rates[r->bodies];
    }
}
