/* How a volume of small disturbances grows within a mode: what Liouville's theorem says, for a check.
 *
 * With momenta p = M v only damping changes a volume of (x, p), by exp(-int tr(C M^-1) dt); one of (x, v) differs from it by det M,
 * which depends on the angle of a rotor. The disturbances themselves are not used.
 */
#include "gauss_nodes.h"
#include "numbers.h"
#include "tangent.h"

#define POINTS (NODE_COUNT + 2) /* the nodes, then end and start */

/* The rotor's angle at times after the expansion point: `horner` point by point, side by side. */
static void angles(const Run *r, const Real *tau, Real *out)
{
    const Taylor *f = &r->taylor;
    const Real *c = f->table + r->bodies;
    Real square[POINTS], high[POINTS], low[POINTS];
    int count = f->order + 2, n, i;
    for (i = 0; i < POINTS; i++) {
        square[i] = tau[i] * tau[i];
        high[i] = c[(count - 1) * f->stride];
        low[i] = c[(count - 2) * f->stride];
    }
    for (n = count - 3; n > 0; n -= 2) {
        Real a = c[n * f->stride], b = c[(n - 1) * f->stride];
        for (i = 0; i < POINTS; i++)
            high[i] = high[i] * square[i] + a;
        for (i = 0; i < POINTS; i++)
            low[i] = low[i] * square[i] + b;
    }
    for (i = 0; i < POINTS; i++)
        out[i] = count % 2 == 0 ? low[i] + tau[i] * high[i] : (high[i] * square[i] + c[0]) + tau[i] * low[i];
}

/* det M = (m + m3)(J + m3 e^2) - (m3 e sin phi)^2 at the points. */
static void determinants(const Run *r, Real mass, Real inertia, const Real *tau, Real *out)
{
    Real turns;
    int i;
    angles(r, tau, out);
    for (i = 0; i < POINTS; i++) {
        Real coupling = r->unbalance * sine_of(reduce_angle(out[i], &turns));
        out[i] = mass * inertia - coupling * coupling;
    }
}

/* The share of the motor's group and its rotor: their damping by means of 1 / det M, and det M itself at both ends; mass, inertia,
 * damping, drag: of these two. Formulas that act on the group add the derivative of their force by its velocity.
 */
static Real with_rotor(const Run *r, Real mass, Real inertia, Real damping, Real drag, Real t, Real tau)
{
    Real share = 0.0, damped, start = t - r->t0, points[POINTS], values[POINTS];
    int i;
    for (i = 0; i < NODE_COUNT; i++)
        points[i] = start + TWELVE.nodes[i] * tau;
    points[NODE_COUNT] = start + tau;
    points[NODE_COUNT + 1] = start;
    determinants(r, mass, inertia, points, values);
    for (i = 0; i < NODE_COUNT; i++)
        share = share + TWELVE.weights[i] / values[i];
    damped = (damping * inertia + drag * mass) * (tau * share);
    if (r->mode->formula_slopes.known) {
        Real mean = 0.0, own;
        for (i = 0; i < NODE_COUNT; i++) {
            formula_divergence(r, TWELVE.nodes[i] * tau, r->mode->leader[r->motor_on], &own);
            mean = mean + TWELVE.weights[i] * (own / values[i]);
        }
        damped = damped - inertia * (tau * mean);
    }
    return -damped - logarithm(values[NODE_COUNT] / values[NODE_COUNT + 1]);
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
        Real mean = 0.0, own;
        for (i = 0; i < NODE_COUNT; i++)
            mean = mean + TWELVE.weights[i] * formula_divergence(r, TWELVE.nodes[i] * tau, on, &own);
        fixed = fixed + tau * mean;
    }
    if (!r->has_motor)
        return fixed;
    drag = r->drag;
    inertia = r->inertia;
    if (m->carried == 0)
        return fixed - drag / inertia * tau;
    return fixed + with_rotor(r, m->group_mass[on] + r->m3, inertia, damping, drag, t, tau);
}
