/* Disturbances inside a mode of the closed-form flow; twin of vibsim/flows/closed_form_tangent.py. */
#include "kernel.h"

#define E_FOLDS 8

static const Oscillator *oscillator_of(const ClosedForm *f)
{
    return &f->regimes[f->regime[0]][f->regime[1]][f->regime[2]].oscillator;
}

double closed_form_tangent_piece_end(const Run *r, double t, double end, double mark)
{
    const Oscillator *o = oscillator_of(&r->closed);
    double decay = o->oscillates ? o->a : o->a + o->wd;
    double ahead = decay > 0 ? t + E_FOLDS / decay : end;
    ahead = t < mark && mark < ahead ? mark : ahead;
    return t < ahead && ahead < end ? ahead : end;
}

double closed_form_tangent_move(Run *r, double t, double end)
{
    Tangent *b = &r->tangent;
    const ClosedForm *f = &r->closed;
    const Oscillator *o = oscillator_of(f);
    double release, impulse, rate, stiff;
    int i;
    release_and_impulse(o, end - t, &release, &impulse);
    rate = release - 2 * o->a * impulse;
    stiff = o->b * impulse;
    for (i = 0; i < b->count; i++) {
        double *v = b->vectors[i], du = f->locked ? v[DV1] : v[DV1] - v[DV2];
        double y = v[DY] * release + du * impulse, u = du * rate - v[DY] * stiff;
        v[DY] = y;
        if (f->locked) {
            v[DV1] = u;
        } else {
            double V = f->share2 * v[DV1] + f->share1 * v[DV2];
            v[DV1] = V + f->share1 * u;
            v[DV2] = V - f->share2 * u;
        }
    }
    return -(2 * o->a * (end - t));
}
