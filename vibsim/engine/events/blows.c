/* A blow on one rigid stop alone; twin of that case of vibsim/engine/events/rigid_stops.py and newton_moreau.py.
 *
 * Whatever is not clear is left to Python: another rigid stop near, an approach or a departure that rounding or the
 * resolution of time could tell otherwise.
 */
#include <stdlib.h>

#include "modes.h"

#define NEAR 64  /* units in the last place of time or displacements: beyond what Python asks for */
#define LASTING 32 /* units of time before the next blow, in the same way */
#define ROUNDING 8

/* The numbers in which vibsim/engine/ledgers/packing_meters.py writes them; 0 without memory or where they are none. */
int blows_read(Run *r, Reader *in)
{
    int count = read_index(in, 0, r->parts), i;
    free(r->rigid);
    r->rigid_count = 0;
    r->rigid = calloc((size_t)count + 1, sizeof(RigidStop));
    if (!r->rigid)
        return 0;
    for (i = 0; i < count; i++) {
        RigidStop *s = &r->rigid[i];
        s->stop = read_index(in, 0, r->parts - 1);
        s->P = read_index(in, 0, r->columns - 1);
        s->Q = read_index(in, 0, r->columns - 1);
        s->sense = read_index(in, -1, 1);
        s->loss = read_index(in, -1, r->ledger.count - 1);
        s->work = read_index(in, -1, r->ledger.count - 1);
        s->impulse = read_index(in, -1, r->ledger.count - 1);
        s->gap = read_double(in);
        s->e = read_double(in);
    }
    r->rigid_count = count;
    return read_through(in);
}

static const RigidStop *stop_of(const Run *r, int number)
{
    int i;
    for (i = 0; i < r->rigid_count; i++)
        if (r->rigid[i].stop == number)
            return &r->rigid[i];
    return NULL;
}

static double column(const Run *r, const double *values, int c, double base)
{
    return c < r->bodies ? values[c] : c == r->bodies ? 0.0 : base;
}

/* Rate of the depth of a stop; 0 where rounding cannot tell it from that. */
static double rate_of(const Run *r, const RigidStop *s, double V)
{
    double P = column(r, r->next.v, s->P, V), Q = column(r, r->next.v, s->Q, V);
    double rate = -(s->sense * (P - Q)), noise = ROUNDING * EPS * (fabs(P) + fabs(Q));
    return fabs(rate) > noise ? rate : 0.0;
}

static double depth_of(const Run *r, const RigidStop *s, double X)
{
    return -(s->sense * (column(r, r->next.x, s->P, X) - column(r, r->next.x, s->Q, X))) - s->gap;
}

static double size_of(const Run *r, const RigidStop *s, double X)
{
    return fabs(column(r, r->next.x, s->P, X)) + fabs(column(r, r->next.x, s->Q, X)) + fabs(s->gap);
}

/* Whether a stop is open by so much that it takes no part in what happens to `struck` at r->next, whose seating
 * may have moved a body that they share.
 */
static int stands_off(
    const Run *r, const RigidStop *s, const RigidStop *struck, double X, double V, double unit)
{
    double size = fmax(size_of(r, s, X), size_of(r, struck, X));
    double rate = -(s->sense * (column(r, r->next.v, s->P, V) - column(r, r->next.v, s->Q, V)));
    return -depth_of(r, s, X) > NEAR * (fabs(rate) * unit + EPS * size);
}

/* Move the ends onto each other: what rounding left of the depth, shared as their masses say. */
static void seat(Run *r, const RigidStop *s, double X)
{
    double depth = depth_of(r, s, X), distance = s->sense * depth, P = 1.0, Q = 1.0;
    if (depth == 0)
        return;
    if (s->P < r->bodies && s->Q < r->bodies) {
        double own = r->masses[s->P], other = r->masses[s->Q];
        P = other / (own + other);
        Q = own / (own + other);
    }
    if (s->P < r->bodies)
        r->next.x[s->P] = r->next.x[s->P] + P * distance;
    if (s->Q < r->bodies)
        r->next.x[s->Q] = r->next.x[s->Q] + -(Q * distance);
}

/* Take the blow of the pending event at r->next; 0 where Python has to decide, and nothing is changed then. */
int blow_take(Run *r, const Event *event, Blow *done)
{
    const RigidStop *s = stop_of(r, event->part);
    double unit, X, V, between, own, other, together, vP, vQ, afterP, afterQ, speed, drive;
    int i;
    if (s == NULL || s->e == 0)
        return 0;
    base_motion_at(r, r->next.t, &X, &V);
    unit = nextafter(r->next.t, INFINITY) - r->next.t;
    done->before = rate_of(r, s, V);
    if (!(done->before > 0))
        return 0;
    for (i = 0; i < r->rigid_count; i++)
        if (&r->rigid[i] != s && !stands_off(r, &r->rigid[i], s, X, V, unit))
            return 0;
    drive = drive_at_next(r, event);
    speed = s->e * done->before;
    if (!isfinite(drive) || !(2 * speed > drive * (LASTING * unit)))
        return 0;
    own = s->P < r->bodies ? 1 / r->masses[s->P] : 0.0;
    other = s->Q < r->bodies ? 1 / r->masses[s->Q] : 0.0;
    vP = afterP = column(r, r->next.v, s->P, V);
    vQ = afterQ = column(r, r->next.v, s->Q, V);
    between = vP - vQ;
    together = own + other;
    if (other == 0) {
        afterP = vQ - s->e * between;
    } else if (own == 0) {
        afterQ = vP + s->e * between;
    } else {
        double common = (other * vP + own * vQ) / together;
        afterP = common - s->e * (own / together * between);
        afterQ = common + s->e * (other / together * between);
    }
    if (s->P < r->bodies)
        r->next.v[s->P] = afterP;
    if (s->Q < r->bodies)
        r->next.v[s->Q] = afterQ;
    done->stop = s;
    done->after = -(s->e * done->before);
    done->impulse = (1 + s->e) * done->before / together;
    done->V = V;
    seat(r, s, X);
    return 1;
}

/* What a blow adds to the ledgers: loss, work and impulses of ground and base. */
void blow_count(Run *r, const Blow *done)
{
    const RigidStop *s = done->stop;
    double *entries = r->ledger.entries, impulse = s->Q >= r->bodies ? s->sense * done->impulse : -s->sense * done->impulse;
    if (s->loss >= 0)
        entries[s->loss] = entries[s->loss] + done->impulse * (done->before + done->after) / 2;
    if (s->work >= 0)
        entries[s->work] = entries[s->work] + done->V * impulse;
    if (s->impulse >= 0)
        entries[s->impulse] = entries[s->impulse] + impulse;
}
