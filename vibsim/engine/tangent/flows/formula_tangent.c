/* How small disturbances feel the formulas of a mode.
 *
 * A formula passes df = sum of its partial derivatives times the disturbances of what it reads; the derivatives are formulas
 * themselves, made once for a mode, whose series along the motion come from a tape of their own.
 *
 * Where the base u of a power u^p comes to zero there is no series, and with p < 1 its derivative is infinite there, though its
 * integral is not. The piece next to the zero is so short that u is linear in time in it, and disturbances feel nothing but the
 * means of the derivatives over it, which are taken by quadrature from the zero itself on: the next pieces begin or end where
 * there are series. So nothing of the integral is left out.
 */
#include "elementary.h"
#include "sound_steps.h"
#include "tangent.h"

#define OF_A_FUNCTION 1000.0  /* products that one takes on many words, and more */
#define SHORTENINGS 200       /* of a stretch, each at least by */
#define ROUNDING 4            /* of displacements and velocities at its end, in units of EPS */
/* Of the quadrature: between two nodes; their number on either side of the middle. By the bits of the round-off the outermost ones are
 * as far out as a power above -0.9 at an end asks for.
 */
#ifdef LIMBS
#define NODE (14.0 / (18 - unit_roundoff.exponent))
#define NODES ((int)(logarithm(4.4 * (1 - unit_roundoff.exponent)) / NODE) + 1)
#else
#define NODE 0.2
#define NODES 27
#endif

static int reads_motion(const Op *op)
{
    return op->code > OP_TIME && op->code <= OP_SPIN;
}

/* Series of the derivatives along the flow in r->taylor: what is read goes two orders further. */
void formula_slopes_expand(Run *r, TapeRoom *room)
{
    const Taylor *f = &r->taylor;
    const Tape *tape = &r->mode->formula_slopes.tape;
    int n, i;
    tape_start(room, r->t0, f->nearest, f->inverse, f->order);
    for (n = 0; n < f->order && !hears_signal(r, (double)tape->op_count * n); n++)
        tape_advance(tape, room, f->table + n * f->stride, n);
    for (i = 0; i < tape->op_count; i++) {
        const Op *op = &tape->ops[i];
        for (n = f->order; reads_motion(op) && n < f->order + 2; n++)
            series_along(room->series, i)[n] = op->from < 0 ? 0.0 : f->table[n * f->stride + op->from];
    }
}

/* The same along the step in hand, once. */
const TapeRoom *formula_slopes_of_step(Run *r)
{
    TaylorTangent *of = &r->tangent->taylor;
    if (!of->has_step)
        formula_slopes_expand(r, &of->step);
    of->has_step = 1;
    return &of->step;
}

/* Derivative number k at tau. */
static Real slope_at(const Run *r, const TapeRoom *room, int k, Real tau)
{
    const Tape *tape = &r->mode->formula_slopes.tape;
    int place = tape->outputs[k];
    return horner(series_along(room->series, place), r->taylor.order + (reads_motion(&tape->ops[place]) ? 2 : 0), tau);
}

/* The flow that is expanded at t. */
static const Taylor *flow_at(const Run *r, Real t)
{
    return t != r->t0 ? &r->tangent->taylor.spare : &r->taylor;
}

/* What formulas read a time tau after the expansion of f at t, into the arrays of `at`. */
static TapeInputs inputs_at(const Run *r, const Taylor *f, Real t, Real tau, TapeInputs at)
{
    const Real *values = f->values;
    Real turns, phase;
    taylor_values(f, tau, f->values);
    read_columns(r, values, &at);
    at.t = t + tau;
    at.phi = at.w = 0.0;
    if (r->has_motor) {
        phase = reduce_angle(values[r->bodies], &turns);
        at.phi = unwind(phase, f->turns + turns);
        at.w = values[f->rates + r->bodies];
    }
    return at;
}

/* Values of the derivatives a time tau after the expansion of f at t, from the state there. */
static void values_at(const Run *r, const Taylor *f, const TapeRoom *room, Real t, Real tau)
{
    const Real lost = ROUNDING * EPS;
    TapeInputs at = inputs_at(r, f, t, tau, r->taylor.tapes.at), blur = r->taylor.tapes.blur;
    blur_inputs(r, &at, lost, &blur);
    blur.t = lost * fabs(at.t);
    tape_evaluate(&r->mode->formula_slopes.tape, &at, &blur, room->values, room->bounds);
}

/* By how many binary digits the worst derivative is beyond what it may be wrong by at tau; 0 where none is. */
static double excess(const Run *r, const TapeRoom *room, Real tau, Real tolerance)
{
    const Tape *tape = &r->mode->formula_slopes.tape;
    const int order = r->taylor.order;
    double worst = 0.0;
    int k;
    for (k = 0; k < tape->output_count; k++) {
        int place = tape->outputs[k];
        const Real *series = series_along(room->series, place);
        Real allowed = 2 * room->bounds[place] + order * tolerance * sizes_at(series, order, tau);
        Real off = fabs(room->values[place] - horner(series, order, tau));
        double beyond = digits_beyond(off, allowed);
        worst = beyond > worst ? beyond : worst;
    }
    return worst;
}

/* The stretch tau from t, or a shorter one, at the end of which the derivatives have the values that their series say. */
Real formula_sound_stretch(Run *r, Real t, Real tau)
{
    const TaylorTangent *of = &r->tangent->taylor;
    const Real tolerance = power_of_two(r->tolerance_exponent), shortest = tau * LEAST_SHARE;
    const Taylor *f = flow_at(r, t);
    int i;
    taylor_prepare(r, t);
    for (i = 0; i < SHORTENINGS; i++) {
        double beyond;
        values_at(r, f, of->along, t, tau);
        beyond = excess(r, of->along, tau, tolerance);
        if (beyond <= 0 || tau <= shortest)
            return tau;
        tau = shortened(tau, beyond, r->taylor.order);
    }
    return tau;
}

/* Whether t is behind an event, which is at the zero of its function itself. */
static int is_behind_event(const Run *r, Real t)
{
    int k;
    for (k = 0; t == r->t0 && k < r->key_count; k++)
        if (r->known[k])
            return 1;
    return 0;
}

/* Note a base that is zero, once. */
static void note_zero(Zeros *zeros, const Zero *one, int mild)
{
    int i;
    for (i = 0; i < zeros->count && i < MOST_ZEROS; i++)
        if (zeros->all[i].place == one->place)
            break;
    if (i < MOST_ZEROS)
        zeros->all[i] = *one;
    zeros->count += i == zeros->count || i == MOST_ZEROS;
    zeros->opening = zeros->opening || one->first < one->last;
    zeros->mild = zeros->mild && mild;
}

/* The bases of powers that are zero at the start or the end of the piece from t to `end`. Behind an event, and at one that ends
 * the piece, they are at the zero itself; elsewhere a base that is near zero has the value it has.
 */
Zeros formula_zeros(Run *r, Real t, Real end)
{
    const Tape *tape = &r->mode->formula_slopes.tape;
    const int order = r->taylor.order, at_event = r->pending_event != NOTHING && end == r->pending_end;
    const Real tau = end - t;
    const TapeRoom *room;
    Zeros zeros;
    int k, known = 0;
    zeros.count = zeros.opening = 0;
    zeros.mild = 1;
    taylor_prepare(r, t);
    room = r->tangent->taylor.along;
    for (k = 0; k < tape->op_count; k++) {
        const Op *op = &tape->ops[k];
        const Real *base = series_along(room->series, op->a < 0 ? 0 : op->a);
        Real least;
        Zero one;
        int opens, closes;
        if (op->code != OP_POWER)
            continue;
        if (!known)
            values_at(r, flow_at(r, t), room, t, tau);
        known = 1;
        one.place = op->a;
        one.first = base[0];
        one.last = horner(base, order, tau);
        one.rate = fabs(base[1]);
        one.bend = fabs(base[2]);
        least = room->least * one.rate + room->bounds[op->a];
        opens = !(one.first > least);
        closes = at_event && !(one.last > least);
        if (!opens && !closes)
            continue;
        one.first = (opens && is_behind_event(r, t)) || one.first < 0 ? 0.0 : one.first;
        one.last = closes || one.last < 0 ? 0.0 : one.last;
        note_zero(&zeros, &one, op->value > 0);
    }
    return zeros;
}

/* Means over all that moves are sound: whether a derivative has an integral; sums: by operation its size, that of its ends. */
static int have_integrals(const Run *r, Real *sums)
{
    const Mode *m = r->mode;
    const FormulaSlopes *slopes = &m->formula_slopes;
    const Real ends = OF_MEANS;
    int i, j;
    for (i = 0; i < m->formula_count; i++) {
        const FormulaForce *law = &m->formulas[i];
        if (!(m->mobility[law->to_P] > 0) && !(law->to_Q >= 0 && m->mobility[law->to_Q] > 0))
            continue;
        for (j = slopes->first[law->output]; j < slopes->first[law->output + 1]; j++) {
            const Real *of = series_along(sums, slopes->tape.outputs[slopes->all[j].output]);
            if (!isfinite(of[1]) || !(of[2] <= ends * of[1]))
                return 0;
        }
    }
    return 1;
}

/* Sums over the nodes of a quadrature from 0 to 1, whose weights' sum is returned: by operation of its values, their sizes, and
 * those of the outermost nodes. The double exponential formula of Takahasi and Mori (1974) takes what may have a power above -0.9
 * at either end, to the round-off. Between the ends of the piece all that is read is linear in time.
 */
static Real add_nodes(Run *r, const Zeros *zeros, Real t, Real tau, TapeRoom *room)
{
    const Tape *tape = &r->mode->formula_slopes.tape;
    const Taylor *f = flow_at(r, t);
    const TapeInputs start = inputs_at(r, f, t, 0, r->taylor.tapes.blur), last = inputs_at(r, f, t, tau, r->taylor.tapes.at);
    TapeInputs at = r->taylor.tapes.between;
    const double node = NODE;
    const int nodes = NODES;
    Real total = 0.0;
    int i, j, k;
    room->tape = 0; /* whose series end here */
    for (i = 0; i < tape->op_count; i++) {
        Real *sums = series_along(room->series, i);
        sums[0] = sums[1] = sums[2] = 0.0;
    }
    for (j = -nodes; j <= nodes && !hears_signal(r, OF_A_FUNCTION * (4.0 + tape->op_count)); j++) {
        Real z = j * node, y = TWO_PI / 2 * hyperbolic_sine(z);
        Real before = 1 / (1 + exponential(y)), after = 1 / (1 + exponential(-y));
        Real weight = hyperbolic_cosine(z) * (before * after);
        total = total + weight;
        for (i = 0; i < r->columns; i++) {
            at.x[i] = start.x[i] * before + last.x[i] * after;
            at.v[i] = start.v[i] * before + last.v[i] * after;
        }
        at.t = start.t * before + last.t * after;
        at.phi = start.phi * before + last.phi * after;
        at.w = start.w * before + last.w * after;
        for (i = 0; i < tape->op_count; i++) {
            Real *sums = series_along(room->series, i), part;
            room->values[i] = tape_value(tape, &at, i, room->values);
            for (k = 0; k < zeros->count; k++)
                if (zeros->all[k].place == i)
                    room->values[i] = zeros->all[k].first * before + zeros->all[k].last * after;
            part = weight * room->values[i];
            sums[0] = sums[0] + part;
            sums[1] = sums[1] + fabs(part);
            if (j == -nodes || j == nodes)
                sums[2] = sums[2] + fabs(part);
        }
    }
    return total;
}

/* Put the means of the derivatives over the stretch tau in place of their series; 0, and nothing is replaced, where bases are not
 * linear in it, or a derivative has no integral. share: of tau, in which the base moves at its rate from one value to the other.
 */
int formula_take_means(Run *r, const Zeros *zeros, Real t, Real tau)
{
    TaylorTangent *of = &r->tangent->taylor;
    const Tape *tape = &r->mode->formula_slopes.tape;
    const Real bend = OF_MEANS;
    Real share, total;
    int i, n;
    for (i = 0; i < zeros->count && i < MOST_ZEROS; i++)
        if (zeros->all[i].first == zeros->all[i].last || !(zeros->all[i].bend * tau < bend * zeros->all[i].rate))
            return 0;
    if (zeros->count > MOST_ZEROS)
        return 0;
    share = fabs(zeros->all[0].last - zeros->all[0].first) / (zeros->all[0].rate * tau);
    total = add_nodes(r, zeros, t, tau, &of->here);
    of->prepared = 0; /* series are to be made anew */
    if (!have_integrals(r, of->here.series))
        return 0;
    for (i = 0; i < tape->op_count; i++) {
        Real *mean = series_along(of->here.series, i);
        mean[0] = mean[0] / total * share;
        for (n = 1; n < TAPE_ORDERS; n++)
            mean[n] = 0.0;
    }
    of->along = &of->here;
    return 1;
}

/* Derivatives of accelerations at tau after where all is prepared, by entry. */
static const Real *fill(const Run *r, const SlopeRows *rows, Real tau)
{
    const Mode *m = r->mode;
    const TapeRoom *room = r->tangent->taylor.along;
    Real *entries = r->tangent->taylor.entries;
    int i;
    for (i = 0; i < rows->entry_count; i++)
        entries[i] = 0.0;
    for (i = 0; i < rows->share_count; i++) {
        const SlopeShare *share = &rows->shares[i];
        Real value = m->formulas[share->force].sign * slope_at(r, room, share->output, tau);
        Real mobility = m->mobility[rows->entries[share->entry].row];
        entries[share->entry] = entries[share->entry] + (share->end ? -mobility : mobility) * value;
    }
    return entries;
}

/* Bound of a rate at tau: the largest sum over a row in which what two columns do to each other is measured together. */
static Real rate_of(const Run *r, const SlopeRows *rows, Real tau)
{
    const Real *values = fill(r, rows, tau);
    Real largest = 0.0;
    int first, i;
    for (first = 0; first < rows->entry_count; first = i) {
        const SlopeEntry *e = rows->entries;
        Real total = 0.0;
        for (i = first; i < rows->entry_count && e[i].row == e[first].row; i++)
            if (e[i].column == e[i].row)
                total = fabs(values[i]);
        for (i = first; i < rows->entry_count && e[i].row == e[first].row; i++)
            if (e[i].column != e[i].row)
                total = total + sqrt(fabs(values[i] * (e[i].back < 0 ? 0.0 : values[e[i].back])));
        largest = total > largest ? total : largest;
    }
    return largest;
}

/* Bounds of the rates at which formulas move disturbances, where all is prepared or tau behind it. */
void formula_rates(const Run *r, Real tau, Real *stiffness, Real *damping)
{
    const SlopeRows *rows = r->mode->formula_slopes.rows;
    Real start = rate_of(r, &rows[0], 0.0), later = rate_of(r, &rows[0], tau);
    *stiffness = later > start ? later : start;
    start = rate_of(r, &rows[1], 0.0);
    later = rate_of(r, &rows[1], tau);
    *damping = later > start ? later : start;
}

/* Derivatives of accelerations with respect to velocities, by entry. */
const Real *formula_damping(const Run *r, Real tau)
{
    return fill(r, &r->mode->formula_slopes.rows[1], tau);
}

/* Derivative of the force on a group by the speed of the motor. */
static Real slope_by_spin(const Run *r, Real tau, int group)
{
    const Mode *m = r->mode;
    const FormulaSlopes *slopes = &m->formula_slopes;
    Real total = 0.0;
    int i, j;
    for (i = 0; i < m->formula_count; i++) {
        const FormulaForce *law = &m->formulas[i];
        const int sense = (law->to_P == group) - (law->to_Q == group);
        for (j = slopes->first[law->output]; sense != 0 && j < slopes->first[law->output + 1]; j++)
            if (slopes->all[j].kind == BY_SPIN)
                total = total + sense * law->sign * slope_at(r, r->tangent->taylor.along, slopes->all[j].output, tau);
    }
    return total;
}

/* Trace of the derivatives of accelerations with respect to velocities, without the group `on` of a motor, -1 without one; own, spin:
 * derivatives of the force on that group by its velocity and by the speed of the motor.
 */
Real formula_divergence(const Run *r, Real tau, int on, Real *own, Real *spin)
{
    const SlopeRows *rows = &r->mode->formula_slopes.rows[1];
    const Real *values = formula_damping(r, tau);
    Real total = 0.0;
    int i;
    *own = 0.0;
    *spin = on < 0 ? 0.0 : slope_by_spin(r, tau, on);
    for (i = 0; i < rows->entry_count; i++) {
        int row = rows->entries[i].row;
        if (rows->entries[i].column == row && row == on)
            *own = values[i] / r->mode->mobility[row];
        else if (rows->entries[i].column == row)
            total = total + values[i];
    }
    return total;
}
