/* How far one expansion of disturbances reaches along a step of the Taylor flow: rates of the mode are bounded by the largest sum
 * over a row of stiffness and of damping (Gershgorin).
 */
#include "tangent.h"

#define REACH 1.25 /* how much further than exp(-t) of the same order the steps of ordinary vibrations go, at most */

/* Bound of the largest eigenvalue of stiffness (stiff) or damping of the couplings' differences. */
static Real fastest(const Run *r, int stiff)
{
    const Mode *m = r->mode;
    Real *strength = r->tangent->force, largest = 0.0;
    int i;
    for (i = 0; i < r->columns; i++)
        strength[i] = 0.0;
    for (i = 0; i < m->coupling_count; i++) {
        const Coupling *q = &m->couplings[i];
        Real value = stiff ? q->k : q->c;
        if (q->to_P == q->to_Q)
            continue;
        strength[q->to_P] = strength[q->to_P] + value;
        strength[q->to_Q] = strength[q->to_Q] + value;
    }
    for (i = 0; i < m->coupling_count; i++) {
        const Coupling *q = &m->couplings[i];
        if (q->to_P != q->to_Q && (stiff ? q->k : q->c) > 0) {
            Real row = strength[q->to_P] * m->mobility[q->to_P] + strength[q->to_Q] * m->mobility[q->to_Q];
            largest = row > largest ? row : largest;
        }
    }
    return largest;
}

/* Rate at which the motor's drag damps the rotor, at most. */
static Real dragging(const Run *r)
{
    Real mass;
    if (r->mode->carried == 0)
        return r->drag / r->inertia;
    mass = r->mode->carried + r->m3;
    return r->drag * mass / (mass * r->inertia - r->unbalance * r->unbalance);
}

/* Whether disturbances feel nothing but means over the stretch tau. */
static int meets(Run *r, const Zeros *zeros, Real t, Real tau)
{
    Real stiff, damping;
    if (!formula_take_means(r, zeros, t, tau))
        return 0;
    formula_rates(r, 0.0, &stiff, &damping);
    return stiff * tau * tau <= LEFT_OUT && damping * tau * (tau * r->tangent->tangencies.rate) <= LEFT_OUT;
}

/* End of a piece from t at whose start or end the base of a power is zero, and over which the derivatives have means; t where
 * there is none. Where a derivative is infinite at the start and has no integral, the whole stretch: nothing is known behind it.
 * steep: whether one is infinite at `end`, of which the piece is too long for means.
 */
static Real piece_at_zero(Run *r, Real t, Real end, int *steep)
{
    const Real last = end, shortest = (end - t) * LEAST_SHARE;
    int mild = 1;
    while (end - t > shortest) {
        Zeros zeros = formula_zeros(r, t, end);
        if (zeros.count == 0)
            return t;
        if (meets(r, &zeros, t, end - t))
            return end;
        if (!zeros.opening) {
            *steep = !zeros.mild;
            return t;
        }
        mild = zeros.mild;
        end = t + (end - t) / 4;
    }
    return mild ? t : last;
}

/* End of the piece from t that is moved at once: as a rule the whole step. Rates of the mode limit it, of stiffness, of damping,
 * of the motor's drag and its speed, and derivatives of formulas that its series do not reach.
 */
Real taylor_piece_end(Run *r, Real t, Real end)
{
    Real rates[4], rate, ahead;
    int count = 2, steep = 0, i;
    if (r->mode->formula_slopes.known) {
        ahead = piece_at_zero(r, t, end, &steep);
        if (t < ahead)
            return ahead;
    }
    rates[0] = sqrt(fastest(r, 1)) / REACH;
    rates[1] = fastest(r, 0);
    if (r->mode->formula_slopes.known) {
        Real tau = formula_sound_stretch(r, t, end - t), sound = tau < end - t ? t + tau : end, stiffness, damping;
        if (steep && !(sound < end)) /* the series would do but for the infinite derivative at its end: a shorter rest has means */
            sound = end - (end - t) / 4;
        end = t < sound ? sound : end;
        formula_rates(r, tau, &stiffness, &damping);
        rates[0] = rates[0] + sqrt(stiffness) / REACH;
        rates[1] = rates[1] + damping;
    }
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
