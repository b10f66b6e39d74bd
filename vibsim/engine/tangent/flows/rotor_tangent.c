/* Disturbances of rotors on bodies (rotors_on_bodies.c): with q = c w dphi + s dw
 *
 *     M A - sum u s dw' = dF + sum u (q' - s dw'),     I dw' - u s A = dT + u c a dphi
 */
#include "tangent.h"

/* Number of the group that a rotor is on. */
static int group_of(const Run *r, const Rotors *o, int i)
{
    int g = 0;
    while (o->leaders[g] != r->mode->leader[o->of[i].on])
        g++;
    return g;
}

/* Series c w = s' and c a of the rotors as they are expanded now. */
void rotor_tangent_prepare(Run *r)
{
    const Rotors *o = &r->rotors;
    TaylorTangent *of = &r->tangent->taylor;
    int i, n, k;
    for (i = 0; i < o->count; i++) {
        const Real *s = series_along(o->sine, i), *c = series_along(o->cosine, i), *a = series_along(o->acceleration, group_of(r, o, i));
        for (n = 0; n < r->taylor.order && !hears_signal(r, n); n++) {
            Real total = 0.0;
            for (k = 0; k <= n; k++)
                total = total + c[k] * a[n - k];
            series_along(of->turning, i)[n] = (n + 1) * s[n + 1];
            series_along(of->pull, i)[n] = total;
        }
    }
}

/* Sum of a_i b_(n-i) from i = first to last; b points at the coefficient that a_first meets. */
static Pair sum(const Real *a, const Lane *b, int first, int last)
{
    Pair total = make_pair(0, 0);
    int i;
    for (i = first; i <= last; i++)
        total = add_product(total, twice(a[i]), load_pair(b[first - i]));
    return total;
}

/* Disturbed torque on rotor i, without the term of the acceleration that is not known yet. */
static Pair torque_on(const TaylorTangent *of, int i, int n, const Lane *phi, const Lane *pushed, Pair torque)
{
    Pair back = add_pair(sum(series_along(of->pull, i), phi + n, 0, n), sum(series_along(of->rotors->sine, i), pushed + n - 1, 1, n));
    return add_pair(torque, multiply_pair(twice(of->rotors->of[i].unbalance), back));
}

/* Coefficient n + 1 of the disturbed q without s_0 dw_(n+1). */
static Pair tail_of(const TaylorTangent *of, int i, int n, const Lane *phi, const Lane *w, Real inverse)
{
    const Real *turning = series_along(of->turning, i);
    Pair total = add_product(make_pair(0, 0), twice(turning[0]), multiply_pair(load_pair(w[n]), twice(inverse)));
    int k;
    for (k = 1; k <= n + 1; k++)
        total = add_product(total, twice(turning[k]), load_pair(phi[n + 1 - k]));
    return add_pair(total, sum(series_along(of->rotors->sine, i), w + n, 1, n + 1));
}

/* Disturbed acceleration of order n of a group, and of its rotors. */
static void turn_group(const Run *r, Lane *series, int g, int n, const Lane *F, Lane *acceleration, Lane *pushed)
{
    const TaylorTangent *of = &r->tangent->taylor;
    const Rotors *o = of->rotors;
    const int leader = o->leaders[g], rates = r->bodies + 2;
    Pair force = load_pair(F[leader]), a = make_pair(0, 0);
    int i;
    for (i = 0; i < o->count; i++) {
        const RotorOn *one = &o->of[i];
        const Lane *phi = (const Lane *)component(series, one->column), *w = (const Lane *)component(series, rates + one->column);
        Pair torque, pulled;
        if (r->mode->leader[one->on] != leader)
            continue;
        torque = torque_on(of, i, n, phi, (const Lane *)pushed, load_pair(F[one->column]));
        store_pair(of->torques[i], torque);
        pulled = multiply_pair(twice(n + 1), tail_of(of, i, n, phi, w, r->taylor.inverse[n + 1]));
        force = add_product(force, twice(one->unbalance), pulled);
        pulled = multiply_pair(twice(one->unbalance * *series_along(o->sine, i)), torque);
        force = add_pair(force, make_pair(first_of_pair(pulled) / one->inertia, second_of_pair(pulled) / one->inertia));
    }
    if (leader < r->bodies)
        a = make_pair(first_of_pair(force) / o->mass[g], second_of_pair(force) / o->mass[g]);
    store_pair(pushed[n], a);
    store_pair(acceleration[leader], a);
    for (i = 0; i < o->count; i++) {
        const RotorOn *one = &o->of[i];
        Pair turned;
        if (r->mode->leader[one->on] != leader)
            continue;
        turned = add_product(load_pair(of->torques[i]), twice(one->unbalance * *series_along(o->sine, i)), a);
        store_pair(acceleration[one->column], make_pair(first_of_pair(turned) / one->inertia, second_of_pair(turned) / one->inertia));
    }
}

/* Disturbed accelerations of order n of the rotors and of the groups that they are on, from disturbed forces F. */
void rotor_tangent_turn(const Run *r, Lane *series, int n, const Lane *F, Lane *acceleration, Lane *pushed)
{
    int g;
    for (g = 0; g < r->tangent->taylor.rotors->groups; g++)
        turn_group(r, series, g, n, F, acceleration, pushed + g * SERIES);
}
