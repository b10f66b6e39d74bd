/* The formulas of a mode from packed numbers: its tapes, and the forces on it, in the order in which
 * vibsim/engine/modes/packing.py writes them.
 */
#include <stdlib.h>
#include <string.h>

#include "modes.h"

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
    binary = op->code == OP_ADD || op->code == OP_SUB || op->code == OP_MUL || op->code == OP_DIV ||
             divisor_sign(op->code) != 0;
    if (binary)
        op->b = read_index(in, 0, i - 1);
    else if ((op->code >= OP_SIN && op->code <= OP_COSH) || op->code == OP_TANH)
        op->b = read_index(in, 0, count - 1);
    else
        op->b = read_index(in, -1, -1);
    op->value = read_double(in);
    op->at = i * TAPE_WIDTH;
    op->first = op->code > OP_SPIN ? op->a * TAPE_WIDTH : op->at;
    op->second = op->b < 0 ? op->at : op->b * TAPE_WIDTH;
    if (timely && op->code > OP_TIME && op->code <= OP_SPIN)
        in->short_of = 1;
    place_input(r, in, op);
}

/* Which operations have values that are asked for. Not: a number that became a factor, a cosine that only its sine needs. */
static void take_used(Tape *tape)
{
    int i;
    for (i = 0; i < tape->output_count; i++)
        tape->ops[tape->outputs[i]].used = 1;
    for (i = tape->op_count - 1; i >= 0; i--) {
        const Op *op = &tape->ops[i];
        const int asked = op->used || op->code == OP_POWER; /* the base of a power is looked at in any case */
        if (op->code <= OP_SPIN)
            continue;
        if (asked || tape->ops[op->a].code == OP_CONSTANT)
            tape->ops[op->a].used = 1;
        if (op->b >= 0 && ((asked && op->b < i) || tape->ops[op->b].code == OP_CONSTANT))
            tape->ops[op->b].used = 1;
    }
}

/* Whether what an operation reads, but for what stands behind it, is computed by the time that `when` says. */
static int is_known_by(const Tape *tape, const Op *op, int i, int when)
{
    return tape->ops[op->a].when <= when && (op->b < 0 || op->b >= i || tape->ops[op->b].when <= when);
}

/* Note whose series a recurrence reads from the back. */
static void take_turned(const Tape *tape)
{
    int i;
    for (i = 0; i < tape->op_count; i++) {
        Op *op = &tape->ops[i];
        if (op->code == OP_SQUARE || op->code == OP_LOG || op->code == OP_POWER)
            tape->ops[op->a].turned = 1;
        else if (op->code >= OP_MUL && op->b >= 0)
            tape->ops[op->b].turned = 1;
        op->turned = op->turned || op->code == OP_DIV || op->code == OP_EXP;
    }
}

/* When each operation can be computed, where all serve the motion. */
static void take_times(Tape *tape)
{
    int i;
    for (i = 0; i < tape->op_count; i++) {
        Op *op = &tape->ops[i];
        const int sums = op->code == OP_SCALE || op->code == OP_ADD || op->code == OP_SUB;
        if (op->code <= OP_SPIN)
            op->when = op->from < 0 ? ONCE_FOR_ALL : WITH_MOTION;
        else if (sums && is_known_by(tape, op, i, ONCE_FOR_ALL))
            op->when = ONCE_FOR_ALL;
        else
            op->when = is_known_by(tape, op, i, AHEAD) ? AHEAD : WITH_MOTION;
        op->even = op->code > OP_SPIN && op->when == AHEAD && tape->ops[op->a].when == ONCE_FOR_ALL &&
                   (op->code == OP_SIN || op->code == OP_SINH || op->code == OP_EXP);
    }
}

/* Have an operation be computed with the motion; more: becomes 1 where it was not. */
static void keep_with_motion(const Tape *tape, int i, int *more)
{
    *more = *more || tape->ops[i].when == BEHIND;
    tape->ops[i].when = tape->ops[i].when == BEHIND ? WITH_MOTION : tape->ops[i].when;
}

/* Leave for later what neither the forces of a mode nor what it carries along read, themselves or by other operations. */
static void take_those_behind(const Mode *m, const Tape *tape)
{
    int i, more = 1;
    for (i = 0; i < tape->op_count; i++)
        tape->ops[i].when = tape->ops[i].when == WITH_MOTION ? BEHIND : tape->ops[i].when;
    for (i = 0; i < m->formula_count; i++)
        keep_with_motion(tape, m->formulas[i].place, &more);
    for (i = 0; i < m->follower_count; i++)
        keep_with_motion(tape, m->followers[i].place, &more);
    while (more) /* until nothing that is read stands further back */
        for (more = 0, i = tape->op_count - 1; i >= 0; i--)
            if (tape->ops[i].when == WITH_MOTION && tape->ops[i].code > OP_SPIN) {
                keep_with_motion(tape, tape->ops[i].a, &more);
                if (tape->ops[i].b >= 0)
                    keep_with_motion(tape, tape->ops[i].b, &more);
            }
}

/* Have what the first operation reads be read last. */
static void read_last(Tape *tape, const Op *first)
{
    int i;
    for (i = 0; i < tape->read_count; i++)
        if (tape->moving[i].at == first->first || tape->moving[i].at == first->second) {
            Op other = tape->moving[i];
            tape->moving[i] = tape->moving[tape->read_count - 1];
            tape->moving[tape->read_count - 1] = other;
            return;
        }
}

/* Copies of the operations of one time, from `to` on: those that read, or all others; returns their number. */
static int copied(const Tape *tape, Op *to, int when, int reading)
{
    int i, count = 0;
    for (i = 0; i < tape->op_count; i++)
        if (tape->ops[i].when == when && (tape->ops[i].code <= OP_SPIN) == reading)
            to[count++] = tape->ops[i];
    return count;
}

/* The operations that move, by their times; those that read come first. */
static void take_moving(Tape *tape)
{
    int i;
    tape->moving = tape->ops + tape->op_count;
    tape->read_count = copied(tape, tape->moving, WITH_MOTION, 1);
    tape->moving_count = tape->read_count + copied(tape, tape->moving + tape->read_count, WITH_MOTION, 0);
    tape->ahead = tape->moving + tape->moving_count;
    tape->ahead_count = copied(tape, tape->ahead, AHEAD, 0);
    tape->behind = tape->ahead + tape->ahead_count;
    tape->behind_count = copied(tape, tape->behind, BEHIND, 1);
    tape->behind_count += copied(tape, tape->behind + tape->behind_count, BEHIND, 0);
    if (tape->moving_count > tape->read_count)
        read_last(tape, tape->moving + tape->read_count);
    for (i = tape->read_count > 0 ? tape->read_count : 1; i < tape->moving_count; i++) {
        Op *op = &tape->moving[i];
        op->after = op->first == op[-1].at ? FIRST_IS_NEWEST : op->second == op[-1].at ? SECOND_IS_NEWEST : 0;
    }
    for (i = tape->read_count; i < tape->moving_count; i++) {
        Op *op = &tape->moving[i];
        if (!op->turned && (op->code == OP_ADD || op->code == OP_SUB || op->code == OP_SCALE))
            op->way = op->after + (op->code == OP_ADD ? SUM : op->code == OP_SUB ? LESS : MULTIPLE);
    }
    for (i = 0; i < tape->op_count; i++)
        tape->powers = tape->powers || tape->ops[i].code == OP_POWER;
}

static void read_tape(Run *r, Reader *in, Tape *tape, int count, int timely)
{
    int i;
    tape->output_count = read_index(in, 0, MOST);
    tape->ops = room(in, 2 * count, sizeof(Op));
    tape->outputs = room(in, tape->output_count, sizeof(int));
    for (i = 0; i < count && !in->short_of; i++)
        read_op(r, in, &tape->ops[i], i, count, timely);
    for (i = 0; i < tape->output_count && !in->short_of; i++)
        tape->outputs[i] = read_index(in, 0, count - 1);
    tape->op_count = count;
    tape->number = ++r->tapes_read;
    if (!in->short_of) {
        take_used(tape);
        take_times(tape);
        take_turned(tape);
    }
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

/* Memory for the series and values along tapes of so many operations. */
int alloc_tapes(TapeRoom *tapes, int ops)
{
    const size_t before = (size_t)tapes->ops, after = (size_t)ops;
    if (ops <= tapes->ops)
        return 1;
    if (!grow((void **)&tapes->series, before, after, TAPE_WIDTH * sizeof(Real)) || !grow((void **)&tapes->values, before, after, 6 * sizeof(Real)))
        return 0;
    tapes->bounds = tapes->values + ops;
    tapes->checked = tapes->values + 2 * ops;
    tapes->base = tapes->values + 4 * ops;
    tapes->ops = ops;
    tapes->tape = tapes->latest = 0;
    return 1;
}

void free_tapes(TapeRoom *tapes)
{
    free(tapes->series);
    free(tapes->values);
}

int formulas_read(Run *r, Reader *in, Mode *m, int ops, int base_ops)
{
    int i;
    read_tape(r, in, &m->tape, ops, 0);
    m->formula_count = read_index(in, 0, MOST);
    m->formulas = room(in, m->formula_count, sizeof(FormulaForce));
    for (i = 0; i < m->formula_count && !in->short_of; i++) {
        read_force(r, in, m, &m->formulas[i]);
        m->formulas[i].place = in->short_of ? 0 : m->tape.outputs[m->formulas[i].output];
    }
    m->follower_count = read_index(in, 0, r->bodies);
    m->followers = room(in, m->follower_count, sizeof(Follower));
    for (i = 0; i < m->follower_count && !in->short_of; i++) {
        Follower *one = &m->followers[i];
        int output;
        one->column = read_index(in, 0, r->bodies - 1);
        output = read_index(in, 0, m->tape.output_count - 1);
        one->place = in->short_of ? 0 : m->tape.outputs[output];
    }
    if (!in->short_of) {
        take_those_behind(m, &m->tape);
        take_moving(&m->tape);
        for (i = 0; i < m->formula_count && m->tape.moving_count > m->tape.read_count; i++)
            m->formulas[i].newest = m->formulas[i].place * TAPE_WIDTH == m->tape.moving[m->tape.moving_count - 1].at;
    }
    if (base_ops > 0) {
        read_tape(r, in, &m->base_tape, base_ops, 1);
        read_tape(r, in, &m->base_values, read_index(in, 1, MOST), 1);
        if (in->short_of || m->base_tape.output_count < 1 || m->base_values.output_count < 3)
            return 0;
        take_moving(&m->base_tape);
        if (!alloc_tapes(&r->taylor.base_tapes, base_ops))
            return 0;
    }
    base_ops = m->base_values.op_count > base_ops ? m->base_values.op_count : base_ops;
    if (in->short_of || !alloc_tapes(&r->taylor.tapes, ops > base_ops ? ops : base_ops))
        return 0;
    return !r->tangent || tangent_alloc_formulas(r, r->tangent);
}

/* What the derivatives of the formulas of a mode by displacements, or by velocities, do to accelerations. */
static void read_rows(const Run *r, Reader *in, const Mode *m, SlopeRows *rows)
{
    int i;
    rows->entry_count = read_index(in, 0, MOST);
    rows->share_count = read_index(in, 0, MOST);
    rows->entries = room(in, rows->entry_count, sizeof(SlopeEntry));
    rows->shares = room(in, rows->share_count, sizeof(SlopeShare));
    for (i = 0; i < rows->entry_count && !in->short_of; i++) {
        rows->entries[i].row = read_index(in, 0, r->columns - 1);
        rows->entries[i].column = read_index(in, 0, r->columns - 1);
        rows->entries[i].back = read_index(in, -1, rows->entry_count - 1);
    }
    for (i = 0; i < rows->share_count && !in->short_of; i++) {
        rows->shares[i].entry = read_index(in, 0, rows->entry_count - 1);
        rows->shares[i].force = read_index(in, 0, m->formula_count - 1);
        rows->shares[i].end = read_index(in, 0, 1);
        rows->shares[i].output = read_index(in, 0, m->formula_slopes.tape.output_count - 1);
    }
}

/* The derivatives of each output of the tape of a mode. */
static void read_slopes(const Run *r, Reader *in, Mode *m)
{
    FormulaSlopes *s = &m->formula_slopes;
    int count = read_index(in, 0, MOST), i;
    s->all = room(in, count, sizeof(FormulaSlope));
    s->first = room(in, m->tape.output_count + 1, sizeof(int));
    for (i = 0; i <= m->tape.output_count && !in->short_of; i++)
        s->first[i] = read_index(in, i == 0 ? 0 : s->first[i - 1], i == 0 ? 0 : count);
    for (i = 0; i < count && !in->short_of; i++) {
        FormulaSlope *one = &s->all[i];
        one->kind = read_index(in, BY_PLACE, r->has_motor ? BY_SPIN : BY_SPEED);
        one->column = read_index(in, one->kind > BY_SPEED ? -1 : 0, one->kind > BY_SPEED ? -1 : r->bodies - 1);
        one->output = read_index(in, 0, s->tape.output_count - 1);
    }
}

int slopes_read(Run *r, Mode *m, Reader *in)
{
    FormulaSlopes *s = &m->formula_slopes;
    int ops, i;
    in->owner = m;
    ops = read_index(in, 0, MOST);
    read_tape(r, in, &s->tape, ops, 0);
    read_slopes(r, in, m);
    for (i = 0; i < 2; i++)
        read_rows(r, in, m, &s->rows[i]);
    s->known = read_through(in);
    if (!s->known) {
        memset(s, 0, sizeof *s);
        return 0;
    }
    for (i = 0; i < 2; i++)
        r->slope_entries = s->rows[i].entry_count > r->slope_entries ? s->rows[i].entry_count : r->slope_entries;
    r->slope_ops = ops > r->slope_ops ? ops : r->slope_ops;
    take_moving(&s->tape);
    return !r->tangent || tangent_alloc_formulas(r, r->tangent);
}
