/* Displacements and velocities by column: those of the bodies, of the ground, which rests, and of the base. */
#ifndef VIBSIM_COLUMNS_H
#define VIBSIM_COLUMNS_H

#include "engine.h"

/* values: of the bodies; base: that of the base. */
static inline Real column_value(const Run *r, const Real *values, int column, Real base)
{
    return column < r->bodies ? values[column] : column == r->bodies ? 0.0 : base;
}

/* Force of a coupling [N]; x, v: of the bodies; X, V: of the base. */
static inline Real force_of_coupling(const Run *r, const Coupling *c, const Real *x, const Real *v, Real X, Real V)
{
    Real y = column_value(r, x, c->P, X) - column_value(r, x, c->Q, X);
    Real u = column_value(r, v, c->P, V) - column_value(r, v, c->Q, V);
    return c->k * y + c->c * u + c->offset;
}

#endif
