/* Gauss-Legendre quadrature on [0, 1]: n nodes integrate polynomials of degree 2 n - 1 exactly. Series at its nodes. */
#ifndef VIBSIM_ENGINE_GAUSS_NODES_H
#define VIBSIM_ENGINE_GAUSS_NODES_H

#include "engine.h"
#include "inlining.h"

#define POINTS (NODE_COUNT + 2) /* the nodes, then end and start */

typedef struct {
    int count;
    Real nodes[NODE_COUNT], weights[NODE_COUNT];
} Quadrature;

static const Quadrature TWELVE = {
    NODE_COUNT,
    {
        0.009219682876640375, 0.04794137181476257, 0.11504866290284765, 0.2063410228566913,
        0.3160842505009099, 0.43738329574426554, 0.5626167042557345, 0.6839157494990901, 0.7936589771433087,
        0.8849513370971523, 0.9520586281852375, 0.9907803171233597,
    },
    {
        0.023587668193255914, 0.05346966299765921, 0.08003916427167311, 0.10158371336153296,
        0.1167462682691774, 0.12457352290670139, 0.12457352290670139, 0.1167462682691774,
        0.10158371336153296, 0.08003916427167311, 0.05346966299765921, 0.023587668193255914,
    },
};

static const Quadrature EIGHT = {
    FEW_NODES,
    {
        0.019855071751231884, 0.10166676129318664, 0.2372337950418355, 0.4082826787521751,
        0.591717321247825, 0.7627662049581645, 0.8983332387068134, 0.9801449282487681,
    },
    {
        0.05061426814518813, 0.11119051722668721, 0.15685332293894363, 0.181341891689181,
        0.181341891689181, 0.15685332293894363, 0.11119051722668721, 0.05061426814518813,
    },
};

/* A series of `count` coefficients `stride` apart at `points` times: `horner` time by time, side by side. */
INLINE void series_at(const Real *c, int count, int stride, const Real *tau, const Real *square, Real *out, const int points)
{
    Real high[POINTS], low[POINTS];
    int n, i;
    for (i = 0; i < points; i++) {
        high[i] = c[(count - 1) * stride];
        low[i] = c[(count - 2) * stride];
    }
    for (n = count - 3; n > 0; n -= 2) {
        Real a = c[n * stride], b = c[(n - 1) * stride];
        for (i = 0; i < points; i++)
            high[i] = high[i] * square[i] + a;
        for (i = 0; i < points; i++)
            low[i] = low[i] * square[i] + b;
    }
    for (i = 0; i < points; i++)
        out[i] = count % 2 == 0 ? low[i] + tau[i] * high[i] : (high[i] * square[i] + c[0]) + tau[i] * low[i];
}

#endif
