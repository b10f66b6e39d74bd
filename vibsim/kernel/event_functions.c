/* Event functions of the closed-form flow; twin of vibsim/flows/event_functions.py. */
#include "kernel.h"

static double force_derivative(const Run *r, const double *d, int n)
{
    const Regime *g = regime_of(&r->closed);
    double force = g->k * d[n] + r->scene.c * d[n + 1];
    return n == 0 ? force + g->offset : force;
}

double event_derivative(const Run *r, int function, const double *d, int n)
{
    const Scene *s = &r->scene;
    const ClosedForm *f = &r->closed;
    double value;
    if (function == GAP) {
        value = -(s->stop_sign * d[n]);
        value = n == 0 ? value - s->G : value;
        return r->mode.contact ? value : -value;
    }
    if (function == CLEARANCE) {
        value = n == 0 ? s->rest_distance - d[0] : -d[n];
        return r->mode.violated ? -value : value;
    }
    if (function == SLIDE) {
        if (n == 0)
            return r->mode.friction * (f->V - f->share2 * f->u);
        value = force_derivative(r, d, n - 1);
        value = n == 1 ? value - r->mode.friction * f->limit : value;
        return r->mode.friction * value / s->m2;
    }
    value = force_derivative(r, d, n);
    value = function == HOLD_PLUS ? -value : value;
    return n == 0 ? f->limit + value : value;
}

/* Bound of |y^(n)| up to `reach` ahead. */
static double bound_of_y(const ClosedForm *f, const double *d, int n, double reach)
{
    const Regime *g = regime_of(f);
    double w0 = g->oscillator.w0, size = fabs(d[n]) + fabs(d[n + 1]) * reach;
    if (w0 > 0) {
        double energy = fabs(d[n]) + fabs(d[n + 1]) / w0;
        if (energy < size)
            size = energy;
    }
    return size + g->forced[n] * (reach * reach);
}

double event_bound(const Run *r, int function, const double *d, int n, double reach)
{
    const ClosedForm *f = &r->closed;
    double k = regime_of(f)->k, c = r->scene.c;
    if (function == GAP || function == CLEARANCE)
        return bound_of_y(f, d, n, reach);
    if (function == SLIDE)
        return (k * bound_of_y(f, d, n - 1, reach) + c * bound_of_y(f, d, n, reach)) / r->scene.m2;
    return k * bound_of_y(f, d, n, reach) + c * bound_of_y(f, d, n + 1, reach);
}

double event_noise(const Run *r, int function)
{
    const Scene *s = &r->scene;
    const ClosedForm *f = &r->closed;
    const Regime *g = regime_of(f);
    double unit = EPS * (16 + g->oscillator.w0 * f->tau);
    if (function == GAP)
        return unit * (f->scale_y + fabs(s->G));
    if (function == CLEARANCE)
        return unit * (f->scale_y + fabs(s->rest_distance));
    if (function == SLIDE)
        return unit * (f->scale_V + f->share2 * f->scale_u);
    return unit * (g->k * f->scale_y + s->c * f->scale_u + fabs(g->offset) + f->limit);
}
