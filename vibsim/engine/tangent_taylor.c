/* Disturbances along a step of the Taylor flow, two at a time; twin of vibsim/engine/tangent_taylor.py. */
#include "numbers.h"
#include "tangent.h"

#define REACH 1.25

typedef double Lane[2]; /* one number of two disturbances */

static inline Pair twice(double value)
{
    return make_pair(value, value);
}

/* Bound of the largest eigenvalue of stiffness (stiff) or damping of the couplings' differences. */
static double fastest(const Run *r, int stiff)
{
    const Mode *m = r->mode;
    double *strength = r->tangent->force, largest = 0.0;
    int i;
    for (i = 0; i < r->columns; i++)
        strength[i] = 0.0;
    for (i = 0; i < m->coupling_count; i++) {
        const Coupling *q = &m->couplings[i];
        double value = stiff ? q->k : q->c;
        if (q->to_P == q->to_Q)
            continue;
        strength[q->to_P] = strength[q->to_P] + value;
        strength[q->to_Q] = strength[q->to_Q] + value;
    }
    for (i = 0; i < m->coupling_count; i++) {
        const Coupling *q = &m->couplings[i];
        if (q->to_P != q->to_Q && (stiff ? q->k : q->c) > 0) {
            double row = strength[q->to_P] * m->mobility[q->to_P] + strength[q->to_Q] * m->mobility[q->to_Q];
            largest = row > largest ? row : largest;
        }
    }
    return largest;
}

/* Rate at which the motor's drag damps the rotor, at most. */
static double dragging(const Run *r)
{
    const Taylor *f = &r->taylor;
    double mass;
    if (r->mode->carried == 0)
        return f->drag / f->inertia;
    mass = r->mode->carried + r->m3;
    return f->drag * mass / (mass * f->inertia - f->unbalance * f->unbalance);
}

double taylor_piece_end(const Run *r, double t, double end)
{
    double rates[4], rate, ahead;
    int count = 2, i;
    rates[0] = sqrt(fastest(r, 1)) / REACH;
    rates[1] = fastest(r, 0);
    if (r->has_motor) {
        rates[2] = dragging(r);
        rates[3] = fabs(r->taylor.w_back[r->taylor.order]) / REACH;
        count = 4;
    }
    rate = rates[0];
    for (i = 1; i < count; i++)
        rate = rates[i] > rate ? rates[i] : rate;
    ahead = rate > 0 ? t + r->tangent->taylor.reach / rate : end;
    return t < ahead && ahead < end ? ahead : end;
}

/* Series c w = s' and c a1 of the flow, and its mass matrix, as it is expanded now. */
static void prepare_motor(Run *r)
{
    const Taylor *f = &r->taylor;
    TaylorTangent *of = &r->tangent->taylor;
    int p = f->order, n, i;
    for (n = 0; n <= p; n++)
        of->sine[n][0] = of->sine[n][1] = f->sine[n];
    for (n = 0; n < p; n++)
        of->turning[n][0] = of->turning[n][1] = (n + 1) * f->sine[n + 1];
    for (n = 0; n < p - 1; n++) {
        const double *back = f->a1_back + (p - n); /* back[i]: order n - i */
        Pair sums = make_pair(0, 0);
        for (i = 0; i < n; i += 2)
            sums = add_product(sums, load_pair(f->cosine + i), load_pair(back + i));
        if (i == n)
            sums = add_product(sums, make_pair(f->cosine[i], 0), make_pair(back[i], 0));
        of->pull[n][0] = of->pull[n][1] = sum_of_pair(sums);
    }
    if (r->mode->carried > 0) {
        double mass = r->mode->carried + r->m3, coupling = f->unbalance * f->sine[0];
        double inverse_det = 1 / (mass * f->inertia - coupling * coupling);
        of->to_a1 = f->inertia * inverse_det;
        of->to_w = mass * inverse_det;
        of->cross = coupling * inverse_det;
    }
}

/* The same with the flow expanded anew at t, within its step. */
static void prepare_motor_at(Run *r, double t)
{
    TaylorTangent *of = &r->tangent->taylor;
    Taylor flow = r->taylor;
    double t0 = r->t0, steps = r->steps;
    flow_state(r, t, &r->scratch);
    r->taylor = of->spare;
    taylor_enter(r, &r->scratch);
    prepare_motor(r);
    of->spare = r->taylor;
    r->taylor = flow;
    r->t0 = t0;
    r->steps = steps;
}

static void prepare(Run *r, double t, double end)
{
    r->tangent->taylor.tau = end - t;
    if (!r->has_motor)
        return;
    if (t != r->t0)
        prepare_motor_at(r, t);
    else
        prepare_motor(r);
}

/* Series of the components: displacements of the bodies, phi, 0; then their rates; then the acceleration of the motor's group. */
static inline int zero_component(const Run *r)
{
    return r->bodies + 1;
}

static inline Lane *component(const Run *r, int k)
{
    return r->tangent->taylor.series + (size_t)k * SERIES;
}

/* Coefficient n + 1 of q without s_0 dw_(n+1), and n of c a1 dphi + s A1 without s_0 A1_n. */
static inline void products(const TaylorTangent *of, const Lane *phi, const Lane *w, const Lane *a1, int n, Pair *tail, Pair *back)
{
    Pair turned = make_pair(0, 0), pulled = turned, driven = turned, pushed = turned;
    Pair turned_odd = turned, pulled_odd = turned, driven_odd = turned, pushed_odd = turned, angle;
    int i;
    for (i = 2; i < n; i += 2) {
        Pair sine = load_pair(of->sine[i]), sine_odd = load_pair(of->sine[i + 1]);
        Pair angle_odd = load_pair(phi[n - i - 1]);
        angle = load_pair(phi[n - i]);
        turned = add_product(turned, load_pair(of->turning[i + 1]), angle);
        pulled = add_product(pulled, load_pair(of->pull[i]), angle);
        driven = add_product(driven, sine, load_pair(w[n + 1 - i]));
        pushed = add_product(pushed, sine, load_pair(a1[n - i]));
        turned_odd = add_product(turned_odd, load_pair(of->turning[i + 2]), angle_odd);
        pulled_odd = add_product(pulled_odd, load_pair(of->pull[i + 1]), angle_odd);
        driven_odd = add_product(driven_odd, sine_odd, load_pair(w[n - i]));
        pushed_odd = add_product(pushed_odd, sine_odd, load_pair(a1[n - i - 1]));
    }
    if (i == n) {
        Pair sine = load_pair(of->sine[i]);
        angle = load_pair(phi[0]);
        turned = add_product(turned, load_pair(of->turning[i + 1]), angle);
        pulled = add_product(pulled, load_pair(of->pull[i]), angle);
        driven = add_product(driven, sine, load_pair(w[1]));
        pushed = add_product(pushed, sine, load_pair(a1[0]));
    }
    turned = add_pair(add_pair(turned, turned_odd), add_pair(driven, driven_odd));
    pulled = add_pair(add_pair(pulled, pulled_odd), add_pair(pushed, pushed_odd));
    if (n > 0) {
        turned = add_product(turned, load_pair(of->turning[2]), load_pair(phi[n - 1]));
        pulled = add_product(pulled, load_pair(of->pull[1]), load_pair(phi[n - 1]));
        turned = add_product(turned, load_pair(of->sine[1]), load_pair(w[n]));
        pulled = add_product(pulled, load_pair(of->sine[1]), load_pair(a1[n - 1]));
    }
    turned = add_product(turned, load_pair(of->turning[1]), load_pair(phi[n]));
    pulled = add_product(pulled, load_pair(of->pull[0]), load_pair(phi[n]));
    turned = add_product(turned, load_pair(of->turning[0]), load_pair(phi[n + 1]));
    *tail = add_product(turned, load_pair(of->sine[n + 1]), load_pair(w[0]));
    *back = pulled;
}

/* Disturbed acceleration of the motor's group; advances the rotor. */
static Pair turn(const Run *r, int n, Pair force)
{
    const Taylor *f = &r->taylor;
    const TaylorTangent *of = &r->tangent->taylor;
    Lane *phi = component(r, r->bodies), *w = component(r, 2 * r->bodies + 2), *a1 = component(r, 2 * r->bodies + 4);
    const Pair inverse = twice(f->inverse[n + 1]);
    Pair tail, back, torque, thrust, rotor, pushed = make_pair(0, 0);
    store_pair(phi[n + 1], multiply_pair(load_pair(w[n]), inverse));
    products(of, (const Lane *)phi, (const Lane *)w, (const Lane *)a1, n, &tail, &back);
    torque = subtract_pair(multiply_pair(twice(f->unbalance), back), multiply_pair(twice(f->drag), load_pair(w[n])));
    if (r->mode->carried == 0) {
        rotor = make_pair(first_of_pair(torque) / f->inertia, second_of_pair(torque) / f->inertia);
    } else {
        thrust = add_product(force, twice(f->unbalance), multiply_pair(twice(n + 1), tail));
        pushed = add_product(multiply_pair(twice(of->to_a1), thrust), twice(of->cross), torque);
        rotor = add_product(multiply_pair(twice(of->to_w), torque), twice(of->cross), thrust);
    }
    store_pair(w[n + 1], multiply_pair(rotor, inverse));
    store_pair(a1[n], pushed);
    return pushed;
}

static Pair difference(const Run *r, int P, int Q, int rates, int n)
{
    P = P < r->bodies ? P : zero_component(r);
    Q = Q < r->bodies ? Q : zero_component(r);
    return subtract_pair(load_pair(component(r, rates + P)[n]), load_pair(component(r, rates + Q)[n]));
}

/* Coefficients n + 1 from those of order n and below. */
static void advance(const Run *r, int n)
{
    const Mode *m = r->mode;
    const int rates = r->bodies + 2, on = r->has_motor ? m->leader[r->motor_on] : -1;
    const Pair inverse = twice(r->taylor.inverse[n + 1]);
    Lane *F = r->tangent->taylor.force;
    int i, c;
    for (i = 0; i < r->columns; i++)
        F[i][0] = F[i][1] = 0.0;
    for (i = 0; i < m->coupling_count; i++) {
        const Coupling *q = &m->couplings[i];
        Pair force = multiply_pair(twice(q->k), difference(r, q->P, q->Q, 0, n));
        force = add_product(force, twice(q->c), difference(r, q->P, q->Q, rates, n));
        store_pair(F[q->to_P], subtract_pair(load_pair(F[q->to_P]), force));
        store_pair(F[q->to_Q], add_pair(load_pair(F[q->to_Q]), force));
    }
    for (c = 0; c < r->bodies; c++)
        if (c != on && m->leader[c] == c)
            store_pair(F[c], multiply_pair(load_pair(F[c]), twice(m->mobility[c])));
    if (on >= 0)
        store_pair(F[on], turn(r, n, load_pair(F[on])));
    for (c = 0; c < r->bodies; c++) {
        int leader = m->leader[c];
        Pair rate = leader < r->bodies ? multiply_pair(load_pair(F[leader]), inverse) : make_pair(0, 0);
        store_pair(component(r, c)[n + 1], multiply_pair(load_pair(component(r, rates + c)[n]), inverse));
        store_pair(component(r, rates + c)[n + 1], rate);
    }
}

/* `horner` of both. */
static Pair value_at(const Lane *c, int count, double tau)
{
    const Pair time = twice(tau), square = twice(tau * tau);
    Pair high = load_pair(c[count - 1]), low = load_pair(c[count - 2]);
    int n;
    for (n = count - 3; n > 0; n -= 2) {
        high = add_product(load_pair(c[n]), high, square);
        low = add_product(load_pair(c[n - 1]), low, square);
    }
    if (count % 2 == 0)
        return add_product(low, time, high);
    return add_product(add_product(load_pair(c[0]), high, square), time, low);
}

/* Component of the entry k of a disturbance. */
static int component_of_entry(const Run *r, int k)
{
    const int n = r->bodies;
    return k < n ? k : k < 2 * n ? k + 2 : k == 2 * n ? n : 2 * n + 2;
}

/* The disturbances number `first` and the next one after the piece. */
static void move_two(Run *r, int first)
{
    Tangent *b = r->tangent;
    const int order = r->taylor.order;
    int k, n;
    for (k = 0; k < b->size; k++)
        store_pair(component(r, component_of_entry(r, k))[0], load_pair(b->vectors + k * b->stride + first));
    for (n = 0; n < order - 1; n++)
        advance(r, n);
    for (k = 0; k < b->size; k++) {
        Pair moved = value_at((const Lane *)component(r, component_of_entry(r, k)), order, b->taylor.tau);
        double *to = b->vectors + k * b->stride + first;
        if (first + 1 < b->possible)
            store_pair(to, moved);
        else
            to[0] = first_of_pair(moved);
    }
}

void taylor_move(Run *r, double t, double end)
{
    int i;
    prepare(r, t, end);
    for (i = 0; i < r->tangent->possible; i += 2)
        move_two(r, i);
}
