/* Steps with formulas, and the values of these within them.
 *
 * What a series leaves out may grow where its last terms do not show it: exp far from zero, roots near zero. So a step with
 * formulas is shortened until, at its end and at a place before it, the formulas have the values that their series say.
 */
#include "columns.h"
#include "pair.h"
#include "sound_steps.h"

#define SHORT_CONTACT 16.0    /* binary digits by which a step is too long that ends behind a contact that it begins */
#define SHORTENINGS 400       /* of a step, each at least by */
#define HUGE_EXPONENT 800     /* of two: what is made of such a coefficient, by numbers up to 2^220, may overflow */
#define NEARER 0.75           /* of a step, where formulas are compared as well */
#define INPUT_ROUNDING 2      /* of displacements and velocities at the end of a step, in units of EPS */
#define STATE_ROUNDING 8      /* the same at an event */

/* Values and bounds of the formulas of the mode a time tau after the expansion point, from the columns there. */
static void evaluate_from(const Run *r, const Real *columns, Real tau, Real *values, Real *bounds)
{
    const Taylor *f = &r->taylor;
    TapeInputs at = f->tapes.at, blur = f->tapes.blur;
    read_columns(r, columns, &at);
    at.t = r->t0 + tau;
    at.phi = r->has_motor ? columns[r->bodies] : 0.0;
    at.w = r->has_motor ? columns[f->rates + r->bodies] : 0.0;
    blur_inputs(r, &at, INPUT_ROUNDING * EPS, &blur);
    blur.t = EPS * fabs(at.t);
    tape_evaluate(&r->mode->tape, &at, &blur, values, bounds);
}

/* The same from the series; at the expansion point too. */
void tape_values(const Run *r, Real tau)
{
    const Taylor *f = &r->taylor;
    if (tau != 0 || r->has_motor)
        taylor_values(f, tau, f->values);
    evaluate_from(r, tau != 0 || r->has_motor ? f->values : f->table, tau, f->tapes.values, f->tapes.bounds);
}

/* The same of mode m at a state; X, V: displacement and velocity of the base there. rates: of all velocities, in the order of
 * the table, for what the rounding of the time leaves open of them; NULL where bounds are not asked for.
 */
void tape_values_at(const Run *r, const Mode *m, const State *state, Real X, Real V, const Real *rates)
{
    const TapeRoom *room = &r->taylor.tapes;
    TapeInputs at = room->at, blur = room->blur;
    const Real lost = STATE_ROUNDING * EPS, late = lost * fabs(state->t);
    int c;
    for (c = 0; c < r->columns; c++) {
        at.x[c] = column_value(r, state->x, c, X);
        at.v[c] = column_value(r, state->v, c, V);
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

/* Whether an output is a motion that time alone gives: of the base, the first output where that moves by a formula, or of a belt. */
static int is_given(const Mode *m, int k)
{
    int i, j;
    if (k == 0 && m->base_tape.op_count > 0)
        return 1;
    for (i = 0; i < m->follower_count; i++)
        if (m->followers[i].place == m->tape.outputs[k])
            return 1;
    for (i = 0; i < m->event_count; i++)
        for (j = 0; m->events[i].kind == SLIDE && j < m->events[i].terms; j++)
            if (m->terms[m->events[i].first + j].kind == FORMULA && m->terms[m->events[i].first + j].P == k)
                return 1;
    return 0;
}

/* What a force that moves nothing has to be small beside: what holds the ties that it pulls at. Where none may give way,
 * the force of which the impulse over the rest of the run is that of `value` over the step. What moves base or belt is small beside
 * what it is over the step, or where it has hardly begun beside that over the rest of the run; 0 of all else.
 */
static Real held_by(const Run *r, int k, Real h, Real value)
{
    const Mode *m = r->mode;
    const Real start = fabs(*series_along(r->taylor.tapes.series, m->tape.outputs[k])), end = fabs(value);
    Real least = INFINITY;
    int i, j;
    for (i = 0; i < m->event_count; i++) {
        const Event *e = &m->events[i];
        const Term *terms = m->terms + e->first;
        Real size = e->size;
        int reads = 0;
        for (j = 0; e->kind == HOLD && j < e->terms; j++)
            if (terms[j].kind == FORMULA) {
                size = size + fabs(*series_along(r->taylor.tapes.series, m->tape.outputs[terms[j].P]));
                reads = reads || terms[j].P == k;
            }
        least = reads && size < least ? size : least;
    }
    if (isfinite(least))
        return least;
    for (i = 0; i < m->formula_count; i++)
        if (m->formulas[i].output == k && (m->formulas[i].to_P >= 0 || m->formulas[i].to_Q >= 0))
            return end * (r->t_end - r->t0) / h;
    if (!is_given(m, k))
        return 0.0;
    return 2 * start > end ? (start > end ? start : end) : end * (r->t_end - r->t0) / h;
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
    return f->order * tolerance * (mobile ? share : held_by(r, k, h, value));
}

/* A series at two times, as `horner` has it. */
static Pair twice_horner(const Real *series, int count, Pair time)
{
    const Pair square = multiply_pair(time, time);
    Pair high = twice(series[count - 1]), low = twice(series[count - 2]);
    int n;
    for (n = count - 3; n > 0; n -= 2) {
        high = add_product(twice(series[n]), high, square);
        low = add_product(twice(series[n - 1]), low, square);
    }
    if (count % 2 == 0)
        return add_product(low, time, high);
    return add_product(add_product(twice(series[0]), high, square), time, low);
}

/* Whether the base of a power begins at its zero: it rises from there, of whatever order the zero is. */
static int begins(const Real *base, int count, Real least)
{
    int n;
    if (base[0] > least * fabs(base[1]))
        return 0;
    for (n = 1; n < count - 1 && base[n] == 0; n++)
        ;
    return base[n] > 0;
}

/* Whether the base of a power begins at its zero and is over before the time of `values`. */
static int ends_early(const Run *r, const Real *values, const Real *bounds)
{
    const TapeRoom *room = &r->taylor.tapes;
    const Tape *tape = &r->mode->tape;
    int k;
    for (k = 0; k < tape->op_count; k++) {
        const Op *op = &tape->ops[k];
        const Real *base = series_along(room->series, op->a < 0 ? 0 : op->a);
        if (op->code == OP_POWER && values[op->a] < -bounds[op->a] && begins(base, r->taylor.order, room->least))
            return 1;
    }
    return 0;
}

/* By how many binary digits the worst formula is beyond what it may be wrong by at the end h of a step, and at NEARER of it; 0 where
 * none is.
 */
static double excess(Run *r, Real h, Real tolerance)
{
    Taylor *f = &r->taylor;
    const Tape *tape = &r->mode->tape;
    Real tau[2], *values[2], *bounds[2], at[2];
    double worst[2];
    int singular[2] = {NOTHING, NOTHING}, i, k;
    tau[0] = h;
    tau[1] = NEARER * h;
    taylor_values_twice(f, tau, f->checked);
    f->checked_at = h;
    for (i = 0; i < 2; i++) {
        values[i] = i == 0 ? f->tapes.checked : f->tapes.values;
        bounds[i] = values[i] + f->tapes.ops;
        evaluate_from(r, f->checked + i * f->stride, tau[i], values[i], bounds[i]);
        f->tapes.latest = tape->number;
        worst[i] = tape->powers && ends_early(r, values[i], bounds[i]) ? SHORT_CONTACT : 0.0;
    }
    for (k = 0; k < tape->output_count; k++) {
        int place = tape->outputs[k];
        const Real *series = series_along(f->tapes.series, place);
        store_pair(at, twice_horner(series, f->order, load_pair(tau)));
        for (i = 0; i < 2; i++) {
            const Real off = fabs(values[i][place] - at[i]), bound = 2 * bounds[i][place];
            const Real share = share_of(r, k, tau[i], values[i][place], tolerance);
            double beyond = digits_beyond(off, bound + share);
            if (beyond > 0) /* the rounding of the series is seldom needed */
                beyond = digits_beyond(off, bound + 2 * EPS * sizes_at(series, f->order, h) + share);
            if (beyond > worst[i]) {
                worst[i] = beyond;
                singular[i] = k;
            }
        }
    }
    for (i = 0; i < 2; i++)
        r->singular = singular[i] != NOTHING ? singular[i] : r->singular;
    return worst[0] > worst[1] ? worst[0] : worst[1];
}

/* The step that is not made shorter: where the base of a power is at its zero within the resolution of time, so that the power is
 * known no better. A belt may also carry a body there so slowly that shorter steps do not move it.
 */
static Real shortest_step(const Run *r)
{
    const TapeRoom *room = &r->taylor.tapes;
    const Tape *tape = &r->mode->tape;
    int k;
    for (k = 0; tape->powers && k < tape->op_count; k++) {
        const Real *base;
        if (tape->ops[k].code != OP_POWER)
            continue;
        base = series_along(room->series, tape->ops[k].a);
        if ((base[1] < 0 || tape->ops[k].value > 0) && !(base[0] > room->least * fabs(base[1])))
            return 2 * room->least;
    }
    return 0.0;
}

/* A step of length h, of which the end is on the grid of time. */
static Real on_grid(const Run *r, Real h)
{
    const Real tau = (r->t0 + h) - r->t0;
    return tau > 0 ? tau : h;
}

/* The time [s] within which the base of a power is at its zero, of powers whose series of so many coefficients grow so near it that
 * they overflow, or that what is made of them does: products with other numbers, accelerations; 0 where none does.
 */
Real overflowing_zero(const Tape *tape, const TapeRoom *room, int count)
{
    const Real huge = power_of_two(HUGE_EXPONENT);
    Real nearest = 0.0;
    int k, n;
    for (k = 0; tape->powers && k < tape->op_count; k++) {
        const Real *base = series_along(room->series, tape->ops[k].a < 0 ? 0 : tape->ops[k].a), *series = series_along(room->series, k);
        Real time;
        if (tape->ops[k].code != OP_POWER || !(base[0] > 0))
            continue;
        for (n = 0; n < count && fabs(series[n]) < huge; n++) /* what is no number is not below it */
            ;
        time = n < count && base[1] != 0 ? 2 * (base[0] / fabs(base[1])) : 0.0;
        nearest = time > nearest && isfinite(time) ? time : nearest;
    }
    return nearest;
}

/* The step, or a shorter one, at the end of which the formulas have the values that their series say: shortened by the binary
 * digits that the worst of them is beyond, over the order. The status is SINGULAR where no step that moves time is short enough.
 */
void shorten_step(Run *r)
{
    Taylor *f = &r->taylor;
    const Real left = r->t_end - r->t0, tolerance = power_of_two(r->tolerance_exponent);
    Real h = f->h < left ? on_grid(r, f->h) : left, shortest;
    int i;
    if (!(left > 0))
        return;
    shortest = shortest_step(r);
    r->singular = NOTHING;
    for (i = 0; i < SHORTENINGS; i++) {
        double most = excess(r, h, tolerance);
        if (most <= 0 || (h <= shortest && most < BEYOND_ALL)) {
            f->h = h == left ? f->h : h;
            return;
        }
        h = on_grid(r, shortened(h, most, f->order));
        if (h <= EPS * r->t0) /* in doubles: t0 + h is t0; numbers of more words would still move, far within their rounding */
            break;
    }
    r->status = SINGULAR;
}
