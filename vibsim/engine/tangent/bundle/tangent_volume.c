/* How a volume of small disturbances grows within a mode: what Liouville's theorem says, for a check.
 *
 * With momenta p = M v a volume of (x, p) changes only by forces F that depend on velocities, by exp(int tr(M^-1 dF/dv) dt); one of
 * (x, v) differs from it by det M, which depends on the angles of rotors. Off the diagonal, M^-1 joins a rotor and what it is on, and
 * rotors of one group: there a force that reads another speed of the same group counts too. The disturbances themselves are not used.
 */
#include "gauss_nodes.h"
#include "numbers.h"
#include "tangent.h"

/* b = m3 e sin phi and det M = (m + m3)(J + m3 e^2) - b^2 at the points. */
static void determinants(const Run *r, Real mass, Real inertia, const Real *tau, Real *couplings, Real *out)
{
    const Taylor *f = &r->taylor;
    Real turns, square[POINTS];
    int i;
    for (i = 0; i < POINTS; i++)
        square[i] = tau[i] * tau[i];
    series_at(f->table + r->bodies, f->order + 2, f->stride, tau, square, out, POINTS);
    for (i = 0; i < POINTS; i++) {
        couplings[i] = r->unbalance * sine_of(reduce_angle(out[i], &turns));
        out[i] = mass * inertia - couplings[i] * couplings[i];
    }
}

/* The share of the motor's group and its rotor: their damping by means of 1 / det M, and det M itself at both ends; mass, inertia,
 * damping, drag: of these two. Formulas that act on the group add the derivatives of their force by its velocity and by the speed of
 * the motor.
 */
static Real with_motor(const Run *r, Real mass, Real inertia, Real damping, Real drag, Real t, Real tau)
{
    Real share = 0.0, damped, start = t - r->t0, points[POINTS], couplings[POINTS], values[POINTS];
    int i;
    for (i = 0; i < NODE_COUNT; i++)
        points[i] = start + TWELVE.nodes[i] * tau;
    points[NODE_COUNT] = start + tau;
    points[NODE_COUNT + 1] = start;
    determinants(r, mass, inertia, points, couplings, values);
    for (i = 0; i < NODE_COUNT; i++)
        share = share + TWELVE.weights[i] / values[i];
    damped = (damping * inertia + drag * mass) * (tau * share);
    if (r->mode->formula_slopes.known) {
        Real mean = 0.0, spun = 0.0, own, spin;
        for (i = 0; i < NODE_COUNT; i++) {
            formula_divergence(r, TWELVE.nodes[i] * tau, r->mode->leader[r->motor_on], &own, &spin);
            mean = mean + TWELVE.weights[i] * (own / values[i]);
            spun = spun + TWELVE.weights[i] * (spin * couplings[i] / values[i]);
        }
        damped = damped - (inertia * (tau * mean) + tau * spun);
    }
    return -damped - logarithm(values[NODE_COUNT] / values[NODE_COUNT + 1]);
}

/* l^T (dF/dv) l, of the couplings and the formulas of the mode; l: by column; slopes: derivatives of accelerations by velocities, by
 * entry, NULL without formulas.
 */
static Real form(const Run *r, const Real *l, const Real *slopes)
{
    const Mode *m = r->mode;
    const SlopeRows *rows = &m->formula_slopes.rows[1];
    Real total = 0.0;
    int i;
    for (i = 0; i < m->coupling_count; i++) {
        const Coupling *q = &m->couplings[i];
        Real apart = l[q->to_P] - l[q->to_Q];
        total = total - q->c * (apart * apart);
    }
    for (i = 0; slopes && i < rows->entry_count; i++) {
        const SlopeEntry *e = &rows->entries[i];
        total = total + l[e->row] * l[e->column] * (slopes[i] / m->mobility[e->row]);
    }
    return total;
}

/* What the rotors on a group of mass M add to the trace a time `after` the expansion point: M^-1 is 1 / I of each rotor and
 * l l^T / mass, where l is 1 of the group and u s / I of a rotor, mass = M - sum (u s)^2 / I, in place of 1 / M of the group.
 */
static Real with_rotors_at(const Run *r, int leader, Real after, const Real *slopes, Real *mass)
{
    const Mode *m = r->mode;
    Real *l = r->tangent->force, alone, turns;
    int i;
    for (i = 0; i < r->columns; i++)
        l[i] = 0.0;
    l[leader] = 1.0;
    alone = form(r, l, slopes) * m->mobility[leader];
    *mass = m->group_mass[leader];
    taylor_values(&r->taylor, after, r->taylor.values);
    for (i = 0; i < r->rotors.count; i++) {
        const RotorOn *one = &r->rotors.of[i];
        Real coupling = one->unbalance * sine_of(reduce_angle(r->taylor.values[one->column], &turns));
        if (m->leader[one->on] != leader)
            continue;
        l[one->column] = coupling / one->inertia;
        *mass = *mass - coupling * l[one->column];
    }
    return form(r, l, slopes) / *mass - alone;
}

/* The same over the piece tau from t, with the change of det M. */
static Real with_rotors(const Run *r, int leader, Real t, Real tau)
{
    Real mean = 0.0, start = t - r->t0, mass, first;
    int i;
    for (i = 0; i < NODE_COUNT; i++) {
        const Real at = TWELVE.nodes[i] * tau, *slopes = r->mode->formula_slopes.known ? formula_damping(r, at) : NULL;
        mean = mean + TWELVE.weights[i] * with_rotors_at(r, leader, start + at, slopes, &mass);
    }
    with_rotors_at(r, leader, start, NULL, &first);
    with_rotors_at(r, leader, start + tau, NULL, &mass);
    return tau * mean - logarithm(mass / first);
}

/* Logarithm of the growth from t to `end`, within the stretch in hand, of a volume that fills the tangent space. */
Real log_volume(const Run *r, Real t, Real end)
{
    const Mode *m = r->mode;
    const int on = r->has_motor ? m->leader[r->motor_on] : -1;
    Real rate = 0.0, damping = 0.0, tau = end - t, fixed, drag, inertia;
    int i, side;
    for (i = 0; i < m->coupling_count; i++) {
        const Coupling *q = &m->couplings[i];
        for (side = 0; q->to_P != q->to_Q && side < 2; side++) {
            int column = side ? q->to_Q : q->to_P;
            if (column == on)
                damping = damping + q->c;
            else
                rate = rate + q->c * m->mobility[column];
        }
    }
    fixed = -(rate * tau);
    if (m->formula_slopes.known && !r->closed) {
        Real mean = 0.0, own, spin;
        for (i = 0; i < NODE_COUNT; i++)
            mean = mean + TWELVE.weights[i] * formula_divergence(r, TWELVE.nodes[i] * tau, on, &own, &spin);
        fixed = fixed + tau * mean;
    }
    for (i = 0; i < r->rotors.groups; i++)
        if (r->rotors.leaders[i] < r->bodies)
            fixed = fixed + with_rotors(r, r->rotors.leaders[i], t, tau);
    if (!r->has_motor)
        return fixed;
    drag = r->drag;
    inertia = r->inertia;
    if (m->carried == 0)
        return fixed - drag / inertia * tau;
    return fixed + with_motor(r, m->group_mass[on] + r->m3, inertia, damping, drag, t, tau);
}
