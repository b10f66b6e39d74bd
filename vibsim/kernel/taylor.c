/* The Taylor flow; twin of vibsim/flows/taylor.py. */
#include <string.h>

#include "certificate.h"
#include "kernel.h"
#include "../engine/numbers.h"
#include "../engine/pair.h"

#define LEADING 4
#define WORK_OF_A_STEP 10 /* in evaluations of its polynomials */

void taylor_set(Run *r)
{
    const Scene *s = &r->scene;
    Taylor *f = &r->taylor;
    int n;
    f->order = (int)s->order;
    f->limit = s->has_friction != 0 ? s->N : 0.0;
    f->unbalance = s->has_motor != 0 ? s->m3 * s->e : 0.0;
    f->inverse[0] = 0.0;
    f->per_m1 = 1 / s->m1;
    f->per_m2 = s->has_block2 != 0 ? 1 / s->m2 : 0.0;
    for (n = 1; n <= SERIES; n++)
        f->inverse[n] = 1 / (double)n;
}

/* What the recurrences read, in locals: the compiler then knows that no store to the table changes it. */
typedef struct {
    double k, c, offset, friction, per_m2;
    int locked, rubs;
} Law;

static Law law_of(const Run *r, Mode mode)
{
    const Taylor *f = &r->taylor;
    Law law;
    law.k = f->k;
    law.c = r->scene.c;
    law.offset = f->offset;
    law.friction = mode.friction * f->limit;
    law.per_m2 = f->per_m2;
    law.locked = f->locked;
    law.rubs = r->scene.has_friction != 0;
    return law;
}

static inline double force_coefficient(const Law *law, const double *row, int n)
{
    double force = law->k * (row[X1] - row[X2]) + law->c * (row[V1] - row[V2]);
    return n == 0 ? force + law->offset : force;
}

static inline void advance_series(const Law *law, const double *row, double *next, int n, double inverse, double a1,
                                  double force)
{
    next[X1] = row[V1] * inverse;
    next[V1] = a1 * inverse;
    next[X2] = next[V2] = 0.0;
    if (!law->locked) {
        if (n == 0 && law->rubs)
            force = force - law->friction;
        next[X2] = row[V2] * inverse;
        next[V2] = force * law->per_m2 * inverse;
    }
}

static void expand_ideal(Run *r, const State *state, Law law)
{
    const Scene *s = &r->scene;
    Taylor *f = &r->taylor;
    double loads[4] = {0, 0, 0, 0}, factor = 0;
    int harmonic = s->harmonic != 0, n;
    if (harmonic) {
        double angle = turn_angle(s->cycles, s->cycles_lo, state->t);
        double sine = sin(angle), cosine = cos(angle);
        loads[0] = sine;
        loads[1] = cosine;
        loads[2] = -sine;
        loads[3] = -cosine;
        factor = s->A;
    }
    for (n = 0; n < f->order; n++) {
        double force = force_coefficient(&law, f->table[n], n), load = factor * loads[n % 4];
        if (n == 0 && harmonic)
            load = load + s->F0;
        advance_series(&law, f->table[n], f->table[n + 1], n, f->inverse[n + 1], (load - force) * f->per_m1, force);
        if (harmonic)
            factor = factor * s->omega * f->inverse[n + 1];
    }
}

static void expand_motor(Run *r, const State *state, Law law)
{
    const Scene *s = &r->scene;
    Taylor *f = &r->taylor;
    double sine[SERIES], cosine[SERIES], w[SERIES], w_back[SERIES], a1_back[SERIES], (*table)[STATES] = f->table;
    double mass = s->m1 + s->m3, inertia = s->J + f->unbalance * s->e, unbalance = f->unbalance;
    double coupling, inverse_det, drag, stall = s->M0, sw, to_a1, to_w, cross, previous = 0;
    int p = f->order, n, i;
    w[0] = w_back[p] = table[0][W] = state->w;
    table[0][PHI] = state->phase;
    sine[0] = sin(state->phase);
    cosine[0] = cos(state->phase);
    coupling = unbalance * sine[0];
    inverse_det = 1 / (mass * inertia - coupling * coupling);
    drag = s->M0 / s->Omega0;
    to_a1 = inertia * inverse_det;
    to_w = mass * inverse_det;
    cross = coupling * inverse_det;
    sw = sine[0] * w[0];
    for (n = 0; n < p; n++) {
        double inverse = f->inverse[n + 1], force, thrust, torque;
        const double *wn = w_back + (p - n), *an = a1_back + (p + 1 - n); /* wn[i] = w[n - i], an[i] = a1[n - 1 - i] */
        Pair cws = make_pair(0, 0), tails = cws, backs = cws;
        double cw, tail, back;
        for (i = 1; i + 1 < n; i += 2) {
            Pair speeds = load_pair(wn + i), sines = load_pair(sine + i + 1);
            cws = add_product(cws, load_pair(cosine + i), speeds);
            tails = add_product(tails, sines, speeds);
            backs = add_product(backs, sines, load_pair(an + i));
        }
        if (i < n) { /* the odd chain has one term more; the even one adds 0 * 0 */
            Pair speed = make_pair(wn[i], 0), next = make_pair(sine[i + 1], 0);
            cws = add_product(cws, make_pair(cosine[i], 0), speed);
            tails = add_product(tails, next, speed);
            backs = add_product(backs, next, make_pair(an[i], 0));
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
        force = force_coefficient(&law, table[n], n);
        thrust = unbalance * ((n + 1) * tail) - force;
        torque = unbalance * back - drag * w[n];
        if (n == 0)
            torque = torque + stall;
        previous = a1_back[p - n] = to_a1 * thrust + cross * torque;
        w[n + 1] = w_back[p - n - 1] = (to_w * torque + cross * thrust) * inverse;
        table[n + 1][W] = w[n + 1];
        table[n + 1][PHI] = w[n] * inverse;
        sw = tail + sine[0] * w[n + 1];
        advance_series(&law, table[n], table[n + 1], n, inverse, previous, force);
    }
    table[p + 1][PHI] = w[p] * f->inverse[p + 1];
    if (r->tangent.count > 0) {
        memcpy(f->sine, sine, sizeof f->sine);
        memcpy(f->cosine, cosine, sizeof f->cosine);
    }
}

static int block_size(const Taylor *f, int first, int second, int n)
{
    double total = fabs(f->table[n][first]);
    if (second != first)
        total = total + fabs(f->table[n][second]);
    return binary_exponent(total);
}

static double block_length(const Run *r, int first, int second, double longest)
{
    const Taylor *f = &r->taylor;
    int order = f->order, sizes[LEADING], m, last;
    for (m = 0; m < LEADING; m++)
        sizes[m] = block_size(f, first, second, m);
    for (last = order - 1; last <= order; last++) {
        int size = block_size(f, first, second, last);
        if (size > -2000) {
            double best = -INFINITY;
            for (m = 0; m < LEADING && m < last; m++) {
                double candidate = (r->scene.tolerance_exponent + (sizes[m] - size)) / (last - m);
                best = sizes[m] > -2000 && candidate > best ? candidate : best;
            }
            longest = best > -INFINITY && best < longest ? best : longest;
        }
    }
    return longest;
}

static double step_length(const Run *r)
{
    double longest = block_length(r, V1, V2, 1000.0);
    if (r->scene.has_motor != 0)
        longest = block_length(r, W, W, longest);
    return longest < 1000.0 ? power_of_two(longest) : INFINITY;
}

void taylor_enter(Run *r, const State *state, Mode mode)
{
    const Scene *s = &r->scene;
    Taylor *f = &r->taylor;
    double *first = f->table[0], *last = f->table[f->order + 1], *before = f->table[f->order], inverse;
    f->locked = s->has_block2 == 0 || (s->has_friction != 0 && mode.friction == 0);
    f->k = mode.contact ? s->k1 + s->k2 : s->k1;
    f->offset = mode.contact ? s->k2 * (s->stop_sign * s->G) : 0.0;
    f->t0 = state->t;
    f->turns = state->turns;
    first[X1] = state->x1;
    first[V1] = state->v1;
    first[X2] = state->x2;
    first[V2] = f->locked ? 0.0 : state->v2;
    if (s->has_motor != 0)
        expand_motor(r, state, law_of(r, mode));
    else
        expand_ideal(r, state, law_of(r, mode));
    inverse = f->inverse[f->order + 1];
    last[X1] = before[V1] * inverse;
    last[X2] = before[V2] * inverse;
    last[V1] = last[V2] = last[W] = 0.0;
    r->steps += 1;
    r->spent += WORK_OF_A_STEP;
    f->h = step_length(r);
}

/* Coefficients of an event function over the step; returns their number. */
static int event_polynomial(const Run *r, int function, double *out)
{
    const Scene *s = &r->scene;
    const double(*table)[STATES] = r->taylor.table;
    Law law = law_of(r, r->mode);
    int p = r->taylor.order, n;
    if (function == GAP || function == CLEARANCE) {
        double factor, constant;
        if (function == GAP) {
            factor = r->mode.contact ? -s->stop_sign : s->stop_sign;
            constant = r->mode.contact ? -s->G : s->G;
        } else {
            factor = r->mode.violated ? 1 : -1;
            constant = r->mode.violated ? -s->rest_distance : s->rest_distance;
        }
        for (n = 0; n <= p + 1; n++)
            out[n] = factor * (table[n][X1] - table[n][X2]);
        out[0] = out[0] + constant;
        return p + 2;
    }
    if (function == SLIDE) {
        double friction = r->mode.friction;
        for (n = 0; n <= p; n++)
            out[n] = friction * table[n][V2];
        return p + 1;
    }
    for (n = 0; n <= p; n++) {
        double force = force_coefficient(&law, table[n], n);
        out[n] = function == HOLD_PLUS ? -force : force;
    }
    out[0] = s->N + out[0];
    return p + 1;
}

/* Sum of the magnitudes that an event function is made of at the expansion point. */
static double magnitude(const Run *r, int function)
{
    const Scene *s = &r->scene;
    const Taylor *f = &r->taylor;
    const double *row = f->table[0];
    double places = fabs(row[X1]) + fabs(row[X2]), speeds = fabs(row[V1]) + fabs(row[V2]);
    if (function == GAP)
        return places + fabs(s->G);
    if (function == CLEARANCE)
        return places + fabs(s->rest_distance);
    if (function == SLIDE)
        return speeds;
    return f->k * places + s->c * speeds + fabs(f->offset) + s->N;
}

static int near_zero(const Run *r, int function, double tau, double *value, double *slope, double *noise)
{
    double coefficients[SERIES];
    int count = event_polynomial(r, function, coefficients);
    return polynomial_near_zero(coefficients, count, r->known.order[function], tau, magnitude(r, function), value, slope,
                                noise);
}

/* Doubt that the zero of `first`, at time `end`, is the first, where that of another event function may come as soon. */
static void certify_order(Run *r, int first, double end)
{
    double tau = end - r->taylor.t0, value = 0, slope = 0, noise = 0, other, fall, blur, latest;
    int i;
    near_zero(r, first, tau, &value, &slope, &noise);
    if (slope >= 0)
        return;
    latest = latest_zero(value, slope, noise, end);
    for (i = 0; i < r->function_count; i++) {
        if (r->functions[i] == first || !near_zero(r, r->functions[i], tau, &other, &fall, &blur))
            continue;
        if (!(other == value && fall == slope) && may_vanish_by(other, fall, blur, latest))
            doubt(&r->certificate, r->taylor.t0);
    }
}

double taylor_advance(Run *r, double limit, int *function)
{
    const Taylor *f = &r->taylor;
    double length = limit - f->t0, h = f->h < length ? f->h : length;
    double end = f->h >= length ? limit : f->t0 + h, coefficients[SERIES], t = 0;
    int i;
    *function = NOTHING;
    if (end <= f->t0) {
        doubt(&r->certificate, f->t0);
        return nextafter(f->t0, INFINITY);
    }
    for (i = 0; i < r->function_count && h != 0; i++) { /* after an event at the start no other can come before it */
        int which = r->functions[i], count = event_polynomial(r, which, coefficients);
        int outcome = polynomial_first_root(r, coefficients, count, r->known.order[which], f->t0, h, which == GAP, &t);
        if (outcome != POSITIVE && (t < end || (outcome == ZERO && *function == NOTHING))) {
            end = t;
            *function = outcome == ZERO ? which : NOTHING;
            h = end - f->t0;
        }
    }
    if (*function != NOTHING)
        certify_order(r, *function, end);
    return end;
}

/* All states at tau after the expansion point: `horner` row by row over the table. */
static void dense_output(const Taylor *f, double tau, double *out)
{
    double square = tau * tau, high[STATES], low[STATES];
    int count = f->order + 2, n = count - 3, k;
    for (k = 0; k < STATES; k++) {
        high[k] = f->table[count - 1][k];
        low[k] = f->table[count - 2][k];
    }
    for (; n > 0; n -= 2) {
        for (k = 0; k < STATES; k++)
            high[k] = high[k] * square + f->table[n][k];
        for (k = 0; k < STATES; k++)
            low[k] = low[k] * square + f->table[n - 1][k];
    }
    if (count % 2 == 0) {
        for (k = 0; k < STATES; k++)
            out[k] = low[k] + tau * high[k];
        return;
    }
    for (k = 0; k < STATES; k++)
        out[k] = (high[k] * square + f->table[0][k]) + tau * low[k];
}

void taylor_state_after(Run *r, double tau, State *out)
{
    const Taylor *f = &r->taylor;
    double values[STATES], turns = 0;
    dense_output(f, tau, values);
    r->spent += 1;
    out->t = f->t0 + tau;
    out->x1 = values[X1];
    out->x2 = f->locked ? f->table[0][X2] : values[X2];
    out->v1 = values[V1];
    out->v2 = f->locked ? 0.0 : values[V2];
    out->phase = out->turns = out->w = 0.0;
    if (r->scene.has_motor != 0) {
        out->phase = reduce_angle(values[PHI], &turns);
        out->turns = f->turns + turns;
        out->w = values[W];
    }
}

void taylor_jet(Run *r, const State *state, Mode mode, int count, double *jet)
{
    double factorial = 1;
    int order = r->taylor.order, n;
    r->taylor.order = count > order ? count : order;
    taylor_enter(r, state, mode);
    r->taylor.order = order;
    for (n = 0; n <= count; n++) {
        factorial = n > 0 ? factorial * n : 1;
        jet[n] = (r->taylor.table[n][X1] - r->taylor.table[n][X2]) * factorial;
    }
}
