/* Constants of the smooth modes of the ideal source; twin of vibsim/flows/regime.py. */
#include "kernel.h"
#include "../engine/numbers.h"

static void regime_set(Regime *g, const Scene *s, int locked, int contact, int friction)
{
    double inverse = locked ? 1 / s->m1 : 1 / s->m1 + 1 / s->m2;
    double stiffness = contact ? s->k1 + s->k2 : s->k1;
    double offset = contact ? s->k2 * (s->stop_sign * s->G) : 0.0;
    int harmonic = s->harmonic != 0, n;
    g->k = stiffness;
    g->offset = offset;
    oscillator_set(&g->oscillator, s->c * inverse / 2, stiffness * inverse, harmonic ? s->omega : 0.0);
    g->load = -(offset * inverse);
    if (harmonic)
        g->load = g->load + s->F0 / s->m1;
    g->amplitude = harmonic ? s->A / s->m1 : 0.0;
    g->forced[0] = fabs(g->amplitude) / 2;
    for (n = 0; n < JET_ORDER; n++)
        g->forced[n + 1] = g->forced[n] * g->oscillator.omega;
    g->centre_load = g->centre_amplitude = 0.0;
    if (!locked) {
        double total = s->m1 + s->m2, rub = s->has_friction != 0 ? friction * s->N : 0.0;
        g->load = g->load + rub / s->m2;
        g->centre_load = ((harmonic ? s->F0 : 0.0) - rub) / total;
        g->centre_amplitude = harmonic ? s->A / total : 0.0;
    }
}

void closed_form_set(Run *r)
{
    const Scene *s = &r->scene;
    ClosedForm *f = &r->closed;
    int locked, contact, friction;
    f->settled = power_of_two(binary_exponent(EPS) / 3.0);
    f->limit = s->has_friction != 0 ? s->N : 0.0;
    f->driven = s->harmonic != 0 && s->A != 0;
    f->omega = f->driven ? s->omega : 0.0;
    oscillator_set(&f->mass_point, 0.0, 0.0, f->omega);
    f->share1 = s->has_block2 != 0 ? s->m2 / (s->m1 + s->m2) : 0.0;
    f->share2 = s->has_block2 != 0 ? s->m1 / (s->m1 + s->m2) : 0.0;
    for (locked = 0; locked < 2; locked++)
        for (contact = 0; contact < 2; contact++)
            for (friction = -1; friction < 2; friction++)
                if ((locked || s->has_block2 != 0) && (!contact || s->has_stop != 0))
                    regime_set(&f->regimes[locked][contact][friction + 1], s, locked, contact, friction);
}
