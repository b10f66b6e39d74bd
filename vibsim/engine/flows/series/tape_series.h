/* The recurrences of Taylor coefficients along tapes (Jorba & Zou 2005), made part of the loops over orders that use them. What
 * is known of a sum before the newest order comes first, so that little waits for its newest terms.
 */
#ifndef VIBSIM_TAPE_SERIES_H
#define VIBSIM_TAPE_SERIES_H

#include "inlining.h"
#include "pair.h"
#include "tape.h"

#define BACK(series, n) ((series) + (2 * TAPE_ORDERS - 1 - (n))) /* where coefficient n - i of a series is number i */
#define WEIGHTED(series) ((series) + 2 * TAPE_ORDERS)           /* where n times coefficient n is */

#define NEWEST(which, place) (op->after == which##_IS_NEWEST ? last : now[op->place]) /* coefficient n of what is read */

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

/* Of a^p: n a_0 y_n = sum (p (n - i) - i) a_(n-i) y_i over i < n. At a zero of a, or one nearer than `least` [s], which is a
 * singularity, nothing but the value: a step from there is as short as that is right.
 */
APART Real power_coefficient(const Real *a, const Real *back, const Real *y, Real p, int n, Real inverse, Real least)
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

/* Of y with b y' = a': n b_0 y_n = n a_n - sum i y_i b_(n-i); newest: a_n, y: where the series is. */
INLINE Real quotient_coefficient(Real newest, const Real *b, const Real *back, Real *y, int n, Real inverse)
{
    const Real value = quotient(newest - middle(WEIGHTED(y), back, n - 1) * inverse, b[0]);
    WEIGHTED(y)[n] = n * value;
    return value;
}

/* Coefficient n > 0 of an operation; now, back: series + n, and where coefficient n - i of the first of them is number i; last:
 * coefficient n of the operation just before. What is known of a sum before order n comes first, and what has just been computed is not
 * read back, so that little waits for it.
 */
INLINE Real following(const Op *op, Real *series, const Real *now, const Real *back, Real last, int n, Real inverse, Real least)
{
    const Real *a = series + op->first;
    Real known, newest, *weights;
    switch (op->code) {
    case OP_ADD: return NEWEST(FIRST, first) + NEWEST(SECOND, second);
    case OP_SUB: return NEWEST(FIRST, first) - NEWEST(SECOND, second);
    case OP_SCALE: return op->value * NEWEST(FIRST, first);
    case OP_MUL:
        known = middle(a, back + op->second, n - 1);
        return known + (a[0] * NEWEST(SECOND, second) + NEWEST(FIRST, first) * series[op->second]);
    case OP_SQUARE:
        known = middle(a, back + op->first, (n - 1) / 2);
        known = known + known;
        if (n % 2 == 0)
            known = known + a[n / 2] * a[n / 2];
        newest = a[0] * NEWEST(FIRST, first);
        return known + (newest + newest);
    case OP_DIV:
        known = middle(series + op->second, back + op->at, n - 1);
        return quotient(NEWEST(FIRST, first) - (known + NEWEST(SECOND, second) * series[op->at]), series[op->second]);
    case OP_SIN:
    case OP_SINH:
    case OP_COSH:
    case OP_TANH:
    case OP_EXP:
        weights = WEIGHTED(series + op->at);
        weights[n] = newest = n * NEWEST(FIRST, first);
        return (middle(weights, back + op->second, n - 1) + newest * series[op->second]) * inverse;
    case OP_COS: /* its sine comes just before it and has the weights */
        weights = WEIGHTED(series + op->second);
        return -((middle(weights, back + op->second, n - 1) + weights[n] * series[op->second]) * inverse);
    case OP_LOG: return quotient_coefficient(now[op->first], a, back + op->first, series + op->at, n, inverse);
    case OP_POWER: return power_coefficient(a, back + op->first, series + op->at, op->value, n, inverse, least);
    default: /* by a divisor */
        newest = divisor_sign(op->code) * now[op->first];
        return quotient_coefficient(newest, series + op->second, back + op->second, series + op->at, n, inverse);
    }
}

/* Order n > 0 of all that moves along a tape; returns that of its last operation. alone: there is but one body, whose displacement x
 * and velocity v of this order are at hand, so that nothing waits until they are in the table; that of its velocity is at `rates`.
 */
INLINE Real advance_along(const Tape *tape, const TapeRoom *room, const Real *row, int n, Real inverse, const int alone, int rates, Real x,
                          Real v)
{
    Real *series = room->series, *now = series + n, *back = BACK(series, n), last = 0.0;
    const Op *op = tape->moving, *reading = op + tape->read_count, *end = op + tape->moving_count;
    const Real least = room->least;
    for (; op < reading; op++) {
        last = alone && op->from == 0 ? x : alone && op->from == rates ? v : row[op->from];
        now[op->at] = back[op->at] = last;
    }
    for (; op < end; op++) {
        switch (op->way) {
        case SUM: last = now[op->first] + now[op->second]; break;
        case SUM_FIRST_NEWEST: last = last + now[op->second]; break;
        case SUM_SECOND_NEWEST: last = now[op->first] + last; break;
        case LESS: last = now[op->first] - now[op->second]; break;
        case LESS_FIRST_NEWEST: last = last - now[op->second]; break;
        case LESS_SECOND_NEWEST: last = now[op->first] - last; break;
        case MULTIPLE: last = op->value * now[op->first]; break;
        case MULTIPLE_OF_NEWEST: last = op->value * last; break;
        default:
            last = following(op, series, now, back, last, n, inverse, least);
            back[op->at] = last;
        }
        now[op->at] = last;
    }
    return last;
}

#endif
