/* Rounding bounds of the Taylor coefficients at a state, which is exact, or rounded itself.
 *
 * A derivative whose terms cancel is what their rounding left of it: on its sign nothing may rest. So the recurrences are gone through
 * once more, and each operation adds the rounding of its result to that of what it is made of. There is none where every term is
 * zero, nor in a sum of exact terms that is zero.
 */
#include "engine.h"
#include "numbers.h"
#include "tape_series.h"
#include "zalloc.h"

#define ONCE EPS            /* of one operation */
#define PRODUCT (16 * EPS)  /* of a product of an amplitude, powers of a rate and a sine, or of two series */
#define ROTATION (64 * EPS) /* of a coefficient of what a rotor does, some ten products of series one behind the other */

/* Bounds of displacements, velocities and loads by order, then column; along the tape by order, then operation; of the rotor's speed
 * and angle. force, lost: forces on the groups of the order in hand and their rounding; by_speed: of accelerations; twist: of the torque
 * of each rotor.
 */
typedef struct {
    const Run *r;
    Real *x, *v, *load, *tape, *w, *force, *lost, *by_speed, *twist, *values, angle, late;
    int highest, exact;
} Bounds;

/* Coefficient n of displacement or velocity of a column, of `rates` 0 or those of the table. */
static Real series_of(const Run *r, int column, int n, int rates)
{
    const Taylor *f = &r->taylor;
    const int at = column_in_table(r, column);
    return at < f->rates ? f->table[n * f->stride + rates + at] : (Real)0.0;
}

static Real place(const Run *r, int column, int n) { return series_of(r, column, n, 0); }
static Real rate(const Run *r, int column, int n) { return series_of(r, column, n, r->taylor.rates); }

/* The largest size of the terms of the series of a column after `span` [s]. */
static Real largest_term(const Run *r, int column, int rates, Real span)
{
    Real largest = fabs(series_of(r, column, 0, rates)), power = 1.0;
    int n;
    for (n = 1; span != 0 && n < r->taylor.order + 2; n++) {
        Real size;
        power = power * span;
        size = fabs(series_of(r, column, n, rates) * power);
        largest = size > largest ? size : largest;
    }
    return largest;
}

/* Add those of the first coefficients in tau of a harmonic at t + tau. A sine is as wrong as its angle times its cosine; at a quarter
 * turn, where motions start, it is 0 or 1.
 */
static void add_harmonic(const Harmonic *term, Real t, int count, Real *bounds, int stride)
{
    const Real turned = turn_angle(term->cycles, term->cycles_lo, t), angle = fabs(turned) + fabs(term->phase);
    Real turns[2], size = PRODUCT * fabs(term->amplitude);
    int n;
    rounded_sine_cosine(turned + term->phase, &turns[0], &turns[1]);
    turns[0] = fabs(turns[0]);
    turns[1] = fabs(turns[1]);
    for (n = 0; n < count; n++) {
        const Real turn = turns[n % 2], other = turns[(n + 1) % 2];
        if (n > 0 || turn != 1 || other != 0)
            bounds[n * stride] = bounds[n * stride] + size * (turn + angle * other);
        size = size * term->omega / (n + 1);
    }
}

/* Of the base: by harmonics, or of a formula from the sizes of its derivatives of order 0 to 2. */
static void start_base(Bounds *b)
{
    const Run *r = b->r;
    const Taylor *f = &r->taylor;
    const int count = b->highest + 2, columns = r->columns, base = r->bodies + 1;
    Series moved;
    int i, n;
    for (n = 0; n < count; n++)
        moved[n] = 0.0;
    for (i = 0; i < r->base_count; i++)
        add_harmonic(&r->base[i], r->t0, count, moved, 1);
    if (r->mode->base_values.op_count > 0) {
        const Tape *tape = &r->mode->base_values;
        TapeInputs at = f->tapes.at, blur = f->tapes.blur;
        Real *values = f->tapes.base, *bounds = values + f->tapes.ops;
        const Real late = EPS * fabs(r->t0);
        at.t = r->t0;
        blur.t = late;
        for (n = 0; n < count; n++) /* (n + 1) times coefficient n + 1 is that of the velocity */
            moved[n] = PRODUCT * fabs(place(r, base, n)) + late * fabs(rate(r, base, n));
        tape_evaluate(tape, &at, &blur, values, bounds);
        for (n = r->has_base == 2; n < 3 && n < count; n++) {
            const Real bound = bounds[tape->outputs[r->has_base == 2 ? n - 1 : n]];
            moved[n] = moved[n] + (n < 2 ? bound : bound / 2);
        }
    }
    for (n = 0; n <= b->highest; n++) {
        b->x[n * columns + base] = moved[n];
        b->v[n * columns + base] = (n + 1) * moved[n + 1];
    }
}

/* The state, and base and loads, of all orders. */
static void start(Bounds *b, Real span)
{
    const Run *r = b->r;
    const Taylor *f = &r->taylor;
    const int columns = r->columns, base = r->bodies + 1, n = b->highest;
    int c, i, k;
    if (r->has_base)
        start_base(b);
    for (c = 0; c < r->bodies; c++) {
        if (!b->exact) {
            b->x[c] = PRODUCT * largest_term(r, c, 0, span);
            b->v[c] = PRODUCT * largest_term(r, c, f->rates, span);
        }
        for (k = 0; r->mode->leader[c] == base && k <= n; k++)
            b->v[k * columns + c] = b->v[k * columns + base];
    }
    if (r->has_motor) {
        b->angle = ONCE * fabs(f->table[r->bodies]); /* pi / 2 is none of the numbers */
        if (!b->exact) {
            b->w[0] = PRODUCT * fabs(f->w_back[f->order]);
            b->angle = PRODUCT + PRODUCT * fabs(f->table[r->bodies]);
        }
    }
    b->late = b->exact ? (Real)0.0 : ONCE * fabs(r->t0);
    for (i = 0; i < r->force_count; i++) {
        const Force *force = &r->forces[i];
        Series errors;
        for (k = 0; k < n; k++)
            errors[k] = 0.0;
        for (k = 0; k < force->count; k++)
            add_harmonic(&force->terms[k], r->t0, n, errors, 1);
        for (k = 0; k < n; k++) {
            Real *load = &b->load[k * columns + force->on];
            *load = *load + errors[k] + ONCE * fabs(f->loaded_on[force->on][k]);
        }
    }
}

/* Series of operation i of the tape. */
static const Real *along(const Run *r, int i) { return series_along(r->taylor.tapes.series, i); }

/* Add a force and its rounding to those on a group. */
static void push(Bounds *b, int leader, Real value, Real lost)
{
    b->force[leader] = b->force[leader] + value;
    b->lost[leader] = b->lost[leader] + lost + ONCE * fabs(b->force[leader]);
}

/* Of coefficient n of x_P - x_Q, or of its rate. */
static Real of_difference(const Bounds *b, int P, int Q, int n, int rates)
{
    const Real *of = (rates ? b->v : b->x) + n * b->r->columns;
    if (n > 0 && b->r->mode->leader[P] == b->r->mode->leader[Q]) /* one motion */
        return 0.0;
    return of[P] + of[Q] + ONCE * fabs(series_of(b->r, P, n, rates) - series_of(b->r, Q, n, rates));
}

/* Of coefficient n of the force of a coupling. */
static Real of_coupling(const Bounds *b, const Coupling *q, int n)
{
    const Run *r = b->r;
    const Real lost = q->k * of_difference(b, q->P, q->Q, n, 0) + q->c * of_difference(b, q->P, q->Q, n, r->taylor.rates);
    const Real size = q->k * fabs(place(r, q->P, n) - place(r, q->Q, n)) + q->c * fabs(rate(r, q->P, n) - rate(r, q->Q, n));
    return lost + PRODUCT * (n == 0 ? size + fabs(q->offset) : size);
}

/* Add that force and its rounding to those on both groups. */
static void push_coupling(Bounds *b, const Coupling *q, int n)
{
    const Run *r = b->r;
    const Real lost = of_coupling(b, q, n);
    Real value = q->k * (place(r, q->P, n) - place(r, q->Q, n)) + q->c * (rate(r, q->P, n) - rate(r, q->Q, n));
    if (n == 0)
        value = value + q->offset;
    push(b, q->to_P, -value, lost);
    push(b, q->to_Q, value, lost);
}

/* Of the sum of a_i b_(n-i), or of i a_i b_(n-i), from i = `first` to `last`; a, b: places on the tape. */
static Real of_products(const Bounds *b, int one, int other, int first, int last, int n, int weighted)
{
    const Real *of_one = along(b->r, one), *of_other = along(b->r, other);
    const int ops = b->r->mode->tape.op_count;
    Real total = 0.0;
    int i;
    for (i = first; i <= last; i++) {
        const Real a = of_one[i], with = of_other[n - i];
        const Real size = PRODUCT * fabs(a * with);
        const Real lost = b->tape[i * ops + one] * fabs(with) + fabs(a) * b->tape[(n - i) * ops + other] + size;
        total = total + (weighted ? i * lost : lost);
    }
    return total;
}

/* Of coefficient n > 0 of operation i. */
static Real of_following(const Bounds *b, int i, int n)
{
    const Tape *tape = &b->r->mode->tape;
    const Op *op = &tape->ops[i];
    const int ops = tape->op_count, with = op->code == OP_LOG ? op->a : op->b;
    const Real *a = along(b->r, op->a), *own = along(b->r, i), *lost = b->tape + op->a, inverse = b->r->taylor.inverse[n], y = fabs(own[n]);
    Real total = 0.0;
    int k;
    switch (op->code) {
    case OP_ADD:
    case OP_SUB: return lost[n * ops] + b->tape[n * ops + op->b] + EPS * y;
    case OP_SCALE: return fabs(op->value) * lost[n * ops] + 2 * EPS * y;
    case OP_MUL: return of_products(b, op->a, op->b, 0, n, n, 0);
    case OP_SQUARE: return of_products(b, op->a, op->a, 0, n, n, 0);
    case OP_SIN:
    case OP_COS:
    case OP_SINH:
    case OP_COSH:
    case OP_TANH: return of_products(b, op->a, op->b, 1, n, n, 1) * inverse;
    case OP_EXP: return of_products(b, op->a, i, 1, n, n, 1) * inverse;
    case OP_POWER:
        if (!(a[0] > b->r->taylor.tapes.least * fabs(a[1])))
            return 0.0;
        for (k = 0; k < n; k++) {
            const Real size = PRODUCT * fabs(a[n - k] * own[k]);
            const Real one = lost[(n - k) * ops] * fabs(own[k]) + fabs(a[n - k]) * b->tape[k * ops + i] + size;
            total = total + fabs(op->value * (n - k) - k) * one;
        }
        return (total * inverse + lost[0] * y) / fabs(a[0]);
    default:
        total = lost[n * ops] + PRODUCT * fabs(a[n]) + b->tape[with] * y;
        if (op->code == OP_DIV)
            total = total + of_products(b, with, i, 1, n, n, 0);
        else
            total = total + of_products(b, i, with, 1, n - 1, n, 1) * inverse;
        return quotient(total, fabs(*along(b->r, with)));
    }
}

/* Of order n along the tape. */
static void advance_tape(Bounds *b, int n)
{
    const Tape *tape = &b->r->mode->tape;
    const int columns = b->r->columns, ops = tape->op_count;
    const Real of_angle = n == 0 ? b->angle : b->w[n - 1] * b->r->taylor.inverse[n];
    Real *bounds = b->tape + n * ops;
    int i;
    for (i = 0; i < ops; i++) {
        const Op *op = &tape->ops[i];
        switch (op->code) {
        case OP_CONSTANT: break;
        case OP_TIME: bounds[i] = n == 0 ? b->late : (Real)0.0; break;
        case OP_PLACE: bounds[i] = b->x[n * columns + op->a]; break;
        case OP_SPEED: bounds[i] = b->v[n * columns + op->a]; break;
        case OP_ANGLE: bounds[i] = of_angle; break;
        case OP_SPIN: bounds[i] = b->w[n]; break;
        default: bounds[i] = n == 0 ? tape_bound(op, b->values[i], b->values, bounds) : of_following(b, i, n);
        }
    }
}

/* Of the accelerations that the motor's rotor takes part in: of its body's group, and its own. */
static void turn(Bounds *b, int n)
{
    const Run *r = b->r;
    const Taylor *f = &r->taylor;
    const Real *w = f->w_back + f->order, *a1 = f->a1_back + f->order, inverse = f->inverse[n + 1]; /* coefficient k is number -k */
    const int on = r->mode->leader[r->motor_on];
    Real thrust = 0.0, torque = 0.0, lost, spun;
    int i;
    for (i = 0; i < n + 2; i++) {
        const Real sine = fabs(f->sine[i]), speed = fabs(w[i - n - 1]);
        thrust = thrust + sine * (ROTATION * speed + b->w[n + 1 - i]) + b->angle * fabs(f->cosine[i]) * speed;
        torque = torque + (i <= n ? sine * fabs(a1[i - n]) : (Real)0.0);
    }
    lost = b->lost[on] + r->unbalance * (n + 1) * thrust + ROTATION * fabs(b->force[on]);
    spun = r->drag * (fabs(w[-n]) + b->w[n] / ROTATION) + r->unbalance * torque;
    spun = ROTATION * (n == 0 ? spun + r->M0 : spun);
    if (r->mode->carried > 0) {
        const Real mass = r->mode->carried + r->m3, coupling = r->unbalance * f->sine[0];
        const Real inverse_det = 1 / (mass * r->inertia - coupling * coupling), cross = fabs(coupling * inverse_det);
        b->by_speed[on] = r->inertia * inverse_det * lost + cross * spun;
        b->w[n + 1] = (mass * inverse_det * spun + cross * lost) * inverse;
    } else {
        b->w[n + 1] = spun / r->inertia * inverse;
    }
}

/* The same of rotor i on a body of group g: adds to what is lost on the group. */
static void twist(Bounds *b, int i, int g, int n, Real *lost)
{
    const Run *r = b->r;
    const Rotors *o = &r->rotors;
    const RotorOn *one = &o->of[i];
    const int columns = r->columns;
    const Real angle = b->x[one->column] + ONCE * fabs(place(r, one->column, 0));
    Real thrust = 0.0, torque = 0.0;
    int k;
    for (k = 0; k < n + 2; k++) {
        const Real sine = fabs(series_along(o->sine, i)[k]), speed = fabs(rate(r, one->column, n + 1 - k));
        const Real slow = k > 0 ? b->v[(n + 1 - k) * columns + one->column] : (Real)0.0;
        thrust = thrust + sine * (ROTATION * speed + slow) + angle * fabs(series_along(o->cosine, i)[k]) * speed;
        torque = torque + (k <= n ? sine * fabs(series_along(o->acceleration, g)[n - k]) : (Real)0.0);
    }
    b->twist[i] = b->lost[one->column] + ROTATION * one->unbalance * torque;
    *lost = *lost + one->unbalance * ((n + 1) * thrust + b->twist[i] / one->inertia);
}

/* The same of all rotors on bodies and of the groups that they are on. */
static void turn_groups(Bounds *b, int n)
{
    const Run *r = b->r;
    const Rotors *o = &r->rotors;
    int g, i;
    for (g = 0; g < o->groups; g++) {
        const int leader = o->leaders[g];
        Real lost = 0.0;
        for (i = 0; i < o->count; i++)
            if (r->mode->leader[o->of[i].on] == leader)
                twist(b, i, g, n, &lost);
        if (leader < r->bodies)
            b->by_speed[leader] = (b->lost[leader] + lost + ROTATION * fabs(b->force[leader])) / fabs(o->mass[g]);
    }
    for (i = 0; i < o->count; i++) {
        const RotorOn *one = &o->of[i];
        b->by_speed[one->column] = (b->twist[i] + one->unbalance * b->by_speed[r->mode->leader[one->on]]) / one->inertia;
    }
}

/* Coefficients n + 1 from those of order n. */
static void advance(Bounds *b, int n)
{
    const Run *r = b->r;
    const Taylor *f = &r->taylor;
    const Mode *m = r->mode;
    const int columns = r->columns;
    const Real inverse = f->inverse[n + 1], *v = b->v + n * columns;
    Real *next_x = b->x + (n + 1) * columns, *next_v = b->v + (n + 1) * columns;
    int c, i;
    for (c = 0; c < columns; c++)
        b->force[c] = b->lost[c] = 0.0;
    for (i = 0; i < f->loaded_count; i++) {
        c = f->loaded[i];
        push(b, m->leader[c], f->loaded_on[c][n], b->load[n * columns + c]);
    }
    for (i = 0; i < m->coupling_count; i++)
        push_coupling(b, &m->couplings[i], n);
    for (i = 0; n == 0 && i < m->constant_count; i++)
        push(b, m->leader[m->constant_columns[i]], m->constants[i], 0.0);
    if (m->tape.op_count > 0)
        advance_tape(b, n);
    for (i = 0; i < m->formula_count; i++) {
        const FormulaForce *one = &m->formulas[i];
        const Real value = one->sign * along(r, one->place)[n], lost = b->tape[n * m->tape.op_count + one->place];
        push(b, one->to_P, value, lost);
        if (one->to_Q >= 0)
            push(b, one->to_Q, -value, lost);
    }
    for (c = 0; c < columns; c++)
        b->by_speed[c] = b->lost[c] * m->mobility[c];
    if (r->has_motor)
        turn(b, n);
    if (r->rotors.count > 0)
        turn_groups(b, n);
    for (c = 0; c < r->bodies; c++) {
        next_x[c] = v[c] * inverse + ONCE * fabs(place(r, c, n + 1));
        if (m->leader[c] < r->bodies)
            next_v[c] = b->by_speed[m->leader[c]] * inverse + PRODUCT * fabs(rate(r, c, n + 1));
    }
    for (i = 0; i < m->follower_count; i++) {
        const Follower *one = &m->followers[i];
        next_v[one->column] = next_v[one->column] + b->tape[n * m->tape.op_count + one->place] * inverse;
    }
}

/* Of what a motor exerts on a column while that is tied to the ground or the base. */
static Real of_thrust(const Bounds *b, int column, int n)
{
    const Run *r = b->r;
    const Taylor *f = &r->taylor;
    const Real *w = f->w_back + f->order;
    Real size, turned = 0.0;
    int i;
    if (!r->has_motor || r->motor_on != column)
        return 0.0;
    size = r->m3 * fabs(f->a1_back[f->order - n]);
    for (i = 0; i < n + 2; i++) {
        size = size + r->unbalance * (n + 1) * fabs(f->sine[i] * w[i - n - 1]);
        turned = turned + r->unbalance * (n + 1) * fabs(f->cosine[i] * w[i - n - 1]);
    }
    return ROTATION * size + b->angle * turned;
}

/* Of coefficient n, which is `value`, of a term of an event function. */
static Real of_term(const Bounds *b, const Term *t, Real value, int n)
{
    const Run *r = b->r;
    const Real size = fabs(t->coefficient);
    switch (t->kind) {
    case DIFFERENCE:
    case RATE: return size * of_difference(b, t->P, t->Q, n, t->kind == RATE ? r->taylor.rates : 0) + (size != 1 ? ONCE * fabs(value) : (Real)0.0);
    case COUPLING: return size * of_coupling(b, &r->mode->couplings[t->P], n);
    case ACCELERATION: return size * (n + 1) * b->v[(n + 1) * r->columns + t->P] + PRODUCT * fabs(value);
    case FORMULA: return size * b->tape[n * r->mode->tape.op_count + r->mode->tape.outputs[t->P]] + PRODUCT * fabs(value);
    default: return size * b->load[n * r->columns + t->P] + of_thrust(b, t->P, n);
    }
}

/* Of the derivatives of an event function. */
static void of_event(const Bounds *b, const Event *e, int count, int summed, Real *out)
{
    const Run *r = b->r;
    Series values, total;
    Real factorial = 1.0;
    int i, n;
    for (n = 0; n <= count; n++)
        out[n] = total[n] = 0.0;
    for (i = 0; i < e->terms; i++) {
        const Term *t = &r->mode->terms[e->first + i];
        taylor_term(r, t, values);
        for (n = 0; n <= count; n++) {
            total[n] = total[n] + values[n];
            out[n] = out[n] + of_term(b, t, values[n], n) + ONCE * fabs(total[n]);
        }
    }
    out[0] = out[0] + ONCE * fabs(total[0] + e->constant);
    if (summed)
        out[0] = out[0] + ONCE * e->size;
    for (n = 0; n <= count; n++) {
        factorial = n > 0 ? factorial * n : factorial;
        out[n] = factorial * out[n];
    }
}

/* See engine.h: bounds by order, each from those of the order before, then of the event function. */
int taylor_bounds(const Run *r, const Event *e, int count, int exact, int summed, Real span, Real *out)
{
    const int orders = count + 2, columns = r->columns, ops = r->mode->tape.op_count;
    Bounds b;
    Real *room = zalloc((size_t)(orders * (3 * columns + ops + 1) + 3 * columns + ops + r->rotors.count), sizeof(Real));
    int i, n;
    if (!room)
        return 0;
    b.r = r;
    b.highest = count + 1;
    b.exact = exact;
    b.angle = b.late = 0.0;
    b.x = room;
    b.v = b.x + orders * columns;
    b.load = b.v + orders * columns;
    b.tape = b.load + orders * columns;
    b.w = b.tape + orders * ops;
    b.force = b.w + orders;
    b.lost = b.force + columns;
    b.by_speed = b.lost + columns;
    b.values = b.by_speed + columns;
    b.twist = b.values + ops;
    for (i = 0; i < ops; i++)
        b.values[i] = *along(r, i);
    start(&b, span);
    for (n = 0; n < b.highest; n++)
        advance(&b, n);
    of_event(&b, e, count, summed, out);
    free(room);
    return 1;
}
