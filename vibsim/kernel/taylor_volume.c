/* How a volume of disturbances grows along a Taylor step; twin of vibsim/flows/taylor_volume.py. */
#include "gauss_nodes.h"
#include "kernel.h"
#include "../engine/numbers.h"

static double determinant(const Run *r, double tau)
{
    const Scene *s = &r->scene;
    const Taylor *f = &r->taylor;
    double phi[SERIES], coupling;
    int n;
    for (n = 0; n <= f->order + 1; n++)
        phi[n] = f->table[n][PHI];
    coupling = f->unbalance * sin(horner(phi, f->order + 2, tau));
    return (s->m1 + s->m3) * (s->J + f->unbalance * s->e) - coupling * coupling;
}

double taylor_log_volume(const Run *r, double tau)
{
    const Scene *s = &r->scene;
    const Taylor *f = &r->taylor;
    double rate = s->has_motor != 0 ? 0.0 : s->c * f->per_m1, fixed, share = 0, damped;
    int i;
    if (!f->locked)
        rate = rate + s->c * f->per_m2;
    fixed = -(rate * tau);
    if (s->has_motor == 0)
        return fixed;
    for (i = 0; i < NODE_COUNT; i++)
        share = share + WEIGHTS[i] / determinant(r, NODES[i] * tau);
    damped = (s->c * (s->J + f->unbalance * s->e) + s->M0 / s->Omega0 * (s->m1 + s->m3)) * (tau * share);
    return fixed - damped - log(determinant(r, tau) / determinant(r, 0.0));
}
