/* One impact on one rigid stop: that case of what impacts.py, chatter.py and newton_moreau.py decide in vibsim/engine/events/impacts.
 *
 * Frictions of the bodies that it moves slip behind it as the velocities say; what sticks elsewhere, rests or is pressed and
 * may let go has no rule. Whatever is not clear is left to Python: another stop that touches, an approach, a departure or a
 * sliding velocity that rounding or the resolution of time could tell otherwise, a mode that has not been met.
 */
#include "columns.h"
#include "modes.h"
#include "numbers.h"

#define NEAR 64  /* units in the last place of time or displacements: beyond what Python asks for */
/* units in the last place of the time: a hop lasts NEXT at least, and LAST times 1 - e */
#define NEXT 2
#define LAST 8
#define ROUNDING 8 /* of a sum or a difference of two numbers, in units of EPS */
#define TURNING 4 /* times the speed of a hop: what slips faster does not turn round in it */
#define CANCELLED 65536 /* times EPS, of all forces: more than what their rounding leaves of an acceleration, twice */
#define LOWEST 1024 /* roundings of displacements; event functions near zero are watched to some hundred */
#define NOISE 64 /* of displacements: some times what a start and a return from rounded ones are off */
#define EARLY 0.25 /* of the speed of a hop: the one that a companion asks about is no faster */
#define FURTHEST 0x1p-10 /* of the speed of a hop: none that is slower is asked about */
#define SURELY (2.0 / 3) /* of the speed of the next hop as it is known */
#define CLEAR 2   /* times the bounds of a hop: as `drive` is not that of Python to the bit */

static const RigidStop *stop_of(const Impacts *b, int number)
{
    int i;
    for (i = 0; i < b->stop_count; i++)
        if (b->stops[i].stop == number)
            return &b->stops[i];
    return NULL;
}

/* One unit in the last place of the time. */
static Real unit_of(const Run *r)
{
    return nextafter(r->next.t, INFINITY) - r->next.t;
}

/* Rate of the depth of a stop; 0 where rounding cannot tell it from that. */
static Real rate_of(const Run *r, const RigidStop *s, Real V)
{
    Real P = column_value(r, r->next.v, s->P, V), Q = column_value(r, r->next.v, s->Q, V);
    Real rate = -(s->sense * (P - Q)), noise = ROUNDING * EPS * (fabs(P) + fabs(Q));
    return fabs(rate) > noise ? rate : 0.0;
}

static Real depth_of(const Run *r, const RigidStop *s, Real X)
{
    return -(s->sense * (column_value(r, r->next.x, s->P, X) - column_value(r, r->next.x, s->Q, X))) - s->gap;
}

static Real size_of(const Run *r, const RigidStop *s, Real X)
{
    return fabs(column_value(r, r->next.x, s->P, X)) + fabs(column_value(r, r->next.x, s->Q, X)) + fabs(s->gap);
}

/* Whether a stop is open by so much that it takes no part in what happens to `struck` at r->next, whose seating
 * may have moved a body that they share.
 */
static int stands_off(
    const Run *r, const RigidStop *s, const RigidStop *struck, Real X, Real V, Real unit)
{
    Real size = fmax(size_of(r, s, X), size_of(r, struck, X));
    Real rate = -(s->sense * (column_value(r, r->next.v, s->P, V) - column_value(r, r->next.v, s->Q, V)));
    return -depth_of(r, s, X) > NEAR * (fabs(rate) * unit + EPS * size) + fabs(depth_of(r, struck, X));
}

/* Move the ends onto each other: what rounding left of the depth, shared as their masses say. */
static void project_to_rest(Run *r, const RigidStop *s, Real X)
{
    Real depth = depth_of(r, s, X), distance = s->sense * depth, P = 1.0, Q = 1.0;
    if (depth == 0)
        return;
    if (s->P < r->bodies && s->Q < r->bodies) {
        Real own = r->masses[s->P], other = r->masses[s->Q];
        P = other / (own + other);
        Q = own / (own + other);
    }
    if (s->P < r->bodies)
        r->next.x[s->P] = r->next.x[s->P] + P * distance;
    if (s->Q < r->bodies)
        r->next.x[s->Q] = r->next.x[s->Q] + -(Q * distance);
}

/* Whether the ends of an elastic stop or a clearance may just touch where an impact moves one of them. */
static int borders(const Run *r, const Bound *b, const RigidStop *struck, Real X)
{
    Real P = column_value(r, r->next.x, b->P, X), Q = column_value(r, r->next.x, b->Q, X);
    int moved = b->P == struck->P || b->P == struck->Q || b->Q == struck->P || b->Q == struck->Q;
    return moved && fabs(b->sense * (P - Q) + b->gap) <= NEAR * EPS * (fabs(P) + fabs(Q) + fabs(b->gap));
}

/* Whether no other stop takes part in an impact. */
static int alone(const Run *r, const Impact *done)
{
    const Impacts *b = &r->impacts;
    Real unit = unit_of(r);
    int i;
    for (i = 0; i < b->stop_count; i++)
        if (&b->stops[i] != done->stop && !stands_off(r, &b->stops[i], done->stop, done->X, done->V, unit))
            return 0;
    for (i = 0; i < b->bound_count; i++)
        if (borders(r, &b->bounds[i], done->stop, done->X))
            return 0;
    return 1;
}

/* 1 / mass that an impulse meets, 0 of ground and base. turning: speed that the rotor gains per impulse on its body */
static Real mobility(const Run *r, int c, Real *turning)
{
    Real inertia, coupling, determinant;
    if (c >= r->bodies)
        return 0.0;
    if (!r->has_motor || c != r->motor_on)
        return 1 / r->masses[c];
    inertia = r->inertia;
    coupling = r->unbalance * sine_of(r->next.phase);
    determinant = (r->masses[c] + r->m3) * inertia - coupling * coupling;
    *turning = coupling / determinant;
    return inertia / determinant;
}

/* Both ends go on with what they have in common, and part with e times what they had not. */
static void strike(Run *r, Impact *done)
{
    const RigidStop *s = done->stop;
    Real turning = 0.0, own = mobility(r, s->P, &turning), other = mobility(r, s->Q, &turning), together = own + other;
    Real vP = column_value(r, r->next.v, s->P, done->V), vQ = column_value(r, r->next.v, s->Q, done->V), between = vP - vQ;
    Real afterP = vP, afterQ = vQ;
    if (other == 0) {
        afterP = vQ - s->e * between;
    } else if (own == 0) {
        afterQ = vP + s->e * between;
    } else {
        Real common = (other * vP + own * vQ) / together;
        afterP = common - s->e * (own / together * between);
        afterQ = common + s->e * (other / together * between);
    }
    if (s->P < r->bodies)
        r->next.v[s->P] = afterP;
    if (s->Q < r->bodies)
        r->next.v[s->Q] = afterQ;
    done->size = fabs(vP) + fabs(vQ);
    done->after = -(s->e * done->before);
    done->impulse = (1 + s->e) * done->before / together;
    if (r->has_motor && s->P == r->motor_on)
        r->next.w = r->next.w + turning * (s->sense * done->impulse);
    else if (r->has_motor && s->Q == r->motor_on)
        r->next.w = r->next.w + turning * -(s->sense * done->impulse);
}

/* Whether an impact moves an end of a friction. */
static int moves(const Run *r, const RigidStop *s, const Rubbing *f)
{
    int P = f->P == s->P || f->P == s->Q, Q = f->Q == s->P || f->Q == s->Q;
    return (P && f->P < r->bodies) || (Q && f->Q < r->bodies);
}

/* Sliding velocity of a friction. */
static Real slip_of(const Run *r, const Rubbing *f, Real V)
{
    return (column_value(r, r->next.v, f->P, V) - column_value(r, r->next.v, f->Q, V)) - f->belt;
}

/* Number of the mode with the codes of r->impacts; NOTHING where it has not been met. */
static int mode_behind(const Run *r)
{
    const size_t size = sizeof(int) * (size_t)r->parts;
    int k;
    if (memcmp(r->mode->codes, r->impacts.codes, size) == 0)
        return r->mode_number;
    for (k = 0; k < r->mode_count; k++)
        if (memcmp(r->modes[k]->codes, r->impacts.codes, size) == 0)
            return k;
    return NOTHING;
}

/* The frictions that an impact moves slip as the velocities behind it say, in a mode that has been met; 0 where one may stick. */
static int turned(Run *r, Impact *done)
{
    Impacts *b = &r->impacts;
    int *codes = b->codes + (r->parts - r->clearances - b->friction_count), i;
    memcpy(b->codes, r->mode->codes, sizeof(int) * (size_t)r->parts);
    b->kinds[0] = IMPACT;
    b->parts[0] = done->stop->stop;
    done->happened = 1;
    for (i = 0; i < b->friction_count; i++) {
        const Rubbing *f = &b->frictions[i];
        Real slip, own;
        int sense;
        if (!moves(r, done->stop, f))
            continue;
        slip = slip_of(r, f, done->V);
        own = fabs(column_value(r, r->next.v, f->P, done->V)) + fabs(column_value(r, r->next.v, f->Q, done->V)) + fabs(f->belt);
        if (!(fabs(slip) > ROUNDING * EPS * fmax(own, done->size)))
            return 0;
        sense = slip > 0 ? 1 : -1;
        if (sense != codes[i]) {
            b->kinds[done->happened] = codes[i] == 0 ? STICK_END : REVERSAL;
            b->parts[done->happened++] = i;
        }
        codes[i] = sense;
    }
    done->target = mode_behind(r);
    return done->target != NOTHING;
}

/* Deceleration of a friction that slips in the mode behind the impact; 0 where it does not. */
static Real slowing(Run *r, const Impact *done, int friction)
{
    const Mode *m = r->modes[done->target];
    int i;
    for (i = 0; i < m->event_count; i++)
        if (m->events[i].kind == SLIDE && m->events[i].part == friction)
            return -derivative_at_next(r, m, m->events[i].key, 1);
    return 0.0;
}

/*
 * Whether a friction that the impact moves slips so slowly that a hop of the speed behind it turns it round, or comes to
 * rest before the next impact, `after` [s].
 */
static int rubs(Run *r, const Impact *done, Real after)
{
    int i;
    for (i = 0; i < r->impacts.friction_count; i++) {
        const Rubbing *f = &r->impacts.frictions[i];
        Real slip;
        if (!moves(r, done->stop, f))
            continue;
        slip = fabs(slip_of(r, f, done->V));
        if (slip <= TURNING * -done->after || !(slip > CLEAR * (slowing(r, done, i) * after)))
            return 1;
    }
    return 0;
}

/* What rounding leaves open of times at a stop that `drive` closes. */
static Real resolution(const Run *r, const RigidStop *s, Real drive)
{
    Real unit = unit_of(r), blur = 0.0;
    int i;
    if (s->P != r->columns - 1 && s->Q != r->columns - 1)
        return unit;
    for (i = 0; i < r->base_count; i++) {
        const Harmonic *term = &r->base[i];
        Real angle = turn_angle(term->cycles, term->cycles_lo, r->next.t) + term->phase;
        blur = blur + fabs(term->amplitude * term->omega * (EPS * angle));
    }
    return blur > unit * drive ? blur / drive : unit;
}

/* Speed that rounding of all forces has not given the lightest body since t = 0. */
static Real beyond_rounding(const Run *r, const Impact *done)
{
    Real lightest = INFINITY;
    int i;
    for (i = 0; i < r->bodies; i++)
        lightest = fmin(lightest, r->masses[i]);
    return CANCELLED * EPS * (forces_of(r, r->modes[done->target], &r->next, done->X, done->V) / lightest) * r->next.t;
}

/* Whether the next impact on the stop comes late enough not to be the end of an infinite sequence. */
static int departs(Run *r, const Event *event, const Impact *done)
{
    Real speed = -done->after, e = done->stop->e, drive = -derivative_at_next(r, r->modes[done->target], event->key, 2);
    Real ahead = r->impacts.early ? fmin(fmax(SURELY * e, FURTHEST), EARLY) : 1, furthest = r->impacts.early ? FURTHEST : 1;
    Real rounding = CLEAR * (EPS * size_of(r, done->stop, done->X)), height, shortest;
    if (!isfinite(drive))
        return 0;
    shortest = CLEAR * (fmax(NEXT, (1 - e) * LAST) * resolution(r, done->stop, drive));
    if (!(ahead * (2 * speed) > drive * shortest))
        return 0;
    if (drive <= 0)
        return 1;
    if (e == 1 && !(speed > beyond_rounding(r, done)))
        return 0;
    if (r->known[event->key] != 1 && !(done->before * (done->before / drive) / 2 > NOISE * rounding))
        return 0;
    height = speed * (2 * speed / drive) / 4;
    if (furthest * furthest * height > LOWEST * rounding && furthest * (2 * speed) > drive * shortest)
        return 1;
    return !rubs(r, done, 2 * speed / drive);
}

/* Zeros of sliding velocities that the impact has changed are none any more. */
static void forget_slips(Run *r, const Impact *done)
{
    const Mode *m = r->modes[done->target];
    int i;
    for (i = 0; i < m->event_count; i++) {
        const Event *e = &m->events[i];
        if (e->kind == SLIDE && e->part < r->impacts.friction_count && moves(r, done->stop, &r->impacts.frictions[e->part]))
            r->behind[e->key] = 0;
    }
}

/* What rests or sticks on the base has its velocity, which that of the stretch has but for rounding. */
static void carry(Run *r, Real V)
{
    const Mode *m = r->mode;
    int c;
    for (c = 0; c < r->bodies; c++)
        if (m->leader[c] == r->columns - 1)
            r->next.v[c] = V + m->drift[c];
}

/* Velocities as they were in front of the impact. */
static void undo(Run *r)
{
    memcpy(r->next.v, r->before_v, sizeof(Real) * (size_t)r->bodies);
    r->next.w = r->before_w;
}

/* Whether the impact of `event` at r->next is clear; it has changed velocities there, if not all of them. */
static int is_clear(Run *r, const Event *event, Impact *done)
{
    carry(r, done->V);
    done->before = rate_of(r, done->stop, done->V);
    if (!(done->before > 0) || !alone(r, done))
        return 0;
    strike(r, done);
    return turned(r, done) && departs(r, event, done);
}

/* Take the impact of the pending event at r->next; 0 where Python has to decide, and nothing is changed then. */
int impact_take(Run *r, const Event *event, Impact *done)
{
    const RigidStop *s = done->stop = stop_of(&r->impacts, event->part);
    if (s == NULL || s->e == 0 || r->next.t == 0)
        return 0;
    base_motion_at(r, r->mode, r->next.t, &done->X, &done->V);
    if (!is_clear(r, event, done)) {
        undo(r);
        return 0;
    }
    forget_slips(r, done);
    project_to_rest(r, s, done->X);
    return 1;
}

/* What an impact adds to the ledgers: loss, work and impulses of ground and base. */
void impact_count(Run *r, const Impact *done)
{
    const RigidStop *s = done->stop;
    Real *entries = r->ledger.entries, impulse = s->Q >= r->bodies ? s->sense * done->impulse : -s->sense * done->impulse;
    if (s->loss >= 0)
        entries[s->loss] = entries[s->loss] + done->impulse * (done->before + done->after) / 2;
    if (s->work >= 0)
        entries[s->work] = entries[s->work] + done->V * impulse;
    if (s->impulse >= 0)
        entries[s->impulse] = entries[s->impulse] + impulse;
}
