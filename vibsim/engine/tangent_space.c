/* The disturbances that a mode allows, and those that it does not; twin of vibsim/engine/tangent_space.py. */
#include <string.h>

#include "tangent.h"

static double *next_candidate(Tangent *b, int count)
{
    double *vector = b->candidates + count * b->size;
    memset(vector, 0, sizeof(double) * (size_t)b->size);
    return vector;
}

static int bodies_of(const Run *r, const Mode *m, int leader)
{
    int count = 0, c;
    for (c = 0; c < r->bodies; c++)
        count += m->leader[c] == leader;
    return count;
}

/* Vectors that span the tangent space of a mode, one behind the other in b->candidates; returns their number. */
int space_inside(const Run *r, const Mode *m)
{
    Tangent *b = r->tangent;
    int n = r->bodies, count = 0, i, c, leader;
    for (i = 0; i < b->component_count; i++)
        if (b->components[i] < n || b->components[i] >= 2 * n)
            next_candidate(b, count++)[b->components[i]] = 1.0;
    for (leader = 0; leader < n; leader++) {
        double *vector;
        if (m->leader[leader] != leader)
            continue;
        vector = next_candidate(b, count++);
        for (c = 0; c < n; c++)
            if (m->leader[c] == leader)
                vector[n + c] = 1.0;
    }
    return count;
}

/* Vectors that span the rest. */
int space_outside(const Run *r, const Mode *m)
{
    Tangent *b = r->tangent;
    int n = r->bodies, count = 0, leader, c, d;
    for (leader = 0; leader < r->columns; leader++) {
        double share = leader < n ? 1.0 / bodies_of(r, m, leader) : 0.0;
        for (c = 0; c < n; c++) {
            double *vector;
            if (m->leader[c] != leader || c == leader) /* the first body of a group that moves leads it */
                continue;
            vector = next_candidate(b, count++);
            for (d = 0; d < n; d++)
                if (m->leader[d] == leader)
                    vector[n + d] = (d == c ? 1.0 : 0.0) - share;
        }
    }
    return count;
}

/* Take out the shifts that no force feels: dx is measured from its reference. */
void gauge_apply(Tangent *b)
{
    int s, i;
    for (s = 0; s < b->shift_count; s++) {
        double *shifted = b->vectors + b->shift_from[s] * b->stride;
        const double *reference = b->vectors + b->shift_to[s] * b->stride;
        for (i = 0; i < b->possible; i++)
            shifted[i] = shifted[i] - reference[i];
    }
    for (s = 0; s < b->reference_count; s++)
        for (i = 0; i < b->possible; i++)
            b->vectors[b->references[s] * b->stride + i] = 0.0;
}
