/* How small disturbances move along one step of the Taylor flow.
 *
 * The recurrences of the flow, linearised: loads and constants drop out, couplings pass dS = k dd + c dd', formulas enter by
 * their partial derivatives. With s = sin phi, c = cos phi, a1 the acceleration of the motor's group, b = m3 e and dS the sum of
 * these forces on the group,
 *     (m + m3) A1 - b s dw' = b (q' - s dw') - dS,            q = c w dphi + s dw
 *     (J + m3 e^2) dw' - b s A1 = b c a1 dphi - (M0 / Omega0) dw
 * with s dw' on the left at the expansion point. The series of a disturbance end one order below the flow's, whose steps keep its
 * last two orders below the tolerance. A flow at rest, or on a slow path of strong damping, may take steps that are too long for
 * its disturbances: then these go in pieces.
 *
 * Two disturbances go side by side.
 */
#if defined(LIMBS) && !defined(__clang__)
#pragma GCC optimize("O2") /* most of the time of disturbances goes into their recurrences */
#endif
#include <stddef.h>
#include <string.h>

#include "inlining.h"
#include "tangent.h"

#define SHAPE APART void /* one function each, as in taylor_expansion.c */

/* Series c w = s' and c a1 of the flow, and its mass matrix, as it is expanded now. */
static void prepare_motor(Run *r)
{
    const Taylor *f = &r->taylor;
    TaylorTangent *of = &r->tangent->taylor;
    int p = f->order, n, i;
    for (n = 0; n <= p; n++)
        of->joint[n].sine[0] = of->joint[n].sine[1] = f->sine[n];
    of->first_turning[0] = of->first_turning[1] = f->sine[1];
    for (n = 0; n < p - 1; n++)
        of->joint[n].turning[0] = of->joint[n].turning[1] = (n + 2) * f->sine[n + 2];
    for (n = 0; n < p - 1 && !hears_signal(r, n); n++) {
        const Real *back = f->a1_back + (p - n); /* back[i]: order n - i */
        Pair sums = make_pair(0, 0);
        for (i = 0; i < n; i += 2)
            sums = add_product(sums, load_pair(f->cosine + i), load_pair(back + i));
        if (i == n)
            sums = add_product(sums, make_pair(f->cosine[i], 0), make_pair(back[i], 0));
        of->joint[n].pull[0] = of->joint[n].pull[1] = sum_of_pair(sums);
    }
    if (r->mode->carried > 0) {
        Real mass = r->mode->carried + r->m3, coupling = r->unbalance * f->sine[0];
        Real inverse_det = 1 / (mass * r->inertia - coupling * coupling);
        of->to_a1 = r->inertia * inverse_det;
        of->to_w = mass * inverse_det;
        of->cross = coupling * inverse_det;
    }
}

static void prepare_here(Run *r)
{
    if (r->has_motor)
        prepare_motor(r);
    if (r->rotors.count > 0)
        rotor_tangent_prepare(r);
}

/* The same with the flow expanded anew at t, within its step. */
static void prepare_at(Run *r, Real t)
{
    TaylorTangent *of = &r->tangent->taylor;
    Taylor flow = r->taylor;
    Rotors rotors = r->rotors;
    Real t0 = r->t0;
#ifdef FIXED_SERIES
    const Scales<SERIES> scales = r->mode->scales;
#endif
    flow_state(r, t, &r->scratch);
    r->taylor = of->spare;
    r->rotors = of->spare_rotors;
    taylor_look(r, &r->scratch);
#ifdef FIXED_SERIES
    r->mode->scales = scales; /* the motion is that without disturbances */
#endif
    prepare_here(r);
    if (r->mode->formula_slopes.known)
        formula_slopes_expand(r, &of->here);
    of->along = &of->here;
    of->spare = r->taylor;
    of->spare_rotors = r->rotors;
    of->rotors = &of->spare_rotors;
    r->taylor = flow;
    r->rotors = rotors;
    r->t0 = t0;
}

void taylor_prepare(Run *r, Real t)
{
    TaylorTangent *of = &r->tangent->taylor;
    if (of->prepared && of->prepared_at == t)
        return;
    of->prepared = 1;
    of->prepared_at = t;
    if (t != r->t0) {
        prepare_at(r, t);
    } else {
        prepare_here(r);
        of->along = formula_slopes_of_step(r);
        of->rotors = &r->rotors;
    }
}

/* The means of the derivatives in place of their series, where the base of a power is zero. */
static void prepare_at_zero(Run *r, Real t, Real end)
{
    Zeros zeros = formula_zeros(r, t, end);
    if (zeros.count > 0 && !formula_take_means(r, &zeros, t, end - t))
        r->tangent->taylor.undefined = !zeros.mild;
    else if (zeros.count > 0)
        return;
    taylor_prepare(r, t);
}

/* What the recurrences of all disturbances share over the piece from t to `end`, at whose end they are read tau behind t. The flow
 * is expanded anew at t only where its motion matters: with a rotor or formulas.
 */
static void prepare(Run *r, Real t, Real end, Real tau)
{
    r->tangent->taylor.tau = tau;
    r->tangent->taylor.undefined = 0;
    if (r->mode->formula_slopes.known && t < end)
        prepare_at_zero(r, t, end);
    else if (r->has_motor || r->mode->shape == FORMULAS || r->mode->formula_slopes.known)
        taylor_prepare(r, t);
}

/* Series of the components: displacements of the bodies, phi, 0; then their rates; then the acceleration of the motor's group.
 * Those of the rotor, and that acceleration, run backwards: coefficient n is number order - n.
 */
static inline int components_of(const Run *r)
{
    return 2 * r->bodies + 5;
}

/* Coefficient n + 1 of q without s_0 dw_(n+1), and n of c a1 dphi + s A1 without s_0 A1_n. phi[i]: order n - i; so w and a1. The
 * newest terms come last; the others are summed in an odd and an even chain, those with dphi apart from those with s: four chains
 * that a processor takes side by side.
 */
INLINE void products(const TaylorTangent *of, const Lane *phi, const Lane *w, const Lane *a1, int n, Pair *tail, Pair *back)
{
    Pair turned = make_pair(0, 0), pulled = turned, driven = turned, pushed = turned;
    Pair turned_odd = turned, pulled_odd = turned, driven_odd = turned, pushed_odd = turned;
    const Joint *joint = of->joint;
    ptrdiff_t i;
    for (i = 2; i < n; i += 2) {
        Pair angle = load_pair(phi[i]), sine = load_pair(joint[i].sine);
        Pair angle_odd = load_pair(phi[i + 1]), sine_odd = load_pair(joint[i + 1].sine);
        turned = add_product(turned, load_pair(joint[i].turning), angle);
        pulled = add_product(pulled, load_pair(joint[i].pull), angle);
        driven = add_product(driven, sine, load_pair(w[i - 1]));
        pushed = add_product(pushed, sine, load_pair(a1[i]));
        turned_odd = add_product(turned_odd, load_pair(joint[i + 1].turning), angle_odd);
        pulled_odd = add_product(pulled_odd, load_pair(joint[i + 1].pull), angle_odd);
        driven_odd = add_product(driven_odd, sine_odd, load_pair(w[i]));
        pushed_odd = add_product(pushed_odd, sine_odd, load_pair(a1[i + 1]));
    }
    if (i == n) {
        Pair angle = load_pair(phi[i]), sine = load_pair(joint[i].sine);
        turned = add_product(turned, load_pair(joint[i].turning), angle);
        pulled = add_product(pulled, load_pair(joint[i].pull), angle);
        driven = add_product(driven, sine, load_pair(w[i - 1]));
        pushed = add_product(pushed, sine, load_pair(a1[i]));
    }
    turned = add_pair(add_pair(turned, turned_odd), add_pair(driven, driven_odd));
    pulled = add_pair(add_pair(pulled, pulled_odd), add_pair(pushed, pushed_odd));
    if (n > 0) {
        Pair sine = load_pair(joint[1].sine);
        turned = add_product(turned, load_pair(joint[1].turning), load_pair(phi[1]));
        pulled = add_product(pulled, load_pair(joint[1].pull), load_pair(phi[1]));
        turned = add_product(turned, sine, load_pair(w[0]));
        pulled = add_product(pulled, sine, load_pair(a1[1]));
    }
    turned = add_product(turned, load_pair(joint[0].turning), load_pair(phi[0]));
    pulled = add_product(pulled, load_pair(joint[0].pull), load_pair(phi[0]));
    turned = add_product(turned, load_pair(of->first_turning), load_pair(phi[-1]));
    *tail = add_product(turned, load_pair(joint[n + 1].sine), load_pair(w[n]));
    *back = pulled;
}

/* What the recurrences read, in locals: the compiler then knows that no store to a series changes it. */
typedef struct {
    const Real *inverse;
    Real unbalance, drag, inertia, to_a1, to_w, cross, k, c, mobility, mobility_far;
    int order;
} Law;

static Law law_of(const Run *r)
{
    const Taylor *f = &r->taylor;
    const TaylorTangent *of = &r->tangent->taylor;
    Law law = {f->inverse, r->unbalance, r->drag, r->inertia, of->to_a1, of->to_w, of->cross, r->mode->small.k, r->mode->small.c,
               r->mode->mobility[0], r->bodies > 1 ? r->mode->mobility[1] : 0.0, f->order};
    return law;
}

/* Disturbed acceleration of the motor's group under `force`; advances the rotor. carried: whether the group moves as the ground
 * or the base does.
 */
INLINE Pair turn(const TaylorTangent *of, const Law *law, Lane *series, int bodies, int n, Pair force, Pair inverse,
                 const int carried)
{
    Lane *phi = component(series, bodies) + (law->order - n), *w = component(series, 2 * bodies + 2) + (law->order - n);
    Lane *a1 = component(series, 2 * bodies + 4) + (law->order - n);
    Pair tail, back, torque, thrust, rotor, pushed = make_pair(0, 0);
    store_pair(phi[-1], multiply_pair(load_pair(w[0]), inverse));
    products(of, (const Lane *)phi, (const Lane *)w, (const Lane *)a1, n, &tail, &back);
    torque = subtract_pair(multiply_pair(twice(law->unbalance), back), multiply_pair(twice(law->drag), load_pair(w[0])));
    if (carried) {
        rotor = make_pair(first_of_pair(torque) / law->inertia, second_of_pair(torque) / law->inertia);
    } else {
        thrust = add_product(force, twice(law->unbalance), multiply_pair(twice(n + 1), tail));
        pushed = add_product(multiply_pair(twice(law->to_a1), thrust), twice(law->cross), torque);
        rotor = add_product(multiply_pair(twice(law->to_w), torque), twice(law->cross), thrust);
    }
    store_pair(w[-1], multiply_pair(rotor, inverse));
    store_pair(a1[0], pushed);
    return pushed;
}

/* Coefficient n of the disturbance of output k of the tape of the mode. */
static Pair disturbed(const Run *r, Lane *series, int k, int n)
{
    const FormulaSlopes *slopes = &r->mode->formula_slopes;
    const int bodies = r->bodies, ahead = r->taylor.order - n;
    Pair total = make_pair(0, 0);
    int j, i;
    for (j = slopes->first[k]; j < slopes->first[k + 1]; j++) {
        const FormulaSlope *one = &slopes->all[j];
        const Real *slope = series_along(r->tangent->taylor.along->series, slopes->tape.outputs[one->output]);
        const Lane *of;
        switch (one->kind) {
        case BY_PLACE: of = component(series, one->column) + n; break;
        case BY_SPEED: of = component(series, bodies + 2 + one->column) + n; break;
        case BY_ANGLE: of = component(series, bodies) + ahead; break;
        default: of = component(series, 2 * bodies + 2) + ahead;
        }
        for (i = 0; i <= n; i++)
            total = add_product(total, twice(slope[i]), load_pair(one->kind <= BY_SPEED ? of[-i] : of[i]));
    }
    return total;
}

/* Add those of the forces by formulas to F. */
static void disturb_forces(const Run *r, Lane *series, int n, Lane *F)
{
    const Mode *m = r->mode;
    int i;
    for (i = 0; i < m->formula_count; i++) {
        const FormulaForce *one = &m->formulas[i];
        Pair force = multiply_pair(twice(one->sign), disturbed(r, series, one->output, n));
        store_pair(F[one->to_P], add_pair(load_pair(F[one->to_P]), force));
        if (one->to_Q >= 0)
            store_pair(F[one->to_Q], subtract_pair(load_pair(F[one->to_Q]), force));
    }
}

/* Coefficients n + 1 from those of order n and below. */
INLINE void advance(const Run *r, const Law *law, Lane *series, Lane *pushed, int n, const int formulas)
{
    const Mode *m = r->mode;
    const int bodies = r->bodies, zero = bodies + 1, rates = bodies + 2, on = r->has_motor ? m->leader[r->motor_on] : -1;
    const Pair inverse = twice(law->inverse[n + 1]);
    Lane *F = r->tangent->taylor.force, *a = formulas ? F + r->columns : F; /* of formulas: accelerations apart from forces */
    int i, c;
    for (i = 0; i < r->columns; i++)
        F[i][0] = F[i][1] = 0.0;
    for (i = 0; i < m->coupling_count; i++) {
        const Coupling *q = &m->couplings[i];
        const Lane *P = component(series, q->P < bodies ? q->P : zero) + n, *Q = component(series, q->Q < bodies ? q->Q : zero) + n;
        Pair force = multiply_pair(twice(q->k), subtract_pair(load_pair(*P), load_pair(*Q)));
        force = add_product(force, twice(q->c), subtract_pair(load_pair(P[rates * SERIES]), load_pair(Q[rates * SERIES])));
        store_pair(F[q->to_P], subtract_pair(load_pair(F[q->to_P]), force));
        store_pair(F[q->to_Q], add_pair(load_pair(F[q->to_Q]), force));
    }
    if (formulas)
        disturb_forces(r, series, n, F);
    for (c = 0; c < bodies; c++)
        if (c != on)
            store_pair(a[c], multiply_pair(load_pair(F[c]), twice(m->mobility[c])));
    if (formulas && r->rotors.count > 0)
        rotor_tangent_turn(r, series, n, (const Lane *)F, a, pushed);
    if (on >= 0)
        store_pair(a[on], turn(&r->tangent->taylor, law, series, bodies, n, load_pair(F[on]), inverse, r->mode->carried == 0));
    for (c = 0; c < bodies; c++) {
        Lane *x = component(series, c), *v = component(series, rates + c);
        Pair acceleration = m->leader[c] < bodies ? load_pair(a[m->leader[c]]) : make_pair(0, 0);
        store_pair(x[n + 1], multiply_pair(load_pair(v[n]), inverse));
        store_pair(v[n + 1], multiply_pair(acceleration, inverse));
    }
}

#ifndef LIMBS /* operations on words take so long that those of a small scene gain nothing by functions of their own */
/* The same of a body that moves and a second column, as in taylor_expansion.c. */
INLINE void advance_small(const TaylorTangent *of, const Law *law, Lane *series, int n, const int bodies, const int moving, const int motor)
{
    const int far = bodies > 1 ? 1 : bodies + 1, rates = bodies + 2;
    const Pair inverse = twice(law->inverse[n + 1]);
    Lane *x = series + n, *x_far = component(series, far) + n, *v = component(series, rates) + n, *v_far = component(series, rates + far) + n;
    Pair rate = load_pair(*v), rate_far = load_pair(*v_far), force, F, F_far;
    force = multiply_pair(twice(law->k), subtract_pair(load_pair(*x), load_pair(*x_far)));
    force = add_product(force, twice(law->c), subtract_pair(rate, rate_far));
    F = subtract_pair(make_pair(0, 0), force);
    F = motor ? turn(of, law, series, bodies, n, F, inverse, 0) : multiply_pair(F, twice(law->mobility));
    store_pair(x[1], multiply_pair(rate, inverse));
    store_pair(v[1], multiply_pair(F, inverse));
    if (bodies > 1) {
        F_far = moving > 1 ? multiply_pair(multiply_pair(force, twice(law->mobility_far)), inverse) : make_pair(0, 0);
        store_pair(x_far[1], multiply_pair(rate_far, inverse));
        store_pair(v_far[1], F_far);
    }
}

INLINE void expand_small(Run *r, int pairs, const int bodies, const int moving, const int motor)
{
    const int block = (2 * bodies + 5) * SERIES;
    const Law law = law_of(r);
    int n, i;
    for (n = 0; n < law.order - 1; n++)
        for (i = 0; i < pairs; i++)
            advance_small(&r->tangent->taylor, &law, r->tangent->taylor.series + i * block, n, bodies, moving, motor);
}

SHAPE two_free(Run *r, int pairs) { expand_small(r, pairs, 2, 2, 0); }
SHAPE two_free_with_motor(Run *r, int pairs) { expand_small(r, pairs, 2, 2, 1); }
SHAPE two_held(Run *r, int pairs) { expand_small(r, pairs, 2, 1, 0); }
SHAPE two_held_with_motor(Run *r, int pairs) { expand_small(r, pairs, 2, 1, 1); }
SHAPE one(Run *r, int pairs) { expand_small(r, pairs, 1, 1, 0); }
SHAPE one_with_motor(Run *r, int pairs) { expand_small(r, pairs, 1, 1, 1); }
#endif

/* Series of so many pairs of disturbances in any mode, order by order. */
INLINE void expand_any(Run *r, int pairs, const int formulas)
{
    const Law law = law_of(r);
    const int slopes = r->mode->formula_slopes.known ? r->mode->formula_slopes.tape.output_count : 0;
    int n, i;
    for (n = 0; n < law.order - 1 && !hears_signal(r, 2.0 * pairs * (r->columns + (4.0 + slopes + 4 * r->rotors.count) * n)); n++)
        for (i = 0; i < pairs; i++)
            advance(r, &law, r->tangent->taylor.series + i * components_of(r) * SERIES,
                    r->tangent->taylor.pushed + i * r->rotors.count * SERIES, n, formulas);
}

#ifndef LIMBS
SHAPE any(Run *r, int pairs) { expand_any(r, pairs, 0); }
SHAPE formulas(Run *r, int pairs) { expand_any(r, pairs, 1); }
#endif

/* Series of so many pairs of disturbances, one's chains of operations in the waits of another's. */
static void expand(Run *r, int pairs)
{
#ifdef LIMBS
    expand_any(r, pairs, r->mode->shape == FORMULAS);
#else
    static void (*const shapes[])(Run *, int) = {
        any, any, two_free, two_free_with_motor, two_held, two_held_with_motor, one, one_with_motor, formulas, formulas,
    };
    shapes[2 * r->mode->shape + r->has_motor](r, pairs);
#endif
}

/* `horner` of both; the coefficients are `step` apart. */
static Pair value_at(const Lane *c, ptrdiff_t step, int count, Real tau)
{
    const Pair time = twice(tau), square = twice(tau * tau);
    Pair high = load_pair(c[(count - 1) * step]), low = load_pair(c[(count - 2) * step]);
    int n;
    for (n = count - 3; n > 0; n -= 2) {
        high = add_product(load_pair(c[n * step]), high, square);
        low = add_product(load_pair(c[(n - 1) * step]), low, square);
    }
    if (count % 2 == 0)
        return add_product(low, time, high);
    return add_product(add_product(load_pair(c[0]), high, square), time, low);
}

/* Series of the entry k of a pair of disturbances, from its coefficient 0 on; they are `step` apart. */
static inline Lane *series_of_entry(const Run *r, Lane *series, int k, ptrdiff_t *step)
{
    const int n = r->bodies;
    *step = k < 2 * n ? 1 : -1;
    if (k < 2 * n)
        return component(series, k < n ? k : k + 2);
    return component(series, k == 2 * n ? n : 2 * n + 2) + r->taylor.order;
}

/* Whether the last terms of one of a pair of disturbances tell that those left out matter: where formulas vary with time its
 * series goes on longer than the rates at the ends of a stretch tell.
 */
static int misses_terms(const Run *r, Lane *series, int lane)
{
    const Tangent *b = r->tangent;
    const int order = r->taylor.order;
    Real total = 0.0, last = 0.0;
    ptrdiff_t step;
    int k, n;
    for (k = 0; k < b->size; k++) {
        const Lane *of = (const Lane *)series_of_entry(r, series, k, &step);
        Real power = 1.0;
        for (n = 0; n < order; n++) {
            Real size = fabs(of[n * step][lane]) * power;
            total = total + size;
            last = n > order - 3 ? last + size : last;
            power = power * b->taylor.tau;
        }
    }
    return last > LEFT_OUT * total;
}

/* Whether a piece with formulas is too long for some of a group of pairs of disturbances. */
static int is_too_long(const Run *r, int first, int pairs)
{
    const int block = components_of(r) * SERIES;
    int i, lane;
    for (i = 0; i < pairs; i++)
        for (lane = 0; lane < 2 && first + 2 * i + lane < r->tangent->possible; lane++)
            if (misses_terms(r, r->tangent->taylor.series + i * block, lane))
                return 1;
    return 0;
}

/* Up to TANGENT_GROUP pairs of disturbances after the piece, the first of them number `first`. */
static void move_group(Run *r, int first, int pairs)
{
    Tangent *b = r->tangent;
    const int order = r->taylor.order, block = components_of(r) * SERIES;
    Lane *series = b->taylor.series;
    ptrdiff_t step;
    int k, i;
    for (k = 0; k < b->size; k++)
        for (i = 0; i < pairs; i++)
            store_pair(*series_of_entry(r, series + i * block, k, &step), load_pair(b->vectors + k * b->stride + first + 2 * i));
    expand(r, pairs);
    for (k = 0; k < b->size; k++)
        for (i = 0; i < pairs; i++) {
            const Lane *of = (const Lane *)series_of_entry(r, series + i * block, k, &step);
            Pair moved = value_at(of, step, order, b->taylor.tau);
            int number = first + 2 * i;
            Real *to = b->vectors + k * b->stride + number;
            if (number + 1 < b->possible)
                store_pair(to, moved);
            else
                to[0] = first_of_pair(moved);
        }
}

int taylor_move(Run *r, Real t, Real end, Real tau)
{
    Tangent *b = r->tangent;
    const int formulas = r->mode->formula_slopes.known;
    int first, pairs, fits = 1;
    prepare(r, t, end, tau);
    if (formulas || r->hears)
        memcpy(b->moved, b->vectors, sizeof(Real) * (size_t)(b->size * b->stride));
    for (first = 0; first < r->tangent->possible && !r->interrupted; first += 2 * TANGENT_GROUP) {
        pairs = (r->tangent->possible - first + 1) / 2;
        pairs = pairs < TANGENT_GROUP ? pairs : TANGENT_GROUP;
        move_group(r, first, pairs);
        fits = fits && !(formulas && is_too_long(r, first, pairs));
    }
    if (r->interrupted)
        memcpy(b->vectors, b->moved, sizeof(Real) * (size_t)(b->size * b->stride));
    return fits || r->interrupted;
}
