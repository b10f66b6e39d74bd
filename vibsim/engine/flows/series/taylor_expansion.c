/* Taylor coefficients of the motion at a state, by recurrence from the balance of forces of each group of bodies.
 *
 * A row of the table holds the coefficients of one order: displacements of the bodies, phi, ground and base; then the rates of
 * all of them in the same places. Small scenes run in shapes whose columns are known at compile time.
 *
 * Taylor series of the rotor of a motor, beside those of its body.
 *
 * With s = sin phi, c = cos phi and w = dphi/dt three products of series are all, because
 *     s dw/dt + w^2 c = d(s w)/dt,      s' = c w,      c' = -s w      (Eqs. 2.9, 2.10 of the paper).
 */
#include "engine.h"
#include "inlining.h"
#include "numbers.h"
#include "pair.h"
#include "tape_series.h"

#include "wide.h"
#define SHAPE WIDE APART void /* one function each: inlined into one they lose a quarter */

typedef struct {
    Real *sine, *cosine, *w_back, *a1_back; /* w_back[p - n] = w[n], a1_back[p - n] = a1[n] */
    Taylor *of;
    Real unbalance, drag, inertia, stall, coupling, to_a1, to_w, cross, pull, sw, tail, torque, previous;
} Rotor;

/* Start of the series of the rotor at `state`, and the mass matrix there. */
INLINE Rotor rotor_of(Run *r, const State *state)
{
    Taylor *f = &r->taylor;
    Rotor o;
    o.of = f;
    o.sine = f->sine;
    o.cosine = f->cosine;
    o.w_back = f->w_back;
    o.a1_back = f->a1_back;
    o.unbalance = r->unbalance;
    o.drag = r->drag;
    o.inertia = r->inertia;
    o.stall = r->M0;
    f->table[r->bodies] = state->phase;
    f->table[f->rates + r->bodies] = o.w_back[f->order] = state->w;
    sine_cosine(state->phase, &o.sine[0], &o.cosine[0]);
    o.coupling = o.unbalance * o.sine[0];
    o.to_a1 = o.to_w = o.cross = o.pull = o.tail = o.torque = o.previous = 0.0;
    if (r->mode->carried > 0) {
        Real mass = r->mode->carried + r->m3, inverse_det = 1 / (mass * o.inertia - o.coupling * o.coupling);
        o.to_a1 = o.inertia * inverse_det;
        o.to_w = mass * inverse_det;
        o.cross = o.coupling * inverse_det;
    }
    o.sw = o.sine[0] * state->w;
    return o;
}

/* Tell the sums of products of a coefficient of order n, which stands at place `at` of its series. */
#ifdef FIXED_SERIES
static void keep_digits(Taylor *f, int series, int at, int n, const Real &x)
{
    const Scales<SERIES> *s = f->scales;
    if (s && !digits_of(x, (long)s->power * n - s->bound[series], s->most, &f->rotor[series][at]))
        f->scales = NULL;
}
#else
#define keep_digits(of, series, at, n, x)
#endif

/* What order 0 of the rotor's series is before the accelerations are known; returns its thrust. */
INLINE Real start_rotation(Rotor *o, int p)
{
    const Real w0 = o->w_back[p];
    o->cosine[1] = -o->sw;
    o->sine[1] = o->cosine[0] * w0;
    keep_digits(o->of, COSINES, 0, 0, o->cosine[0]);
    keep_digits(o->of, COSINES, 1, 1, o->cosine[1]);
    keep_digits(o->of, SINES, 1, 1, o->sine[1]);
    keep_digits(o->of, SPEEDS, p, 0, w0);
    o->pull = o->unbalance * o->sine[1];
    o->tail = o->sine[1] * w0;
    o->torque = o->stall - o->drag * w0;
    return o->unbalance * o->tail;
}

#ifdef FIXED_SERIES
/* Sum of a_i b_(n-i) of series number one and two, i from `first` to n: in whole numbers where these were made. */
static Real product_of_series(const Taylor *f, int one, const Real *a, int two, const Real *b, int first, int n)
{
    const Scales<SERIES> *s = f->scales;
    const int ahead = f->order - n + first, count = n + 1 - first;
    Real sum = 0.0;
    int i;
    if (s)
        return sum_of_products(f->rotor[one] + first, f->rotor[two] + ahead, count, s->digits[n], (long)s->bound[one] + s->bound[two] - (long)s->power * n);
    for (i = 0; i < count; i++)
        sum = sum + a[first + i] * b[ahead + i];
    return sum;
}

/* Order n > 0 of the rotor's series as below, but with all terms in the sums. */
INLINE Real rotate(Rotor *o, int n, int p, Real inverse)
{
    Taylor *f = o->of;
    const Real *w = o->w_back, *a1 = o->a1_back;
    o->cosine[n + 1] = -(o->sw * inverse);
    o->sine[n + 1] = product_of_series(f, COSINES, o->cosine, SPEEDS, w, 0, n) * inverse;
    keep_digits(f, COSINES, n + 1, n + 1, o->cosine[n + 1]);
    keep_digits(f, SINES, n + 1, n + 1, o->sine[n + 1]);
    o->tail = product_of_series(f, SINES, o->sine, SPEEDS, w, 1, n + 1);
    o->torque = o->unbalance * product_of_series(f, SINES, o->sine, THRUSTS, a1, 1, n) - o->drag * w[p - n];
    return o->unbalance * ((n + 1) * o->tail);
}

/* Order n of the acceleration under `thrust`, and order n + 1 of the rotor's speed, from one 2x2 division by the mass matrix. */
INLINE Real turn(Rotor *o, int n, int p, Real inverse, Real thrust)
{
    Real a1 = o->to_a1 * thrust + o->cross * o->torque, w = (o->to_w * o->torque + o->cross * thrust) * inverse;
    o->w_back[p - n - 1] = w;
    o->a1_back[p - n] = a1;
    keep_digits(o->of, SPEEDS, p - n - 1, n + 1, w);
    keep_digits(o->of, THRUSTS, p - n, n, a1);
    o->sw = o->tail + o->sine[0] * w;
    return a1;
}
#else
/* Sums of `count` products: of cosines and speeds, sines and speeds, sines and accelerations. They are the inner terms of (c w)_n,
 * (s w)_(n+1) and (s a1)_n, those that do not wait for the newest coefficients; odd and even terms are summed apart, two chains
 * that a processor takes side by side.
 */
typedef struct {
    Real cws, tails, backs;
} Products;

/* Those sums, the series of the speed and the acceleration backwards. */
INLINE Products products_of(const Real *restrict cosine, const Real *restrict sine, const Real *w, const Real *a1, int count)
{
    Products sums;
    Pair cws = make_pair(0, 0), tails = cws, backs = cws;
    int i;
    for (i = 0; i + 1 < count; i += 2) {
        Pair speeds = load_pair(w + i), sines = load_pair(sine + i);
        cws = add_product(cws, load_pair(cosine + i), speeds);
        tails = add_product(tails, sines, speeds);
        backs = add_product(backs, sines, load_pair(a1 + i));
    }
    if (i < count) { /* the odd chain has one term more; the even one adds 0 * 0 */
        Pair speed = make_pair(w[i], 0), following = make_pair(sine[i], 0);
        cws = add_product(cws, make_pair(cosine[i], 0), speed);
        tails = add_product(tails, following, speed);
        backs = add_product(backs, following, make_pair(a1[i], 0));
    }
    sums.cws = sum_of_pair(cws);
    sums.tails = sum_of_pair(tails);
    sums.backs = sum_of_pair(backs);
    return sums;
}

/* The same of order n > 0. All that does not wait for w[n] and a1[n - 1] comes first: few operations are then left between
 * one order and the next.
 */
INLINE Real rotate(Rotor *o, int n, int p, Real inverse)
{
    Real *restrict sine = o->sine, *restrict cosine = o->cosine;
    const Real *w = o->w_back + (p - n), *a1 = o->a1_back + (p + 1 - n); /* w[i]: order n - i, a1[i]: order n - 1 - i */
    const Real w0 = o->w_back[p], scale = o->unbalance * (n + 1), lean = cosine[0] * inverse;
    Real ahead, known, slope;
    const Products sums = products_of(cosine + 1, sine + 2, w + 1, a1 + 1, n - 1);
    ahead = (sums.cws + cosine[n] * w0) * inverse;
    known = sums.tails + ahead * w0;
    slope = sine[1] + lean * w0;
    cosine[n + 1] = -(o->sw * inverse);
    sine[n + 1] = ahead + lean * w[0];
    o->tail = known + slope * w[0];
    o->torque = (o->unbalance * sums.backs - o->drag * w[0]) + o->pull * o->previous;
    return scale * known + scale * slope * w[0];
}

/* Order n of the acceleration under `thrust`, and order n + 1 of the rotor's speed, from one 2x2 division by the mass matrix. */
INLINE Real turn(Rotor *o, int n, int p, Real inverse, Real thrust)
{
    Real a1 = o->to_a1 * thrust + o->cross * o->torque, w = o->to_w * inverse * o->torque + o->cross * inverse * thrust;
    o->w_back[p - n - 1] = w;
    o->a1_back[p - n] = o->previous = a1;
    o->sw = o->tail + o->sine[0] * w;
    return a1;
}
#endif

/* The same where the motor's body moves as the ground or the base does: its acceleration is given. */
INLINE Real turn_carried(Rotor *o, int n, int p, Real inverse, Real a1)
{
    Real w = (o->torque + o->coupling * a1) / o->inertia * inverse;
    o->w_back[p - n - 1] = w;
    o->a1_back[p - n] = o->previous = a1;
    keep_digits(o->of, SPEEDS, p - n - 1, n + 1, w);
    keep_digits(o->of, THRUSTS, p - n, n, a1);
    o->sw = o->tail + o->sine[0] * w;
    return a1;
}

/* What a small scene's recurrences read, in locals: the compiler then knows that no store to the table changes it. */
typedef struct {
    Real k, c, mobility, mobility_far;
    const Real *load, *load_far;
} Law;

enum { SMALL_RATES = 3, SMALL_STRIDE = 6 }; /* of the tables of small scenes */

/* Order n + 1 from order n, order 0 with the constants. */
INLINE void advance_small(const Run *r, const Law *law, Rotor *o, Real *row, const int first, int n, int p, Real inverse,
                          const int bodies, const int moving, const int far, const int motor)
{
    const Mode *m = r->mode;
    const int phi = bodies;
    Real *next = row + SMALL_STRIDE, *rates = row + SMALL_RATES, *next_rates = next + SMALL_RATES;
    Real thrust = !motor ? 0.0 : first ? start_rotation(o, p) : rotate(o, n, p, inverse);
    Real F = 0.0, F_far = 0.0, force, a1;
    if (law->load)
        F = F + law->load[n];
    if (moving > 1 && law->load_far)
        F_far = F_far + law->load_far[n];
    force = law->k * (row[0] - row[far]) + law->c * (rates[0] - rates[far]);
    if (first)
        force = force + m->small.offset;
    F = F - force;
    F_far = F_far + force;
    if (first) {
        F = F + m->small_constants[0];
        F_far = F_far + m->small_constants[1];
    }
    a1 = motor ? turn(o, n, p, inverse, F + thrust) : F * law->mobility;
    next[0] = rates[0] * inverse;
    if (bodies > 1)
        next[far] = rates[far] * inverse;
    next_rates[0] = a1 * inverse;
    if (bodies > 1)
        next_rates[far] = moving > 1 ? F_far * law->mobility_far * inverse : 0.0;
    if (motor) {
        next[phi] = rates[phi] * inverse;
        next_rates[phi] = o->w_back[p - n - 1];
    }
}

#ifdef FIXED_SERIES
#define ORDERS_IN_WORDS(f, motor) ((motor) && (f)->scales && (f)->scales->words < (f)->order ? (f)->scales->words : (f)->order)
#else
#define ORDERS_IN_WORDS(f, motor) (f)->order
#endif

/* One body that moves and a second column: another body that moves (`moving` == 2), one that is held, or the ground. */
INLINE void expand_small(Run *r, const State *state, const int bodies, const int moving, const int far, const int motor)
{
    Taylor *f = &r->taylor;
    const Mode *m = r->mode;
    const int p = f->order;
    Real *row = f->table, *next;
    Law law;
    Rotor o;
    int n, c;
    law.k = m->small.k;
    law.c = m->small.c;
    law.mobility = m->mobility[0];
    law.mobility_far = moving > 1 ? m->mobility[1] : 0.0;
    law.load = f->loaded_on[0];
    law.load_far = moving > 1 ? f->loaded_on[1] : NULL;
    if (motor)
        o = rotor_of(r, state);
    advance_small(r, &law, &o, row, 1, 0, p, f->inverse[1], bodies, moving, far, motor);
    for (n = 1; n < ORDERS_IN_WORDS(f, motor) && !is_interrupted(r, n); n++) {
        row += SMALL_STRIDE;
        advance_small(r, &law, &o, row, 0, n, p, f->inverse[n + 1], bodies, moving, far, motor);
    }
#ifdef FIXED_SERIES
    if (n < p) {
        last_orders(r, n, bodies, moving, far);
        row = f->table + (p - 1) * SMALL_STRIDE;
    }
#endif
    row += SMALL_STRIDE;
    next = row + SMALL_STRIDE;
    for (c = 0; c < SMALL_RATES; c++) {
        next[c] = row[SMALL_RATES + c] * f->inverse[p + 1];
        next[SMALL_RATES + c] = 0.0;
    }
}

SHAPE two_free(Run *r, const State *s) { expand_small(r, s, 2, 2, 1, 0); }
SHAPE two_free_with_motor(Run *r, const State *s) { expand_small(r, s, 2, 2, 1, 1); }
SHAPE two_held(Run *r, const State *s) { expand_small(r, s, 2, 1, 1, 0); }
SHAPE two_held_with_motor(Run *r, const State *s) { expand_small(r, s, 2, 1, 1, 1); }
SHAPE one(Run *r, const State *s) { expand_small(r, s, 1, 1, 2, 0); }
SHAPE one_with_motor(Run *r, const State *s) { expand_small(r, s, 1, 1, 2, 1); }

/* Add a force on a group; alone: there is but one body, number 0, and no force on anything else counts. */
INLINE void act(Real *F, const int alone, int leader, Real force)
{
    if (!alone)
        F[leader] = F[leader] + force;
    else if (leader == 0)
        F[0] = F[0] + force;
}

/* Add order n of the forces on the groups, by leading column. */
INLINE void add_forces(const Run *r, Real *F, const int alone, const Real *row, int n)
{
    const Taylor *f = &r->taylor;
    const Mode *m = r->mode;
    const int rates = f->rates;
    int i;
    for (i = 0; i < f->loaded_count; i++) {
        int column = f->loaded[i];
        act(F, alone, m->leader[column], f->load[column * SERIES + n]);
    }
    for (i = 0; i < m->coupling_count; i++) {
        const Coupling *q = &m->couplings[i];
        const Real *a = row + q->from, *b = row + q->to;
        Real force = q->k * (*a - *b) + q->c * (a[rates] - b[rates]);
        if (n == 0)
            force = force + q->offset;
        act(F, alone, q->to_P, -force);
        act(F, alone, q->to_Q, force);
    }
    for (i = 0; n == 0 && i < m->constant_count; i++)
        act(F, alone, m->leader[m->constant_columns[i]], m->constants[i]);
}

/* Order n of the forces on the groups. */
INLINE void balance(const Run *r, const Real *row, int n)
{
    int i;
    for (i = 0; i < r->columns; i++)
        r->force[i] = 0.0;
    add_forces(r, r->force, 0, row, n);
}

/* Any mode without formulas. Bodies that are tied move as the leader of their group, which comes before them, or as ground or
 * base.
 */
INLINE void expand_any(Run *r, const State *state, const int motor)
{
    Taylor *f = &r->taylor;
    const Mode *m = r->mode;
    const int p = f->order, bodies = r->bodies, rates = f->rates, stride = f->stride, base = bodies + 2;
    const int on = motor ? m->leader[r->motor_on] : 0;
    Real *row = f->table;
    Rotor o;
    int n, c;
    if (motor)
        o = rotor_of(r, state);
    for (n = 0; n <= p; n++, row += stride) {
        Real *next = row + stride, *F = r->force, inverse = f->inverse[n + 1];
        for (c = 0; c <= bodies; c++)
            next[c] = row[rates + c] * inverse;
        if (n == p || is_interrupted(r, n))
            break;
        balance(r, row, n);
        if (motor)
            F[on] += n == 0 ? start_rotation(&o, p) : rotate(&o, n, p, inverse);
        if (m->untied)
            for (c = 0; c < bodies; c++)
                next[rates + c] = F[c] * m->mobility[c] * inverse;
        next[rates + bodies] = 0.0;
        if (motor) {
            Real given = on > bodies ? (n + 1) * next[rates + base] : 0.0;
            Real a1 = on < bodies ? turn(&o, n, p, inverse, F[on]) : turn_carried(&o, n, p, inverse, given);
            if (on < bodies)
                next[rates + on] = a1 * inverse;
            next[rates + bodies] = o.w_back[p - n - 1];
        }
        for (c = 0; !m->untied && c < bodies; c++) {
            int leader = m->leader[c];
            if (leader >= bodies)
                next[rates + c] = leader == bodies ? 0.0 : next[rates + base];
            else if (leader == c && !(motor && c == on))
                next[rates + c] = F[c] * m->mobility[c] * inverse;
            else
                next[rates + c] = next[rates + leader]; /* leaders come first */
        }
    }
    for (c = 0; c <= bodies; c++)
        row[stride + rates + c] = 0.0;
}

/* Add order n of the forces by formulas to those on the groups; last: that of the last operation of the tape. */
INLINE void add_formulas(const Run *r, Real *F, const int alone, int n, Real last)
{
    const Mode *m = r->mode;
    int i;
    for (i = 0; i < m->formula_count; i++) {
        const FormulaForce *one = &m->formulas[i];
        Real force = one->sign * (n > 0 && one->newest ? last : series_along(r->taylor.tapes.series, one->place)[n]);
        act(F, alone, one->to_P, force);
        if (one->to_Q >= 0)
            act(F, alone, one->to_Q, -force);
    }
}

/* Any mode with formulas, or with rotors on bodies; few: the number of bodies, where it is known at compile time, or 0. */
INLINE void expand_formulas(Run *r, const State *state, const int few, const int motor)
{
    Taylor *f = &r->taylor;
    const Mode *m = r->mode;
    const int bodies = few ? few : r->bodies, columns = bodies + 2;
    const int p = f->order, rates = f->rates, stride = f->stride, base = bodies + 2;
    const int on = motor ? m->leader[r->motor_on] : 0;
    Real *row = f->table, *F = r->force, *acceleration = f->acceleration, last = 0.0;
    Rotor o;
    int n, c;
    if (motor)
        o = rotor_of(r, state);
    tape_start(&f->tapes, r->t0, f->nearest, f->inverse, p);
    if (r->rotors.count > 0)
        rotors_expand(r);
    for (n = 0; n <= p; n++, row += stride) {
        Real *next = row + stride, inverse = f->inverse[n + 1];
        for (c = 0; c <= bodies; c++) {
            if (few != 2)
                ONE_BY_ONE;
            next[c] = row[rates + c] * inverse;
        }
        if (n == p || is_interrupted(r, n))
            break;
        for (c = 0; c < columns; c++) {
            if (few != 2)
                ONE_BY_ONE;
            F[c] = 0.0;
        }
        add_forces(r, F, 0, row, n);
        if (n == 0)
            tape_begin(&m->tape, &f->tapes, row);
        else
            last = advance_along(&m->tape, &f->tapes, row, n, f->inverse[n], 0, rates, 0.0, 0.0);
        add_formulas(r, F, 0, n, last);
        for (c = 0; c < columns; c++) {
            if (few != 2)
                ONE_BY_ONE;
            acceleration[c] = F[c] * m->mobility[c];
        }
        if (r->rotors.count > 0)
            rotors_turn(r, n);
        next[rates + bodies] = 0.0;
        if (motor) {
            Real given = on > bodies ? (n + 1) * next[rates + base] : 0.0;
            F[on] += n == 0 ? start_rotation(&o, p) : rotate(&o, n, p, inverse);
            acceleration[on] = on < bodies ? turn(&o, n, p, inverse, F[on]) : turn_carried(&o, n, p, inverse, given);
            next[rates + bodies] = o.w_back[p - n - 1];
        }
        for (c = 0; c < bodies; c++) {
            int leader = m->leader[c];
            next[rates + c] = leader < bodies ? acceleration[leader] * inverse : leader == bodies ? 0.0 : next[rates + base];
        }
        for (c = 0; c < m->follower_count; c++) {
            const Follower *one = &m->followers[c];
            next[rates + one->column] = next[rates + one->column] + series_along(f->tapes.series, one->place)[n] * inverse;
        }
    }
    for (c = 0; c <= bodies; c++)
        row[stride + rates + c] = 0.0;
    tape_end(&m->tape, &f->tapes, f->table, stride);
}

/* The same as above of one body without rotor. What is computed of one order for the next stays at hand, since most of the time goes
 * into waiting for it.
 */
SHAPE formulas_on_one(Run *r, const State *state)
{
    Taylor *f = &r->taylor;
    const Mode *m = r->mode;
    const int p = f->order, rates = f->rates, stride = f->stride, leader = m->leader[0];
    const int single = m->formula_count == 1 && m->formulas[0].newest && m->formulas[0].to_P == 0 && m->formulas[0].to_Q != 0;
    const Real mobility = leader == 0 ? m->mobility[0] : 0.0, sign = single ? m->formulas[0].sign : 0.0;
    Real *row = f->table, x = row[0], v = row[rates], last = 0.0;
    int n;
    (void)state;
    tape_start(&f->tapes, r->t0, f->nearest, f->inverse, p);
    tape_begin(&m->tape, &f->tapes, row);
    for (n = 0; n < p && !is_interrupted(r, n); n++, row += stride) {
        Real *next = row + stride, inverse = f->inverse[n + 1], F = 0.0;
        add_forces(r, &F, 1, row, n);
        if (n > 0)
            last = advance_along(&m->tape, &f->tapes, row, n, f->inverse[n], 1, rates, x, v);
        if (single && n > 0)
            F = F + sign * last;
        else
            add_formulas(r, &F, 1, n, last);
        x = v * inverse;
        v = leader == 0 ? F * mobility * inverse : leader == 1 ? 0.0 : next[rates + 3];
        if (m->follower_count > 0)
            v = v + series_along(f->tapes.series, m->followers[0].place)[n] * inverse;
        next[0] = x;
        next[1] = row[rates + 1] * inverse;
        next[rates] = v;
        next[rates + 1] = 0.0;
    }
    row[stride] = v * f->inverse[p + 1];
    row[stride + 1] = row[rates + 1] * f->inverse[p + 1];
    row[stride + rates] = row[stride + rates + 1] = 0.0;
    tape_end(&m->tape, &f->tapes, f->table, stride);
}

SHAPE any(Run *r, const State *s) { expand_any(r, s, 0); }
SHAPE any_with_motor(Run *r, const State *s) { expand_any(r, s, 1); }
SHAPE formulas(Run *r, const State *s) { expand_formulas(r, s, 0, 0); }
SHAPE formulas_with_motor(Run *r, const State *s) { expand_formulas(r, s, 0, 1); }
SHAPE formulas_on_two(Run *r, const State *s) { expand_formulas(r, s, 2, 0); }
SHAPE formulas_on_three(Run *r, const State *s) { expand_formulas(r, s, 3, 0); }
SHAPE formulas_on_four(Run *r, const State *s) { expand_formulas(r, s, 4, 0); }

/* Coefficients of all columns at `state`, whose displacements and rates, and those of base and loads, are in the table. */
void taylor_expand(Run *r, const State *state)
{
    static void (*const shapes[])(Run *, const State *) = {
        any, any_with_motor, two_free, two_free_with_motor, two_held, two_held_with_motor, one, one_with_motor, formulas, formulas_with_motor,
    };
    if (r->mode->shape == FORMULAS && r->bodies == 1 && !r->has_motor && r->rotors.count == 0)
        formulas_on_one(r, state);
    else if (r->mode->shape == FORMULAS && r->bodies == 2 && !r->has_motor)
        formulas_on_two(r, state);
    else if (r->mode->shape == FORMULAS && r->bodies == 3 && !r->has_motor)
        formulas_on_three(r, state);
    else if (r->mode->shape == FORMULAS && r->bodies == 4 && !r->has_motor)
        formulas_on_four(r, state);
    else
        shapes[2 * r->mode->shape + r->has_motor](r, state);
}
