/* How small disturbances feel the formulas of a mode; twin of vibsim/engine/tangent/formula_tangent.py. */
#include "numbers.h"
#include "tangent.h"

#define SHORTENINGS 200       /* of a stretch, each at least by */
#define LEAST_SHARE 0x1p-36 /* of it, below which it is not shortened: where a derivative begins at infinity */
#define LEAST_SHORTENING 0.25 /* binary digits */
#define BEYOND_ALL 60.0       /* binary digits by which a value that is no number is beyond */
#define ROUNDING 4            /* of displacements and velocities at its end, in units of EPS */

static int reads_motion(const Op *op)
{
    return op->code > OP_TIME && op->code <= OP_SPIN;
}

/* Series of the derivatives along the flow in r->taylor: what is read goes two orders further. */
void formula_slopes_expand(const Run *r, TapeRoom *room)
{
    const Taylor *f = &r->taylor;
    const Tape *tape = &r->mode->formula_slopes.tape;
    int n, i;
    tape_start(room, r->t0);
    for (n = 0; n < f->order; n++)
        tape_advance(tape, room, f->table + n * f->stride, n, f->inverse[n]);
    for (i = 0; i < tape->op_count; i++) {
        const Op *op = &tape->ops[i];
        for (n = f->order; reads_motion(op) && n < f->order + 2; n++)
            room->series[i][n] = op->from < 0 ? 0.0 : f->table[n * f->stride + op->from];
    }
}

/* The same along the step in hand, once. */
const TapeRoom *formula_slopes_of_step(const Run *r)
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
    return horner(room->series[place], r->taylor.order + (reads_motion(&tape->ops[place]) ? 2 : 0), tau);
}

/* Sum of the sizes of the terms of a series at tau. */
static Real size_of(const Real *series, int count, Real tau)
{
    Real total = fabs(series[count - 1]);
    int n;
    for (n = count - 2; n >= 0; n--)
        total = total * tau + fabs(series[n]);
    return total;
}

/* Values of the derivatives a time tau after the expansion of f at t, from the state there. */
static void values_at(const Run *r, const Taylor *f, const TapeRoom *room, Real t, Real tau)
{
    const Real lost = ROUNDING * EPS, *values = f->values;
    TapeInputs at = r->taylor.tapes.at, blur = r->taylor.tapes.blur;
    Real turns, phase;
    int c;
    taylor_values(f, tau, f->values);
    for (c = 0; c < r->columns; c++) {
        int from = c < r->bodies ? c : c > r->bodies && r->has_base ? base_column(r) : -1;
        at.x[c] = from < 0 ? 0.0 : values[from];
        at.v[c] = from < 0 ? 0.0 : values[f->rates + from];
        blur.x[c] = lost * fabs(at.x[c]);
        blur.v[c] = lost * fabs(at.v[c]);
    }
    at.t = t + tau;
    blur.t = lost * fabs(at.t);
    at.phi = at.w = 0.0;
    if (r->has_motor) {
        phase = reduce_angle(values[r->bodies], &turns);
        at.phi = unwind(phase, f->turns + turns);
        at.w = values[f->rates + r->bodies];
    }
    blur.phi = lost * fabs(at.phi);
    blur.w = lost * fabs(at.w);
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
        const Real *series = room->series[place];
        Real allowed = 2 * room->bounds[place] + order * tolerance * size_of(series, order, tau);
        Real off = fabs(room->values[place] - horner(series, order, tau));
        double beyond = BEYOND_ALL;
        if (off <= allowed && isfinite(allowed)) /* a value that overflows has no bound */
            continue;
        if (isfinite(off) && allowed > 0)
            beyond = binary_exponent(off) - binary_exponent(allowed);
        worst = beyond > worst ? beyond : worst;
        worst = worst > 1.0 ? worst : 1.0;
    }
    return worst;
}

/* The stretch tau from t, or a shorter one, at the end of which the derivatives have the values that their series say. */
Real formula_sound_stretch(Run *r, Real t, Real tau)
{
    const TaylorTangent *of = &r->tangent->taylor;
    const Real tolerance = power_of_two(r->tolerance_exponent), shortest = tau * LEAST_SHARE;
    const Taylor *f = t != r->t0 ? &of->spare : &r->taylor;
    int i;
    taylor_prepare(r, t);
    for (i = 0; i < SHORTENINGS; i++) {
        double beyond, digits;
        values_at(r, f, of->along, t, tau);
        beyond = excess(r, of->along, tau, tolerance);
        if (beyond <= 0 || tau <= shortest)
            return tau;
        digits = (beyond + 1) / r->taylor.order;
        tau = tau * power_of_two(-(digits > LEAST_SHORTENING ? digits : LEAST_SHORTENING));
    }
    return tau;
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

/* Trace of the derivatives of accelerations with respect to velocities. */
Real formula_divergence(const Run *r, Real tau)
{
    const SlopeRows *rows = &r->mode->formula_slopes.rows[1];
    const Real *values = fill(r, rows, tau);
    Real total = 0.0;
    int i;
    for (i = 0; i < rows->entry_count; i++)
        if (rows->entries[i].column == rows->entries[i].row)
            total = total + values[i];
    return total;
}
