/* The recurrences of series along tapes, made part of the loops over orders that use them; twin of `TapeSeries` in
 * vibsim/engine/flows/tape.py.
 */
#ifndef VIBSIM_TAPE_SERIES_H
#define VIBSIM_TAPE_SERIES_H

#include "inlining.h"
#include "pair.h"
#include "tape.h"

#define BACK(series, n) ((series) + (TAPE_WIDTH - 1 - (n))) /* where coefficient n - i of a series is number i */

#define NEWEST(series, which) (op->after == which##_IS_NEWEST ? last : (series)[n]) /* coefficient n of what is read */

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
INLINE Real power_coefficient(const Real *a, const Real *back, const Real *y, Real p, int n, Real inverse, Real least)
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

/* Coefficient n > 0 of an operation; last: of that just before. What is known of a sum before order n comes first, and what has just
 * been computed is not read back, so that little waits for it.
 */
INLINE Real following(const Op *op, const Real *series, Real last, int n, Real inverse, Real least)
{
    const Real *a = series + op->first, *b = series + op->second, *s = series + op->at;
    Real known, newest;
    switch (op->code) {
    case OP_ADD: return NEWEST(a, FIRST) + NEWEST(b, SECOND);
    case OP_SUB: return NEWEST(a, FIRST) - NEWEST(b, SECOND);
    case OP_SCALE: return op->value * NEWEST(a, FIRST);
    case OP_MUL:
        known = middle(a, BACK(b, n), n - 1);
        return known + (a[0] * NEWEST(b, SECOND) + NEWEST(a, FIRST) * b[0]);
    case OP_SQUARE:
        known = middle(a, BACK(a, n), (n - 1) / 2);
        known = known + known;
        if (n % 2 == 0)
            known = known + a[n / 2] * a[n / 2];
        newest = a[0] * NEWEST(a, FIRST);
        return known + (newest + newest);
    case OP_DIV:
        known = middle(b, BACK(s, n), n - 1);
        return quotient(NEWEST(a, FIRST) - (known + NEWEST(b, SECOND) * s[0]), b[0]);
    case OP_SIN:
    case OP_SINH:
    case OP_COSH:
    case OP_TANH:
    case OP_EXP: return (weighted(a, BACK(b, n), n - 1) + (n * NEWEST(a, FIRST)) * b[0]) * inverse;
    case OP_COS: return -((weighted(a, BACK(b, n), n - 1) + (n * a[n]) * b[0]) * inverse);
    case OP_LOG: return quotient(a[n] - weighted(s, BACK(a, n), n - 1) * inverse, a[0]);
    case OP_ATAN:
    case OP_ASIN: return quotient(a[n] - weighted(s, BACK(b, n), n - 1) * inverse, b[0]);
    case OP_ACOS: return quotient(-a[n] - weighted(s, BACK(b, n), n - 1) * inverse, b[0]);
    default: return power_coefficient(a, BACK(a, n), s, op->value, n, inverse, least);
    }
}

/* Order n > 0 of all that moves along a tape; returns that of its last operation. */
INLINE Real advance_along(const Tape *tape, const TapeRoom *room, const Real *row, int n, Real inverse)
{
    Real *series = (Real *)room->series, last = 0.0;
    const Op *op = tape->moving, *reading = op + tape->read_count, *end = op + tape->moving_count;
    const Real least = room->least;
    for (; op < reading; op++)
        put(series + op->at, n, row[op->from]);
    for (; op < end; op++) {
        last = following(op, series, last, n, inverse, least);
        put(series + op->at, n, last);
    }
    return last;
}

#endif
