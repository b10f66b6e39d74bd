/* What is computed along tapes: series, values with bounds, and steps at whose end the two agree; twin of vibsim/engine/flows/tape.py
 * and of what vibsim/engine/flows/taylor.py does with formulas.
 */
#include "engine.h"
#include "inlining.h"
#include "numbers.h"
#include "pair.h"

#define NEAR_ZERO 16          /* units in the last place of the time within which a zero of the base of a power is one here */
#define ULPS 4                /* rounding of an elementary function, in units of EPS */
#define SHORT_CONTACT 16.0    /* binary digits by which a step is too long that ends behind a contact that it begins */
#define SHORTENINGS 400       /* of a step, each at least by */
#define LEAST_SHORTENING 0.25 /* binary digits */
#define BEYOND_ALL 60.0       /* binary digits by which a value that is no number is beyond */
#define NEARER 0.75           /* of a step, where formulas are compared as well */
#define INPUT_ROUNDING 2      /* of displacements and velocities at the end of a step, in units of EPS */
#define STATE_ROUNDING 8      /* the same at an event */

#define BACK(series, n) ((series) + (TAPE_WIDTH - 1 - (n))) /* where coefficient n - i of a series is number i */

/* Coefficient n of a series, forwards and backwards. */
INLINE void put(Real *series, int n, Real value)
{
    series[n] = value;
    *BACK(series, n) = value;
}

/* a / b, and what is no number where b is 0. */
static Real quotient(Real a, Real b)
{
    return b == 0 ? NAN : a / b;
}

/* The value of an operation on values. A power of what is negative is that of 0, with an exponent below 0 it counts as 0. */
static Real start_value(const Op *op, Real a, Real b)
{
    switch (op->code) {
    case OP_ADD: return a + b;
    case OP_SUB: return a - b;
    case OP_SCALE: return op->value * a;
    case OP_MUL: return a * b;
    case OP_SQUARE: return a * a;
    case OP_DIV: return quotient(a, b);
    case OP_SIN: return sine_of(a);
    case OP_COS: return cosine_of(a);
    case OP_SINH: return hyperbolic_sine(a);
    case OP_COSH: return hyperbolic_cosine(a);
    case OP_EXP: return exponential(a);
    case OP_LOG: return a > 0 ? logarithm(a) : NAN;
    case OP_TANH: return hyperbolic_tangent(a);
    case OP_ATAN: return arctangent(a);
    case OP_ASIN: return arcsine(a);
    case OP_ACOS: return arccosine(a);
    default: return a > 0 ? real_power(a, op->value) : op->value < 0 ? 0 * a : real_power(0 * a, op->value);
    }
}

/* Sum of a_i b_(n-i) from i = 1 to last, odd and even terms apart; back[i]: b_(n-i). */
INLINE Real middle(const Real *a, const Real *back, int last)
{
    Pair sums = twice(0.0);
    Real odd;
    int i;
    for (i = 1; i < last; i += 2)
        sums = add_product(sums, load_pair(a + i), load_pair(back + i));
    odd = first_of_pair(sums);
    if (i == last)
        odd = odd + a[i] * back[i];
    return odd + second_of_pair(sums);
}

/* The same of i a_i b_(n-i). */
INLINE Real weighted(const Real *a, const Real *back, int last)
{
    Pair sums = twice(0.0), weights = make_pair(1.0, 2.0);
    Real odd;
    int i;
    for (i = 1; i < last; i += 2) {
        sums = add_product(sums, multiply_pair(weights, load_pair(a + i)), load_pair(back + i));
        weights = add_pair(weights, twice(2.0));
    }
    odd = first_of_pair(sums);
    if (i == last)
        odd = odd + (i * a[i]) * back[i];
    return odd + second_of_pair(sums);
}

/* Of a^p: n a_0 y_n = sum (p (n - i) - i) a_(n-i) y_i over i < n; at a zero of a, or one nearer than `least` [s], nothing but the
 * value.
 */
static Real power_coefficient(const Real *a, const Real *back, const Real *y, Real p, int n, Real inverse, Real least)
{
    Real odd = 0.0, even = 0.0;
    int i;
    if (!(a[0] > least * fabs(a[1])))
        return 0 * a[0];
    for (i = 1; i + 1 < n; i += 2) {
        odd = odd + (p * (n - i) - i) * (back[i] * y[i]);
        even = even + (p * (n - i - 1) - (i + 1)) * (back[i + 1] * y[i + 1]);
    }
    if (i < n)
        odd = odd + (p * (n - i) - i) * (back[i] * y[i]);
    return ((odd + even) + (p * n) * (a[n] * y[0])) * inverse / a[0];
}

/* Coefficient n > 0 of operation i. What is known of a sum before order n comes first, so that little waits for its newest terms. */
INLINE Real following(const Op *op, TapeSeries *series, int i, int n, Real inverse, Real least)
{
    const Real *a = series[op->first], *b = series[op->second], *s = series[i];
    Real known, newest;
    switch (op->code) {
    case OP_ADD: return a[n] + b[n];
    case OP_SUB: return a[n] - b[n];
    case OP_SCALE: return op->value * a[n];
    case OP_MUL: return middle(a, BACK(b, n), n - 1) + (a[0] * b[n] + a[n] * b[0]);
    case OP_SQUARE:
        known = middle(a, BACK(a, n), (n - 1) / 2);
        known = known + known;
        if (n % 2 == 0)
            known = known + a[n / 2] * a[n / 2];
        newest = a[0] * a[n];
        return known + (newest + newest);
    case OP_DIV: return quotient(a[n] - (middle(b, BACK(s, n), n - 1) + b[n] * s[0]), b[0]);
    case OP_SIN:
    case OP_SINH:
    case OP_COSH:
    case OP_TANH:
    case OP_EXP: return (weighted(a, BACK(b, n), n - 1) + (n * a[n]) * b[0]) * inverse;
    case OP_COS: return -((weighted(a, BACK(b, n), n - 1) + (n * a[n]) * b[0]) * inverse);
    case OP_LOG: return quotient(a[n] - weighted(s, BACK(a, n), n - 1) * inverse, a[0]);
    case OP_ATAN:
    case OP_ASIN: return quotient(a[n] - weighted(s, BACK(b, n), n - 1) * inverse, b[0]);
    case OP_ACOS: return quotient(-a[n] - weighted(s, BACK(b, n), n - 1) * inverse, b[0]);
    default: return power_coefficient(a, BACK(a, n), s, op->value, n, inverse, least);
    }
}

void tape_start(TapeRoom *room, Real t)
{
    room->at.t = t;
    room->least = NEAR_ZERO * (nextafter(t, INFINITY) - t);
}

/* Order 0 along a tape. */
static void begin(const Tape *tape, const TapeRoom *room, const Real *row)
{
    TapeSeries *series = room->series;
    int i;
    for (i = 0; i < tape->op_count; i++) {
        const Op *op = &tape->ops[i];
        Real value;
        if (op->code == OP_CONSTANT)
            value = op->value;
        else if (op->code == OP_TIME)
            value = room->at.t;
        else if (op->code <= OP_SPIN)
            value = op->from < 0 ? 0.0 : row[op->from];
        else
            value = start_value(op, series[op->a][0], op->b < 0 ? 0.0 : series[op->b][0]);
        put(series[i], 0, value);
    }
}

void tape_advance(const Tape *tape, const TapeRoom *room, const Real *row, int n, Real inverse)
{
    TapeSeries *series = room->series;
    int i;
    if (n == 0) {
        begin(tape, room, row);
        return;
    }
    for (i = 0; i < tape->op_count; i++) {
        const Op *op = &tape->ops[i];
        if (op->code > OP_SPIN)
            put(series[i], n, following(op, series, i, n, inverse, room->least));
        else if (op->from >= 0)
            put(series[i], n, row[op->from]);
        else
            put(series[i], n, op->code == OP_TIME && n == 1 ? 1.0 : 0.0);
    }
}

static Real input_value(const Op *op, const TapeInputs *at)
{
    switch (op->code) {
    case OP_TIME: return at->t;
    case OP_PLACE: return at->x[op->a];
    case OP_SPEED: return at->v[op->a];
    case OP_ANGLE: return at->phi;
    default: return at->w;
    }
}

/* The size of the derivative of a function where its argument has the size a, or a bound of it; value: of the function. */
static Real slope_of(const Op *op, Real a, Real value, const Real *values)
{
    switch (op->code) {
    case OP_SIN:
    case OP_COS:
    case OP_TANH:
    case OP_ATAN: return 1.0;
    case OP_EXP: return value;
    case OP_SINH:
    case OP_COSH: return hyperbolic_cosine(a);
    case OP_POWER: return a > 0 ? quotient(fabs(op->value) * value, a) : 0.0;
    case OP_LOG: return quotient(1.0, a);
    default: return quotient(1.0, fabs(values[op->b]));
    }
}

/* What the rounding of its operands and its own make of the result of an operation, to first order. */
static Real bound_of(const Op *op, Real result, const Real *values, const Real *bounds)
{
    Real value = fabs(result), a = fabs(values[op->a]), lost = bounds[op->a], b;
    switch (op->code) {
    case OP_ADD:
    case OP_SUB: return lost + bounds[op->b] + EPS * value;
    case OP_SCALE: return fabs(op->value) * lost + 2 * EPS * value;
    case OP_SQUARE: return 2 * a * lost + EPS * value;
    case OP_MUL: return a * bounds[op->b] + fabs(values[op->b]) * lost + EPS * value;
    case OP_DIV:
        b = fabs(values[op->b]);
        return quotient(lost + value * bounds[op->b], b) + EPS * value;
    default: return slope_of(op, a, value, values) * lost + ULPS * EPS * value;
    }
}

void tape_evaluate(const Tape *tape, const TapeInputs *at, const TapeInputs *blur, Real *values, Real *bounds)
{
    int i;
    for (i = 0; i < tape->op_count; i++) {
        const Op *op = &tape->ops[i];
        if (op->code == OP_CONSTANT) {
            values[i] = op->value;
            bounds[i] = 0.0;
        } else if (op->code <= OP_SPIN) {
            values[i] = input_value(op, at);
            bounds[i] = fabs(input_value(op, blur));
        } else {
            values[i] = start_value(op, values[op->a], op->b < 0 || op->b >= i ? 0.0 : values[op->b]);
            bounds[i] = bound_of(op, values[i], values, bounds);
        }
    }
}

/* Values and bounds of the formulas of the mode a time tau after the expansion point, from the state there. */
void tape_values(const Run *r, Real tau)
{
    const Taylor *f = &r->taylor;
    const TapeRoom *room = &f->tapes;
    TapeInputs at = room->at, blur = room->blur;
    const Real *values = tau != 0 ? f->values : f->table;
    int c;
    if (tau != 0 || r->has_motor)
        taylor_values(f, tau, f->values);
    for (c = 0; c < r->columns; c++) {
        int from = c < r->bodies ? c : c > r->bodies && r->has_base ? base_column(r) : -1;
        at.x[c] = from < 0 ? 0.0 : values[from];
        at.v[c] = from < 0 ? 0.0 : values[f->rates + from];
        blur.x[c] = INPUT_ROUNDING * EPS * fabs(at.x[c]);
        blur.v[c] = INPUT_ROUNDING * EPS * fabs(at.v[c]);
    }
    at.t = r->t0 + tau;
    blur.t = EPS * fabs(at.t);
    at.phi = r->has_motor ? f->values[r->bodies] : 0.0;
    at.w = r->has_motor ? f->values[f->rates + r->bodies] : 0.0;
    blur.phi = INPUT_ROUNDING * EPS * fabs(at.phi);
    blur.w = INPUT_ROUNDING * EPS * fabs(at.w);
    tape_evaluate(&r->mode->tape, &at, &blur, room->values, room->bounds);
}

/* The same of mode m at r->next; X, V: displacement and velocity of the base there. rates: of all velocities, in the order of
 * the table, for what the rounding of the time leaves open of them; NULL where bounds are not asked for.
 */
void tape_values_at(const Run *r, const Mode *m, Real X, Real V, const Real *rates)
{
    const State *state = &r->next;
    const TapeRoom *room = &r->taylor.tapes;
    TapeInputs at = room->at, blur = room->blur;
    const Real lost = STATE_ROUNDING * EPS, late = lost * fabs(state->t);
    int c;
    for (c = 0; c < r->columns; c++) {
        at.x[c] = c < r->bodies ? state->x[c] : c == r->bodies ? 0.0 : X;
        at.v[c] = c < r->bodies ? state->v[c] : c == r->bodies ? 0.0 : V;
        blur.x[c] = lost * fabs(at.x[c]) + late * fabs(at.v[c]);
        blur.v[c] = lost * fabs(at.v[c]);
        if (rates && c != r->bodies && (c < r->bodies || r->has_base))
            blur.v[c] = blur.v[c] + late * fabs(rates[column_in_table(r, c)]);
    }
    at.t = state->t;
    blur.t = late;
    at.phi = unwind(state->phase, state->turns);
    at.w = state->w;
    blur.phi = lost * fabs(at.phi);
    blur.w = lost * fabs(at.w);
    tape_evaluate(&m->tape, &at, &blur, room->values, room->bounds);
}

/* Rounding of a series at h. */
static Real rounding_of(const Real *series, int count, Real h)
{
    Real total = fabs(series[count - 1]);
    int n;
    for (n = count - 2; n >= 0; n--)
        total = total * h + fabs(series[n]);
    return 2 * EPS * total;
}

/* Whether a column has units of its own, as a rotor or a state. */
static int stands_alone(const Run *r, int column)
{
    int k;
    for (k = 0; k < r->alone_count; k++)
        if (r->alone[k] == column)
            return 1;
    return 0;
}

/* Size of a velocity over a step of length h: of a body that of all bodies together. */
static Real speed_of(const Run *r, int leader, Real h)
{
    const Taylor *f = &r->taylor;
    const Real *rates = f->table + f->rates;
    Real total = 0.0;
    int c;
    if (stands_alone(r, leader))
        return fabs(rates[leader]) + h * fabs(rates[f->stride + leader]);
    for (c = 0; c < r->bodies; c++)
        if (!stands_alone(r, c))
            total = total + (fabs(rates[c]) + h * fabs(rates[f->stride + c]));
    return total;
}

/* How wrong a force may be so that velocities are not wrong beyond the tolerance of the step; of what is at rest and begins
 * to move, where `value` is the force at h, beyond that of the speed it would come to. */
static Real share_of(const Run *r, int k, Real h, Real value, Real tolerance)
{
    const Taylor *f = &r->taylor;
    const Mode *m = r->mode;
    Real share = INFINITY;
    int mobile = 0, i, end;
    for (i = 0; i < m->formula_count; i++) {
        const FormulaForce *one = &m->formulas[i];
        if (one->output != k)
            continue;
        for (end = 0; end < 2; end++) {
            int leader = end ? one->to_Q : one->to_P;
            Real speed;
            if (leader < 0 || !(m->mobility[leader] > 0))
                continue;
            speed = speed_of(r, leader, h);
            if (!(speed > 0))
                speed = m->mobility[leader] * fabs(value) * (r->t_end - r->t0);
            speed = speed / (h * m->mobility[leader]);
            share = speed < share ? speed : share;
            mobile = 1;
        }
    }
    return mobile ? f->order * tolerance * share : 0.0;
}

/* By how many binary digits the worst formula is beyond what it may be wrong by at h after the start; 0 where none is. */
static double excess(const Run *r, Real h, Real tolerance, int *singular)
{
    const Taylor *f = &r->taylor;
    const Tape *tape = &r->mode->tape;
    double worst = 0.0;
    int k;
    tape_values(r, h);
    for (k = 0; k < tape->op_count; k++) { /* begun at a zero of its base, which must not be over before the step is */
        const Op *op = &tape->ops[k];
        const Real *base = f->tapes.series[op->a < 0 ? 0 : op->a];
        if (op->code == OP_POWER && base[1] > 0 && !(base[0] > f->tapes.least * base[1]) && f->tapes.values[op->a] < -f->tapes.bounds[op->a])
            worst = SHORT_CONTACT;
    }
    for (k = 0; k < tape->output_count; k++) {
        int place = tape->outputs[k];
        const Real *series = f->tapes.series[place];
        Real allowed = 2 * f->tapes.bounds[place] + rounding_of(series, f->order, h) + share_of(r, k, h, f->tapes.values[place], tolerance);
        Real off = fabs(f->tapes.values[place] - horner(series, f->order, h));
        double beyond;
        if (off <= allowed && isfinite(allowed)) /* a value that overflows has no bound */
            continue;
        beyond = BEYOND_ALL;
        if (isfinite(off) && allowed > 0) {
            beyond = binary_exponent(off) - binary_exponent(allowed);
            beyond = beyond > 1.0 ? beyond : 1.0;
        }
        if (beyond > worst) {
            worst = beyond;
            *singular = k;
        }
    }
    return worst;
}

/* The step that is not made shorter: where the base of a power falls to its zero and is there within the resolution of time.
 */
static Real shortest_step(const Run *r)
{
    const TapeRoom *room = &r->taylor.tapes;
    const Tape *tape = &r->mode->tape;
    int k;
    for (k = 0; k < tape->op_count; k++) {
        const Real *base;
        if (tape->ops[k].code != OP_POWER)
            continue;
        base = room->series[tape->ops[k].a];
        if (base[1] < 0 && !(base[0] > room->least * fabs(base[1])))
            return 2 * room->least;
    }
    return 0.0;
}

/* The step, or a shorter one, at the end of which the formulas have the values that their series say. */
void sound_step(Run *r)
{
    Taylor *f = &r->taylor;
    const Real left = r->t_end - r->t0, tolerance = power_of_two(r->tolerance_exponent);
    Real h = f->h < left ? f->h : left, shortest;
    int i;
    if (!(left > 0))
        return;
    shortest = shortest_step(r);
    r->singular = NOTHING;
    for (i = 0; i < SHORTENINGS; i++) {
        double most = excess(r, h, tolerance, &r->singular), nearer = excess(r, NEARER * h, tolerance, &r->singular), digits;
        most = nearer > most ? nearer : most;
        if (most <= 0 || h <= shortest) {
            f->h = h == left ? f->h : h;
            return;
        }
        digits = (most + 1) / f->order;
        h = h * power_of_two(-(digits > LEAST_SHORTENING ? digits : LEAST_SHORTENING));
        if (r->t0 + h == r->t0)
            break;
    }
    r->status = SINGULAR;
}
