/* Unbalanced rotors on bodies: Taylor series of their pull on the bodies, and the mass matrix.
 *
 * A rotor i with the angle phi, the speed w, the unbalance u = m e and the inertia I = J + m e^2 on a body of a group of mass M,
 * its own mass among it:
 *
 *     M a = F + sum u_i (s w)',       I_i w_i' = T_i + u_i s_i a,       s = sin phi, c = cos phi
 *
 * with (s w)' = s w' + w^2 c (Eqs. 2.9, 2.10 of the paper). Rotors meet in their bodies alone, so that the mass matrix is
 * inverted by one division at the expansion point: by M - sum (u_i s_i)^2 / I_i. Of each sum the newest terms come last: little
 * then waits for them.
 */
#include "engine.h"
#include "numbers.h"
#include "tape_series.h"
#include "wide.h"

/* Speed of rotor `one`, coefficient k. */
static Real speed_of(const Taylor *f, const RotorOn *one, int k)
{
    return f->table[k * f->stride + f->rates + one->column];
}

/* The groups that rotors are on, by ascending leading column. */
static void take_groups(Run *r)
{
    Rotors *o = &r->rotors;
    int i, g, k;
    o->groups = 0;
    for (i = 0; i < o->count; i++) {
        int leader = r->mode->leader[o->of[i].on];
        for (g = 0; g < o->groups && o->leaders[g] < leader; g++)
            ;
        if (g < o->groups && o->leaders[g] == leader)
            continue;
        for (k = o->groups++; k > g; k--)
            o->leaders[k] = o->leaders[k - 1];
        o->leaders[g] = leader;
    }
}

/* Begin at the state that the table begins with: sines and cosines, and of each group the mass less what its rotors take part of
 * it with.
 */
void rotors_expand(Run *r)
{
    Rotors *o = &r->rotors;
    const Mode *m = r->mode;
    int i, g;
    take_groups(r);
    for (i = 0; i < o->count; i++) {
        Real turns, angle = reduce_angle(r->taylor.table[o->of[i].column], &turns);
        rounded_sine_cosine(angle, series_along(o->sine, i), series_along(o->cosine, i));
        o->lean[i] = o->of[i].unbalance * *series_along(o->sine, i) / o->of[i].inertia;
        o->pulled[i] = 0.0;
    }
    for (g = 0; g < o->groups; g++) {
        Real mass = m->group_mass[o->leaders[g]];
        for (i = 0; i < o->count; i++)
            if (m->leader[o->of[i].on] == o->leaders[g]) {
                Real coupling = o->of[i].unbalance * *series_along(o->sine, i);
                mass = mass - coupling * coupling / o->of[i].inertia;
            }
        o->mass[g] = mass;
        o->mobility[g] = o->leaders[g] < r->bodies ? 1 / mass : 0.0;
    }
}

/* Coefficient n + 1 of s w without the term of the speed that is not known yet. */
INLINE Real pull(const Rotors *o, int i, int n)
{
    const Real *s = series_along(o->sine, i), *w = series_along(o->speed, i);
    if (n == 0)
        return s[1] * w[0];
    return middle(s + 1, BACK(w, n), n - 1) + (s[1] * w[n] + s[n + 1] * w[0]);
}

/* Of a rotor the sums of products, as `middle` has them, of cosines and speeds, sines and speeds, sines and accelerations. */
typedef struct {
    Real cosines, sines, backs;
} Sums;

/* Those three side by side: number i of c and w, of s and w, and of s and a, from i = 1 to last. */
INLINE Sums sums_of(const Real *c, const Real *s, const Real *w, const Real *a, int last)
{
    Pair cosines = twice(0.0), sines = cosines, backs = cosines;
    Sums odd;
    int i;
    for (i = 1; i < last; i += 2) {
        const Pair speeds = load_pair(w + i), of_sine = load_pair(s + i);
        cosines = add_product(cosines, load_pair(c + i), speeds);
        sines = add_product(sines, of_sine, speeds);
        backs = add_product(backs, of_sine, load_pair(a + i));
    }
    odd.cosines = first_of_pair(cosines);
    odd.sines = first_of_pair(sines);
    odd.backs = first_of_pair(backs);
    if (i == last) {
        odd.cosines = odd.cosines + c[i] * w[i];
        odd.sines = odd.sines + s[i] * w[i];
        odd.backs = odd.backs + s[i] * a[i];
    }
    odd.cosines = odd.cosines + second_of_pair(cosines);
    odd.sines = odd.sines + second_of_pair(sines);
    odd.backs = odd.backs + second_of_pair(backs);
    return odd;
}

/* Coefficient n + 1 of sine and cosine, and the pull; returns coefficient n of s a, a the acceleration of the group, without the term of
 * the one that is not known yet.
 */
INLINE Real rotate(const Taylor *f, Rotors *o, int i, int n, int group)
{
    Real *s = series_along(o->sine, i), *c = series_along(o->cosine, i), *w = series_along(o->speed, i);
    const Real *a = series_along(o->acceleration, group), speed = speed_of(f, &o->of[i], n), inverse = f->inverse[n + 1];
    put(w, n, speed);
    if (n == 0) {
        s[1] = c[0] * speed * inverse;
        c[1] = -((o->pulled[i] + s[0] * speed) * inverse);
        o->pulled[i] = s[1] * speed;
        return 0.0;
    } else {
        const Sums sums = sums_of(c, s + 1, BACK(w, n), BACK(a, n - 1), n - 1);
        const Real sine = (sums.cosines + (c[0] * speed + c[n] * w[0])) * inverse;
        c[n + 1] = -((o->pulled[i] + s[0] * speed) * inverse);
        s[n + 1] = sine;
        o->pulled[i] = sums.sines + (s[1] * speed + sine * w[0]);
        return sums.backs + s[1] * a[n - 1];
    }
}

/* Acceleration of order n of the group number g under the force F, and of its rotors. Of a group that does not move on its own the
 * acceleration is that of ground or base.
 */
INLINE void turn_group(Run *r, int g, int n, const Real *F)
{
    const Taylor *f = &r->taylor;
    const Mode *m = r->mode;
    Rotors *o = &r->rotors;
    Real *acceleration = f->acceleration, force = 0.0, a;
    int leader = o->leaders[g], i;
    if (leader < r->bodies)
        force = F[leader];
    for (i = 0; i < o->count; i++) {
        const RotorOn *one = &o->of[i];
        if (m->leader[one->on] != leader)
            continue;
        o->torque[i] = F[one->column] + one->unbalance * rotate(f, o, i, n, g);
        force = force + (one->unbalance * (n + 1) * o->pulled[i] + o->lean[i] * o->torque[i]);
    }
    if (leader < r->bodies)
        a = force * o->mobility[g];
    else
        a = leader > r->bodies ? (n + 1) * f->table[(n + 1) * f->stride + f->rates + base_column(r)] : 0.0;
    acceleration[leader] = a;
    put(series_along(o->acceleration, g), n, a);
    for (i = 0; i < o->count; i++) {
        const RotorOn *one = &o->of[i];
        if (m->leader[one->on] == leader)
            acceleration[one->column] = o->torque[i] * one->lightness + o->lean[i] * a;
    }
}

/* Accelerations of order n of rotors and of the groups that they are on, under the forces and torques r->force. */
WIDE void rotors_turn(Run *r, int n)
{
    const Rotors *o = &r->rotors;
    int g;
    for (g = 0; g < o->groups; g++)
        turn_group(r, g, n, r->force);
}

/* Add the series of the force of the rotors on a column. */
void rotors_thrust(const Run *r, int column, Real *out)
{
    const Taylor *f = &r->taylor;
    const Rotors *o = &r->rotors;
    int i, n;
    Series total;
    for (n = 0; n < f->order; n++)
        total[n] = 0.0;
    for (i = 0; i < o->count; i++) {
        const RotorOn *one = &o->of[i];
        if (one->on != column)
            continue;
        for (n = 0; n < f->order; n++) {
            Real last = pull(o, i, n) + *series_along(o->sine, i) * speed_of(f, one, n + 1);
            total[n] = total[n] + one->unbalance * ((n + 1) * last);
        }
    }
    for (n = 0; n < f->order; n++)
        out[n] = out[n] + total[n];
}
