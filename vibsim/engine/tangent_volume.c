/* How a volume of disturbances grows within a mode; twin of vibsim/engine/tangent_volume.py. */
#include "gauss_nodes.h"
#include "numbers.h"
#include "tangent.h"

/* The rotor's angle a time tau after the expansion point, within one turn. */
static double phase_after(const Run *r, double tau)
{
    const Taylor *f = &r->taylor;
    double turns;
    return reduce_angle(horner_in_rows(f->table + r->bodies, f->order + 2, f->stride, tau), &turns);
}

/* det M = (m + m3)(J + m3 e^2) - (m3 e sin phi)^2. */
static double determinant(const Run *r, double mass, double inertia, double tau)
{
    double coupling = r->m3 * r->e * sin(phase_after(r, tau));
    return mass * inertia - coupling * coupling;
}

static double with_rotor(const Run *r, double mass, double inertia, double damping, double drag, double t, double tau)
{
    double share = 0.0, damped, start = t - r->t0;
    int i;
    for (i = 0; i < NODE_COUNT; i++)
        share = share + WEIGHTS[i] / determinant(r, mass, inertia, start + NODES[i] * tau);
    damped = (damping * inertia + drag * mass) * (tau * share);
    return -damped - log(determinant(r, mass, inertia, start + tau) / determinant(r, mass, inertia, start));
}

/* Logarithm of the growth from t to `end`, within the stretch in hand, of a volume that fills the tangent space. */
double log_volume(const Run *r, double t, double end)
{
    const Mode *m = r->mode;
    const int on = r->has_motor ? m->leader[r->motor_on] : -1;
    double rate = 0.0, damping = 0.0, tau = end - t, fixed, drag, inertia;
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
    if (!r->has_motor)
        return fixed;
    drag = r->M0 / r->Omega0;
    inertia = r->J + r->m3 * r->e * r->e;
    if (m->carried == 0)
        return fixed - drag / inertia * tau;
    return fixed + with_rotor(r, m->group_mass[on] + r->m3, inertia, damping, drag, t, tau);
}
