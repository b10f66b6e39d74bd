/* What is computed along tapes: series, and values with bounds of their rounding. */
#include "engine.h"
#include "numbers.h"
#include "tape_series.h"

#define NEAR_ZERO 16          /* units in the last place of the time within which a zero of the base of a power is one here */
#define ULPS 4                /* rounding of an elementary function, in units of EPS */

#define VALUE(CODE, name, of, sign, text) \
    case OP_##CODE: return OP_##CODE != OP_LOG || a > 0 ? of(a) : NAN;

/* The value of an operation on values. A power of what is negative is that of 0, which with an exponent below 0 counts as 0: of
 * slopes, whose instant of being infinite a step leaves behind.
 */
static Real start_value(const Op *op, Real a, Real b)
{
    switch (op->code) {
    case OP_ADD: return a + b;
    case OP_SUB: return a - b;
    case OP_SCALE: return op->value * a;
    case OP_MUL: return a * b;
    case OP_SQUARE: return a * a;
    case OP_DIV: return quotient(a, b);
        ELEMENTARY_FUNCTIONS(VALUE)
    default: return a > 0 ? real_power(a, op->value) : op->value < 0 ? 0 * a : real_power(0 * a, op->value);
    }
}

void tape_start(TapeRoom *room, Real t, Real nearest, const Real *inverse, int orders)
{
    const Real resolved = NEAR_ZERO * (nextafter(t, INFINITY) - t);
    room->at.t = t;
    room->inverse = inverse;
    room->orders = orders;
    room->least = nearest > resolved ? nearest : resolved;
}

/* How many operations, from one on, read each other's orders before. */
static int joined(const Op *op, const Op *end)
{
    const int count = op->code == OP_TANH ? 3 : op->code == OP_SIN || op->code == OP_SINH ? 2 : 1;
    return count < end - op ? count : (int)(end - op);
}

/* A function, of the kind of exp or sin, of what grows evenly with the time: of its sums of products one is left. */
static void advance_evenly(const Op *op, const TapeRoom *room)
{
    Real *own = room->series + op->at, *other = room->series + op->second, y = *own, z = *other;
    const Real rate = room->series[op->first + 1];
    int n;
    for (n = 1; n < room->orders; n++) {
        const Real next = (0.0 + rate * z) * room->inverse[n], beside = (0.0 + rate * y) * room->inverse[n];
        z = op->code == OP_SIN ? -beside : beside;
        y = next;
        put(own, n, y);
        if (op->code != OP_EXP)
            put(other, n, z);
    }
}

/* All orders of an operation that takes those of its operands one by one, or reads; 0 where it is none. */
static int advance_at_once(const Op *op, Real *series, int orders, const Real *table, int stride)
{
    Real *restrict own = series + op->at;
    const Real *a = series + op->first, *b = series + op->second;
    int n;
    if (op->code == OP_ADD)
        for (n = 1; n < orders; n++)
            own[n] = a[n] + b[n];
    else if (op->code == OP_SUB)
        for (n = 1; n < orders; n++)
            own[n] = a[n] - b[n];
    else if (op->code == OP_SCALE)
        for (n = 1; n < orders; n++)
            own[n] = op->value * a[n];
    else if (op->code <= OP_SPIN)
        for (n = 1; n < orders; n++)
            own[n] = table[n * stride + op->from];
    else
        return 0;
    for (n = 1; op->turned && n < orders; n++)
        *BACK(own, n) = own[n];
    return 1;
}

/* All orders behind the values of operations, one operation after the other; table: of the series of what they read. */
static void advance_apart(const Op *op, int count, const TapeRoom *room, const Real *table, int stride)
{
    const Op *end = op + count;
    Real *series = room->series;
    int n, k, several;
    for (; op < end; op += several) {
        several = joined(op, end);
        if (op->even && (op->code == OP_EXP || several == 2)) {
            advance_evenly(op, room);
            continue;
        }
        if (advance_at_once(op, series, room->orders, table, stride))
            continue;
        for (n = 1; n < room->orders; n++)
            for (k = 0; k < several; k++) {
                Real *now = series + n, *back = BACK(series, n);
                put(series + op[k].at, n, following(op + k, series, now, back, 0.0, n, room->inverse[n], room->least));
            }
    }
}

/* The series, but for their values, of what is the same at every instant. */
static void begin_once(const Tape *tape, TapeRoom *room)
{
    Real *series = room->series;
    int i, n;
    for (i = 0; i < tape->op_count; i++) {
        const Op *op = &tape->ops[i];
        if (op->when != ONCE_FOR_ALL || (op->code == OP_CONSTANT && !op->used))
            continue;
        if (op->code > OP_SPIN && advance_at_once(op, series, room->orders, NULL, 0))
            continue;
        for (n = 1; n < room->orders; n++)
            put(series + op->at, n, op->code == OP_TIME && n == 1 ? 1.0 : 0.0);
    }
    room->tape = tape->number;
    room->made = room->orders;
}

/* Whether two numbers are one, and not zeros, which may differ in sign. */
static int is_same(Real one, Real other)
{
    return one == other && one != 0;
}

void tape_begin(const Tape *tape, TapeRoom *room, const Real *row)
{
    Real *series = room->series;
    Real cosine = 0.0;
    const int ended = room->latest == tape->number;
    int i;
    if (room->tape != tape->number || room->made < room->orders)
        begin_once(tape, room);
    for (i = 0; i < tape->op_count; i++) {
        const Op *op = &tape->ops[i];
        Real value;
        if (op->code == OP_CONSTANT && !op->used)
            continue;
        if (op->code == OP_CONSTANT)
            value = op->value;
        else if (op->code == OP_TIME)
            value = room->at.t;
        else if (op->code <= OP_SPIN)
            value = op->from < 0 ? 0.0 : row[op->from];
        else if (op->code == OP_SIN) /* its cosine comes next */
            sine_cosine(*series_along(series, op->a), &value, &cosine);
        else if (op->code == OP_COS)
            value = cosine;
        else if (op->code > OP_DIV && op->used && ended && is_same(room->checked[op->a], *series_along(series, op->a)))
            value = room->checked[i]; /* of the end of the step before */
        else
            value = start_value(op, *series_along(series, op->a), op->b < 0 ? 0.0 : *series_along(series, op->b));
        put(series_along(series, i), 0, value);
    }
    advance_apart(tape->ahead, tape->ahead_count, room, NULL, 0);
}

void tape_advance(const Tape *tape, TapeRoom *room, const Real *row, int n)
{
    if (n == 0)
        tape_begin(tape, room, row);
    else
        advance_along(tape, room, row, n, room->inverse[n], 0, 0, 0.0, 0.0);
}

void tape_end(const Tape *tape, const TapeRoom *room, const Real *table, int stride)
{
    advance_apart(tape->behind, tape->behind_count, room, table, stride);
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

/* What the rounding of its operands and its own make of the result of an operation: to first order, of products in full, as one
 * of what rounds to zero, such as (1 - cos(w t))^2 soon after t = 0, has nothing else.
 */
INLINE Real bound_of(const Op *op, Real result, const Real *values, const Real *bounds)
{
    Real value = fabs(result), a = fabs(values[op->a]), lost = bounds[op->a], b;
    switch (op->code) {
    case OP_ADD:
    case OP_SUB: return lost + bounds[op->b] + EPS * value;
    case OP_SCALE: return fabs(op->value) * lost + 2 * EPS * value;
    case OP_SQUARE: return (2 * a + lost) * lost + EPS * value;
    case OP_MUL: return a * bounds[op->b] + (fabs(values[op->b]) + bounds[op->b]) * lost + EPS * value;
    case OP_DIV:
        b = fabs(values[op->b]);
        return quotient(lost + value * bounds[op->b], b) + EPS * value;
    default: return slope_of(op, a, value, values) * lost + ULPS * EPS * value;
    }
}

Real tape_bound(const Op *op, Real result, const Real *values, const Real *bounds)
{
    return bound_of(op, result, values, bounds);
}

Real tape_value(const Tape *tape, const TapeInputs *at, int i, const Real *values)
{
    const Op *op = &tape->ops[i];
    if (op->code == OP_CONSTANT)
        return op->value;
    if (op->code <= OP_SPIN)
        return input_value(op, at);
    return start_value(op, values[op->a], op->b < 0 || op->b >= i ? 0.0 : values[op->b]);
}

void tape_evaluate(const Tape *tape, const TapeInputs *at, const TapeInputs *blur, Real *values, Real *bounds)
{
    Real cosine = 0.0;
    int i;
    for (i = 0; i < tape->op_count; i++) {
        const Op *op = &tape->ops[i];
        if (!op->used)
            continue;
        if (op->code == OP_SIN && op->b == i + 1)
            sine_cosine(values[op->a], &values[i], &cosine);
        else if (op->code == OP_COS && op->b == i - 1 && tape->ops[i - 1].code == OP_SIN && tape->ops[i - 1].used)
            values[i] = cosine;
        else
            values[i] = tape_value(tape, at, i, values);
        if (op->code == OP_CONSTANT)
            bounds[i] = 0.0;
        else if (op->code <= OP_SPIN)
            bounds[i] = fabs(input_value(op, blur));
        else
            bounds[i] = bound_of(op, values[i], values, bounds);
    }
}

