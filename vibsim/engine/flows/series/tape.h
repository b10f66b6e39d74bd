/* Tapes: the formulas of one mode as a list of operations, made by `TapeMaker` in vibsim/engine/flows/tape.py. */
#ifndef VIBSIM_TAPE_H
#define VIBSIM_TAPE_H

#include <stddef.h>

#include "functions.h"
#include "real.h"

#define TAPE_ORDERS (MAX_ORDER + 3) /* coefficients of a series along a tape; that of the base has three beyond the order */
#define TAPE_WIDTH (3 * TAPE_ORDERS)
/* Coefficients from the front, once more from the back, that of order n at 2 TAPE_ORDERS - 1 - n; behind them n times coefficient n,
 * where a recurrence asks for it: TAPE_WIDTH numbers, those of operation i from `series_along(series, i)` on.
 */
static inline Real *series_along(Real *series, int i)
{
    return series + (ptrdiff_t)i * TAPE_WIDTH;
}

#define OPERATION(CODE, name, of, sign, text) OP_##CODE,

/* Operations, the same numbers in tape.py. */
enum {
    OP_CONSTANT,
    OP_TIME,
    OP_PLACE,
    OP_SPEED,
    OP_ANGLE,
    OP_SPIN,
    OP_ADD,
    OP_SUB,
    OP_SCALE,
    OP_MUL,
    OP_SQUARE,
    OP_DIV,
    ELEMENTARY_FUNCTIONS(OPERATION)
    OP_POWER,
    OPERATIONS
};
#undef OPERATION

#define SIGN(CODE, name, of, sign, text) sign,
/* Of a function by a divisor the sign of its derivative, of all other operations 0: see functions.h. */
static inline int divisor_sign(int code)
{
    static const int signs[] = {ELEMENTARY_FUNCTIONS(SIGN)};
    return code < OP_SIN || code >= OP_POWER ? 0 : signs[code - OP_SIN];
}
#undef SIGN

enum { FIRST_IS_NEWEST = 1, SECOND_IS_NEWEST };

/* Ways of computing an order of an operation with the motion: as any operation, or as a sum, a difference or a multiple whose series
 * nothing reads from the back; two behind each of these, where its first and its second operand is the newest.
 */
enum {
    AS_ANY,
    SUM,
    SUM_FIRST_NEWEST,
    SUM_SECOND_NEWEST,
    LESS,
    LESS_FIRST_NEWEST,
    LESS_SECOND_NEWEST,
    MULTIPLE,
    MULTIPLE_OF_NEWEST
};

/* When the coefficients of an operation behind its value are computed. ONCE_FOR_ALL steps: of numbers, the time and sums of multiples
 * of these they are the same at every instant. AHEAD of the motion: of what reads the time alone. WITH_MOTION, order by order.
 * BEHIND it: of what no force reads.
 */
enum { ONCE_FOR_ALL, AHEAD, WITH_MOTION, BEHIND };

/* value: of a constant; factor of OP_SCALE; exponent of OP_POWER. a, b: places of the operands; a is the column of what OP_PLACE and
 * OP_SPEED read, `from` the place in the table of Taylor series of what an operation reads, -1 for the ground. at, first, second: where
 * its own series and those that a recurrence reads begin, of what has none its own: TAPE_WIDTH times places; after: which of these the
 * operation just before writes, see tape_series.h. used: whether its value is asked for, by an output or on the way to one.
 * when: see above; even: whether it is a function of what is the same at every instant but for a number; turned: whether its series
 * is read from the back; way: how it is computed with the motion, see above.
 */
typedef struct {
    Real value;
    ptrdiff_t at, first, second;
    int code, a, b, from, after, used, when, even, turned, way;
} Op;

/* number: of the tape in a run, from 1; outputs: places by number of the output; powers: whether there is OP_POWER; moving: operations
 * computed with the motion, and first of them `read_count` that read; ahead, behind: those before and behind it
 */
typedef struct {
    Op *ops, *moving, *ahead, *behind;
    int *outputs, number, op_count, output_count, read_count, moving_count, ahead_count, behind_count, powers;
} Tape;

/* sign times output number `output` of the tape, at `place`, on column P, the opposite on Q; Q, to_Q < 0 for none. */
typedef struct {
    Real sign;
    int output, place, newest, P, Q, to_P, to_Q; /* newest: whether that operation is the last that moves */
} FormulaForce;

/* A body that a belt by a formula carries along with its group: the acceleration that it has more than that is at `place`. */
typedef struct {
    int column, place;
} Follower;

/* Kinds of what a formula is derived by: displacement or velocity of a column, angle or speed of the motor's rotor. */
enum { BY_PLACE, BY_SPEED, BY_ANGLE, BY_SPIN };

/* A partial derivative of an output of the tape of a mode: its number on the tape of derivatives. */
typedef struct {
    int kind, column, output;
} FormulaSlope;

/* An entry of the matrix of derivatives of accelerations, by leading columns; back: that across the diagonal, -1 for none. */
typedef struct {
    int row, column, back;
} SlopeEntry;

/* What derivative number `output` of force number `force` adds to an entry, by what acts on P, or on Q where `end` is 1. */
typedef struct {
    int entry, force, end, output;
} SlopeShare;

typedef struct {
    SlopeEntry *entries; /* row by row */
    SlopeShare *shares;
    int entry_count, share_count;
} SlopeRows;

/* Partial derivatives of the formulas of a mode: those of output k are all[first[k]] to all[first[k + 1] - 1]; rows: by displacements,
 * by velocities. known: whether they were told of.
 */
typedef struct {
    Tape tape;
    FormulaSlope *all;
    int *first, known;
    SlopeRows rows[2];
} FormulaSlopes;

/* A rotor on a body: columns of it and of the body; lightness: one by its inertia. */
typedef struct {
    Real unbalance, inertia, lightness;
    int column, on;
} RotorOn;

/* What a tape reads at one instant: time, displacements and velocities by column, angle and speed of the rotor. */
typedef struct {
    Real t, phi, w, *x, *v;
} TapeInputs;

/* By operation: series; values and bounds of their rounding; `checked`: the same at the end of a step; `base`: of the motion of the base.
 * at, blur: what a tape reads, and bounds of that;
 * between: what it reads between two instants; tape: number of the one whose operations ONCE_FOR_ALL have their series here, 0 for none,
 * of `made` coefficients;
 * orders: how many coefficients are computed ahead and behind; inverse: 1 over each order; latest: number of the tape whose values are
 * in `checked`, 0 for none.
 */
typedef struct {
    Real *series, *values, *bounds, *checked, *base;
    TapeInputs at, blur, between;
    Real least; /* time [s] nearer than which a zero of the base of a power is one here */
    const Real *inverse;
    int ops, tape, made, orders, latest;
} TapeRoom;

/* Begin series of so many orders at the time t; nearest: time [s] within which a zero of the base of a power is one here in any case. */
void tape_start(TapeRoom *room, Real t, Real nearest, const Real *inverse, int orders);

/* Values along a tape, which are order 0, and what is computed ahead; row: of that order in the table of Taylor series. */
void tape_begin(const Tape *tape, TapeRoom *room, const Real *row);

/* Coefficients of order n along a tape, but for those behind the motion. */
void tape_advance(const Tape *tape, TapeRoom *room, const Real *row, int n);

/* Those behind the motion, whose table has rows of `stride` numbers. */
void tape_end(const Tape *tape, const TapeRoom *room, const Real *table, int stride);

/* Values along a tape, each with a bound of its rounding. */
void tape_evaluate(const Tape *tape, const TapeInputs *at, const TapeInputs *blur, Real *values, Real *bounds);

/* What the rounding of its operands and its own make of the result of an operation, to first order. */
Real tape_bound(const Op *op, Real result, const Real *values, const Real *bounds);

/* The value of operation i from those before it. */
Real tape_value(const Tape *tape, const TapeInputs *at, int i, const Real *values);

#endif
