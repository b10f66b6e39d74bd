/* The disturbances that a mode allows, and those that it does not; vibsim/engine/tangent/tangent_space.py says which these are. */
#include <string.h>

#include "tangent.h"

/* Room for a vector of zeros behind `count` candidates. */
static Real *next_candidate(Tangent *b, int count)
{
    Real *vector = b->candidates + count * b->size;
    memset(vector, 0, sizeof(Real) * (size_t)b->size);
    return vector;
}

static int bodies_of(const Run *r, const Mode *m, int leader)
{
    int count = 0, c;
    for (c = 0; c < r->bodies; c++)
        count += m->leader[c] == leader;
    return count;
}

/* Ground and base before bodies. */
static int before(const Run *r, int one, int other)
{
    return one >= r->bodies && other >= r->bodies ? one < other : one >= r->bodies || (other < r->bodies && one < other);
}

/* b->seat: by column, the one that leads the group which rigid stops at rest join. */
void seats_of(const Run *r, const Mode *m)
{
    const Tangent *b = r->tangent;
    int c, i, moved = 1;
    for (c = 0; c < r->columns; c++)
        b->seat[c] = c;
    while (moved)
        for (i = moved = 0; i < b->stop_count; i++) {
            int *P = &b->seat[b->stops[i].P], *Q = &b->seat[b->stops[i].Q], first = before(r, *P, *Q) ? *P : *Q;
            if (m->codes[i] == AT_REST && *P != *Q) {
                *P = *Q = first;
                moved = 1;
            }
        }
}

/* Whether the same rigid stops rest in two modes. */
int same_seats(const Run *r, const Mode *one, const Mode *other)
{
    int i;
    for (i = 0; i < r->tangent->stop_count; i++)
        if ((one->codes[i] == AT_REST) != (other->codes[i] == AT_REST))
            return 0;
    return 1;
}

static int is_reference(const Tangent *b, int c)
{
    int i;
    for (i = 0; i < b->reference_count; i++)
        if (b->references[i] == c)
            return 1;
    return 0;
}

/* Number of bodies of a seat, 0 where these are held: by ground, base or a reference among them. */
static int moving_seat(const Run *r, int leader)
{
    const Tangent *b = r->tangent;
    int count = 0, c;
    for (c = 0; c < r->bodies; c++)
        if (b->seat[c] == leader) {
            if (is_reference(b, c))
                return 0;
            count++;
        }
    return leader < r->bodies ? count : 0;
}

/* Number of the directions that the ties of a mode hold. */
int space_held(const Run *r, const Mode *m)
{
    const Tangent *b = r->tangent;
    int count = 0, c;
    seats_of(r, m);
    for (c = 0; c < r->bodies; c++) {
        count += m->leader[c] != c;
        if (moving_seat(r, b->seat[c]))
            count += b->seat[c] != c;
        else
            count += !is_reference(b, c);
    }
    return count;
}

/* Vectors that span the tangent space of a mode, one behind the other in b->candidates; returns their number. */
int space_inside(const Run *r, const Mode *m)
{
    Tangent *b = r->tangent;
    int n = r->bodies, count = 0, i, c, leader;
    seats_of(r, m);
    for (leader = 0; leader < n; leader++) {
        Real *vector;
        if (!moving_seat(r, leader))
            continue;
        vector = next_candidate(b, count++);
        for (c = 0; c < n; c++)
            if (b->seat[c] == leader)
                vector[c] = 1.0;
    }
    for (i = 0; i < b->component_count; i++)
        if (b->components[i] >= 2 * n)
            next_candidate(b, count++)[b->components[i]] = 1.0;
    for (leader = 0; leader < n; leader++) {
        Real *vector;
        if (m->leader[leader] != leader)
            continue;
        vector = next_candidate(b, count++);
        for (c = 0; c < n; c++)
            if (m->leader[c] == leader)
                vector[n + c] = 1.0;
    }
    return count;
}

/* Vectors orthogonal to these (where all dv weigh the same) that span the rest. */
int space_outside(const Run *r, const Mode *m)
{
    Tangent *b = r->tangent;
    int n = r->bodies, count = 0, leader, c, d;
    seats_of(r, m);
    for (leader = 0; leader < r->columns; leader++) {
        int moving = moving_seat(r, leader);
        Real share = moving ? 1.0 / moving : 0.0;
        for (c = 0; c < n; c++) {
            Real *vector;
            if (b->seat[c] != leader || (moving ? c == leader : is_reference(b, c)))
                continue;
            vector = next_candidate(b, count++);
            for (d = 0; d < n; d++)
                if (b->seat[d] == leader)
                    vector[d] = (d == c ? 1.0 : 0.0) - share;
        }
    }
    for (leader = 0; leader < r->columns; leader++) {
        Real share = leader < n ? 1.0 / bodies_of(r, m, leader) : 0.0;
        for (c = 0; c < n; c++) {
            Real *vector;
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
        Real *shifted = b->vectors + b->shift_from[s] * b->stride;
        const Real *reference = b->vectors + b->shift_to[s] * b->stride;
        for (i = 0; i < b->possible; i++)
            shifted[i] = shifted[i] - reference[i];
    }
    for (s = 0; s < b->reference_count; s++)
        for (i = 0; i < b->possible; i++)
            b->vectors[b->references[s] * b->stride + i] = 0.0;
}
