/* The formulas of a mode from packed numbers: its tapes, and the forces on it; twin of what vibsim/engine/modes/packing.py writes of
 * vibsim/engine/modes/formula_rows.py.
 */
#include <stdlib.h>

#include "modes.h"
#include "room.h"

/* Where what an operation reads is in the table of Taylor series. */
static void place_input(const Run *r, Reader *in, Op *op)
{
    const int rates = r->taylor.rates;
    op->from = -1;
    switch (op->code) {
    case OP_PLACE:
    case OP_SPEED:
        if (op->a > r->bodies && !r->has_base)
            in->short_of = 1;
        else if (op->a != r->bodies)
            op->from = column_in_table(r, op->a) + (op->code == OP_SPEED ? rates : 0);
        return;
    case OP_ANGLE:
    case OP_SPIN:
        op->from = r->bodies + (op->code == OP_SPIN ? rates : 0);
        in->short_of = in->short_of || !r->has_motor;
    }
}

/* Operation number i of `count`; timely: whether it may read nothing but the time. Of pairs of functions, and of tanh, each order reads
 * what comes later up to the order before.
 */
static void read_op(const Run *r, Reader *in, Op *op, int i, int count, int timely)
{
    int binary;
    op->code = read_index(in, OP_CONSTANT, OPERATIONS - 1);
    if (op->code == OP_PLACE || op->code == OP_SPEED)
        op->a = read_index(in, 0, r->columns - 1);
    else
        op->a = read_index(in, op->code > OP_SPIN ? 0 : -1, op->code > OP_SPIN ? i - 1 : -1);
    binary = op->code == OP_ADD || op->code == OP_SUB || op->code == OP_MUL || op->code == OP_DIV || op->code == OP_ATAN ||
             op->code == OP_ASIN || op->code == OP_ACOS;
    if (binary)
        op->b = read_index(in, 0, i - 1);
    else if ((op->code >= OP_SIN && op->code <= OP_COSH) || op->code == OP_TANH)
        op->b = read_index(in, 0, count - 1);
    else
        op->b = read_index(in, -1, -1);
    op->value = read_double(in);
    if (timely && op->code > OP_TIME && op->code <= OP_SPIN)
        in->short_of = 1;
    place_input(r, in, op);
}

static int read_tape(const Run *r, Reader *in, Tape *tape, int count, int timely)
{
    int i;
    tape->output_count = read_index(in, 0, MOST);
    tape->ops = room((size_t)count, sizeof(Op));
    tape->outputs = room((size_t)tape->output_count, sizeof(int));
    if (!tape->ops || !tape->outputs)
        return 0;
    for (i = 0; i < count && !in->short_of; i++)
        read_op(r, in, &tape->ops[i], i, count, timely);
    for (i = 0; i < tape->output_count; i++)
        tape->outputs[i] = read_index(in, 0, count - 1);
    tape->op_count = count;
    return 1;
}

static void read_force(const Run *r, Reader *in, const Mode *m, FormulaForce *one)
{
    one->output = read_index(in, 0, m->tape.output_count - 1);
    one->P = read_index(in, 0, r->columns - 1);
    one->Q = read_index(in, -1, r->columns - 1);
    one->sign = read_index(in, -1, 1);
    one->to_P = m->leader[one->P];
    one->to_Q = one->Q < 0 ? -1 : m->leader[one->Q];
}

/* Room for the series and values along tapes of so many operations. */
static int room_for_tapes(TapeRoom *tapes, int ops)
{
    double(*series)[TAPE_ORDERS], *values;
    if (ops <= tapes->ops)
        return 1;
    series = realloc(tapes->series, sizeof *series * (size_t)ops);
    tapes->series = series ? series : tapes->series;
    values = realloc(tapes->values, 2 * sizeof *values * (size_t)ops);
    tapes->values = values ? values : tapes->values;
    if (!series || !values)
        return 0;
    tapes->bounds = values + ops;
    tapes->ops = ops;
    return 1;
}

int formulas_read(Run *r, Reader *in, Mode *m, int ops, int base_ops)
{
    int i;
    if (!read_tape(r, in, &m->tape, ops, 0))
        return 0;
    m->formula_count = read_index(in, 0, MOST);
    m->formulas = room((size_t)m->formula_count, sizeof(FormulaForce));
    if (!m->formulas)
        return 0;
    for (i = 0; i < m->formula_count && !in->short_of; i++)
        read_force(r, in, m, &m->formulas[i]);
    if (base_ops > 0 && !read_tape(r, in, &m->base_tape, base_ops, 1))
        return 0;
    if (base_ops > 0 && m->base_tape.output_count < 1)
        in->short_of = 1;
    return !in->short_of && room_for_tapes(&r->taylor.tapes, ops > base_ops ? ops : base_ops);
}
