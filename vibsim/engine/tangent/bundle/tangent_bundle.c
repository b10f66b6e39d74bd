/* The tangent bundle of a run: K disturbances carried through modes and events, and how fast they grow.
 *
 * Disturbances are orthonormalised (modified Gram-Schmidt) at every step and every event that changes them; what they grow by there
 * adds up to the exponents (Benettin et al. 1980), the largest first. Event times lie on the grid of doubles, while the saltation
 * matrices are those of the exact event: the difference is of the size of rounding.
 *
 * Each tie takes a direction from the tangent space, a rigid stop at rest two, and an impact without restitution one: a rank loss,
 * counted. Disturbances that do not fit into it any longer are replaced: by possible ones as far as there is room, by some that wait
 * outside, unmoved, until ties let go. A direction that was replaced has the exponent minus infinity over the span.
 *
 * A complete bundle checks itself (Liouville): the logarithm of its volume must grow by the integral of the trace of the equations of
 * motion and by the logarithms of the determinants at the events. Sticking, where the determinant is 0, reversals that all but stick
 * and slow impacts, which press a volume flat, are left out on both sides.
 */
#include <string.h>

#include "elementary.h"
#include "tangent.h"

/* Determinant of a jump, and share of the longest disturbance that it leaves of the flattest, below which their rounding, EPS / FLAT,
 * would drown the check.
 */
#define FLAT 0x1p-7
#ifdef WORDS_BY_RUN
#define WHERE_LONG 1 /* signals are heard in the midst of a piece */
#else
#define WHERE_LONG 0
#endif
/* What is left of a disturbance beside others, as a share of the longest one: rounding below LOST. As a share of itself: below SLIVER
 * it is at right angles to them to EPS / SLIVER only, the square of which a volume shows.
 */
#define LOST 0x1p-40
#define SLIVER 0x1p-26

/* Growth counts from here on. */
static void start_to_count(Tangent *b)
{
    int i;
    for (i = 0; i < b->count; i++) {
        b->sums[i] = 0.0;
        b->columns[i] = i;
        b->lost[i] = 0;
    }
}

/* Directions that wait outside when counting begins are lost already. */
static void mark_waiting(Tangent *b)
{
    int i;
    for (i = b->possible; i < b->count; i++)
        b->lost[i] = 1;
}

/* Time of the next row. */
static Real mark(const Run *r)
{
    const Tangent *b = r->tangent;
    return b->next_row >= SPANS ? r->t_end : b->begin + (r->t_end - b->begin) * b->next_row / SPANS;
}

/* Keep a row where one is due at t. */
static void keep_row(const Run *r, Real t)
{
    Tangent *b = r->tangent;
    Real *row;
    int i;
    if (b->next_row > SPANS || t < mark(r))
        return;
    if (b->next_row == 0) {
        start_to_count(b);
        mark_waiting(b);
        b->losses = b->outside;
        tangencies_forget(&b->tangencies);
    }
    row = b->rows + b->row_count++ * (1 + b->count);
    row[0] = t;
    for (i = 0; i < b->count; i++)
        row[1 + b->columns[i]] = b->sums[i];
    while (b->next_row <= SPANS && mark(r) <= t)
        b->next_row++;
}

/* Scalar product of two vectors: each entry is measured as a velocity by its weight. */
static Real product(const Tangent *b, const Real *one, const Real *other)
{
    Real total = b->weights[0] * (one[0] * other[0]);
    int k;
    for (k = 1; k < b->size; k++)
        total = total + b->weights[k] * (one[k] * other[k]);
    return total;
}

/* Leave of a vector what lies beside `count` orthonormal ones, of length 1; returns how long it was. */
static Real orthonormalise(const Tangent *b, Real *vector, const Real *others, int count)
{
    Real size;
    int i, k;
    for (i = 0; i < count; i++, others += b->size) {
        Real overlap = product(b, others, vector);
        for (k = 0; k < b->size; k++)
            vector[k] = vector[k] - overlap * others[k];
    }
    size = sqrt(product(b, vector, vector));
    for (k = 0; size > 0 && k < b->size; k++)
        vector[k] = vector[k] / size;
    return size;
}

static Real growth_of(Real size)
{
    return size > 0 ? logarithm(size) : -INFINITY;
}

static Real length_of(const Tangent *b, int i)
{
    const Real *vector = b->vectors + i;
    Real total = b->weights[0] * (vector[0] * vector[0]);
    const int stride = b->stride;
    int k;
    for (k = 1; k < b->size; k++)
        total = total + b->weights[k] * (vector[k * stride] * vector[k * stride]);
    return sqrt(total);
}

/* Make a disturbance of length 1; returns how long it was. */
static Real normalise(Tangent *b, int i)
{
    Real *vector = b->vectors + i, size = length_of(b, i);
    const int stride = b->stride;
    int k;
    for (k = 0; size > 0 && k < b->size; k++)
        vector[k * stride] = vector[k * stride] / size;
    return size;
}

/* Leave of the disturbances behind number i what lies beside it. */
static void project(Tangent *b, int i)
{
    Real *overlap = b->line;
    int j, k;
    for (k = 0; k < b->size; k++) {
        const Real *entry = b->vectors + k * b->stride, own = entry[i], weight = b->weights[k];
        if (k == 0)
            for (j = i + 1; j < b->possible; j++)
                overlap[j] = weight * (own * entry[j]);
        else
            for (j = i + 1; j < b->possible; j++)
                overlap[j] = overlap[j] + weight * (own * entry[j]);
    }
    for (k = 0; k < b->size; k++) {
        Real *entry = b->vectors + k * b->stride, own = entry[i];
        for (j = i + 1; j < b->possible; j++)
            entry[j] = entry[j] - overlap[j] * own;
    }
}

/* Orthonormalise the possible disturbances, add to the growth; returns the logarithm of the volume that they spanned. */
static Real renormalise(Tangent *b)
{
    Real volume = 0.0;
    int i;
    b->shortest = INFINITY;
    for (i = 0; i < b->possible; i++) {
        Real size = normalise(b, i), growth = growth_of(size);
        b->shortest = size < b->shortest ? size : b->shortest;
        project(b, i);
        b->sums[i] = b->sums[i] + growth;
        volume = volume + growth;
    }
    return volume;
}

/* Add from the candidates, each time that which is least like the `before` vectors there are (the longest remainder as a share of
 * its length), up to `count` of them; returns how many vectors there are.
 */
static int fill(Tangent *b, int candidates, int before, int count)
{
    int i;
    for (; before < count; before++) {
        Real *most = b->fitted + before * b->size, longest = 0.0;
        for (i = 0; i < candidates; i++) {
            Real whole, share;
            memcpy(b->vector, b->candidates + i * b->size, sizeof(Real) * (size_t)b->size);
            whole = sqrt(product(b, b->vector, b->vector));
            share = orthonormalise(b, b->vector, b->fitted, before) / whole;
            if (i == 0 || share > longest) {
                longest = share;
                memcpy(most, b->vector, sizeof(Real) * (size_t)b->size);
            }
        }
    }
    return before;
}

/* Orthonormalise the possible disturbances in the tangent space of m; replace those that are lost and those that waited.
 * flat : dimensions of that space in which an event has left none of any disturbance
 */
static void fit(const Run *r, const Mode *m, int flat)
{
    Tangent *b = r->tangent;
    int room = b->component_count - b->outside, fitting = 0, over = 0, vectors, i;
    Real longest = 1.0; /* at least 1, the length of each before the event */
    for (i = 0; i < b->possible; i++) {
        Real length = length_of(b, i);
        longest = length > longest ? length : longest;
    }
    for (i = b->possible; i < b->count; i++, over++) {
        b->over[over] = b->sums[i];
        b->over_columns[over] = b->columns[i];
    }
    for (i = 0; i < b->possible; i++) {
        Real *vector = b->fitted + fitting * b->size, size;
        take_vector(b, i, b->vector);
        size = orthonormalise(b, b->vector, b->fitted, fitting);
        if (size > LOST * longest && fitting < room - flat) {
            if (size < SLIVER * length_of(b, i))
                orthonormalise(b, b->vector, b->fitted, fitting);
            memcpy(vector, b->vector, sizeof(Real) * (size_t)b->size);
            b->sums[fitting] = b->sums[i] + logarithm(size);
            b->columns[fitting] = b->columns[i];
            b->lost[fitting++] = b->lost[i];
        } else {
            b->over[over] = b->sums[i];
            b->over_columns[over++] = b->columns[i];
        }
    }
    b->possible = room < b->count ? room : b->count;
    vectors = fill(b, space_inside(r, m), fitting, b->possible);
    fill(b, space_outside(r, m), vectors, b->count);
    for (i = 0; i < b->count; i++)
        put_vector(b, i, b->fitted + i * b->size);
    for (i = 0; i < over; i++) {
        b->sums[fitting + i] = b->over[i];
        b->columns[fitting + i] = b->over_columns[i];
        b->lost[fitting + i] = 1;
    }
}

/* Disturbances at the start: a general one, then one component each. */
void tangent_open(Run *r)
{
    Tangent *b = r->tangent;
    int i;
    if (!b)
        return;
    tangencies_pass_by(r, &r->state);
    b->possible = b->count;
    b->outside = b->losses = space_held(r, r->mode);
    if (b->given) {
        seat_disturbances(r, r->mode);
        join_disturbances(r, r->mode, &r->state);
        return;
    }
    for (i = 0; i < b->component_count; i++)
        b->vectors[b->components[i] * b->stride] = 1.0;
    for (i = 1; i < b->count; i++)
        b->vectors[b->components[i] * b->stride + i] = 1.0;
    renormalise(b);
    if (b->outside) {
        seat_disturbances(r, r->mode);
        join_disturbances(r, r->mode, &r->state);
        gauge_apply(b);
        fit(r, r->mode, 0);
    }
    start_to_count(b);
    mark_waiting(b);
    keep_row(r, r->state.t);
}

void tangent_begin_stretch(Run *r)
{
    if (r->tangent) {
        r->tangent->t = r->state.t;
        r->tangent->arrived = 0;
        r->tangent->taylor.prepared = r->tangent->taylor.has_step = 0;
    }
}

/* Measure displacements from their references, orthonormalise behind a piece, and check the volume over it. */
static void account(Run *r, Real t, Real ahead)
{
    Tangent *b = r->tangent;
    Real volume;
    gauge_apply(b);
    volume = renormalise(b);
    if (b->complete)
        b->residual = b->residual + (volume - log_volume(r, t, ahead));
}

/* Move disturbances over the piece that ends tau after where they are, or over a half of it again and again where it is too long;
 * returns its end.
 */
static Real move_by_series(Run *r, Real ahead, Real tau)
{
    Tangent *b = r->tangent;
    while (!taylor_move(r, b->t, ahead, tau)) {
        Real half = b->t + (ahead - b->t) / 2;
        if (!(b->t < half && half < ahead))
            break;
        memcpy(b->vectors, b->moved, sizeof(Real) * (size_t)(b->size * b->stride));
        ahead = half;
        tau = ahead - b->t;
        b->arrived = 0;
    }
    return ahead;
}

/* Carry the disturbances over the stretch in hand, piece by piece, up to the instant of its event, which is not on the grid of
 * time where a rigid stop is struck; 0 where the work of a call is spent before.
 */
int tangent_gather(Run *r)
{
    Tangent *b = r->tangent;
    Real end = r->pending_end, late;
    if (!b)
        return 1;
    late = r->pending_tau - (end - r->t0); /* the instant of an impact is not on the grid of time */
    while (b->t < end || (late != 0 && !b->arrived)) {
        Real ahead = end, tau;
        r->hears = WHERE_LONG;
        if (b->t < end)
            ahead = r->closed ? closed_form_piece_end(r, b->t, end, b->given ? end : mark(r)) : taylor_piece_end(r, b->t, end);
        if (r->spent > r->work_at_once) {
            r->hears = 0;
            return 0;
        }
        b->arrived = !(ahead < end);
        tau = b->arrived ? (ahead - b->t) + late : ahead - b->t;
        if (r->closed)
            closed_form_move(r, tau);
        else
            ahead = move_by_series(r, ahead, tau);
        r->hears = 0;
        if (r->interrupted) { /* the piece is moved anew */
            r->interrupted = ELSEWHERE;
            b->arrived = b->taylor.prepared = b->taylor.has_step = 0;
            return 0;
        }
        if (!r->closed && b->taylor.undefined)
            tangencies_refuse(&b->tangencies, b->t);
        r->spent += 1 + b->possible;
        b->pieces += 1;
        if (!b->given)
            account(r, b->t, ahead);
        b->t = ahead;
        if (!b->given)
            keep_row(r, ahead);
    }
    tangencies_pass_by(r, &r->next);
    return 1;
}

Real tangent_worked_to(const Run *r)
{
    return r->tangent->t;
}

/* Whether two modes have the same tied bodies and the same rigid stops at rest. */
static int same_ties(const Run *r, const Mode *one, const Mode *other)
{
    return memcmp(one->leader, other->leader, sizeof(int) * (size_t)r->columns) == 0 && same_seats(r, one, other);
}

/* Ties have changed: tied bodies get one velocity, momentum kept, and the ends of stops that come to rest one displacement; then
 * the disturbances are fitted into the new tangent space. Directions that ties took are rank losses.
 */
static void change_ties(Run *r, const Mode *after)
{
    Tangent *b = r->tangent;
    int outside = space_held(r, after);
    b->losses += outside > b->outside ? outside - b->outside : 0;
    b->outside = outside;
    seat_disturbances(r, after);
    join_disturbances(r, after, &r->next);
    if (b->given)
        return;
    gauge_apply(b);
    fit(r, after, 0);
}

/* Judge an event and apply its saltation. */
static Handed jump(Run *r, const Event *e, const Mode *before, const Mode *after)
{
    Handed done = {0, SAME, 0, 0, 1.0, 1.0};
    Saltation s;
    tangencies_judge(r, e, &r->next, before, after);
    s = saltation(r, &r->next, before, after, e);
    saltation_apply(r, &s, &r->next);
    done.kind = s.kind;
    done.determinant = s.determinant;
    return done;
}

/* The same where Python has done so. */
static Handed note_handed(Run *r, const Mode *after)
{
    Tangent *b = r->tangent;
    tangencies_note(&b->tangencies, b->handed.tangencies, b->handed.closest, r->next.t);
    if (b->handed.undefined)
        tangencies_refuse(&b->tangencies, r->next.t);
    if (b->handed.kind == JOINED)
        join_disturbances(r, after, &r->next);
    return b->handed;
}

/* Whether a stop or friction that an event is of is among those of the scene. */
static int known_part(const Tangent *b, const Event *e)
{
    return e->kind == GAP || e->kind == STRIKE ? e->part < b->stop_count : e->kind != SLIDE || e->part < b->friction_count;
}

/* Take the event at r->next from one mode to another. Behind a jump that changes no ties the disturbances are orthonormalised, and
 * the logarithm of its determinant is that of the volume; a determinant of 0 is a rank loss.
 */
void tangent_cross(Run *r, int event, const Mode *before, const Mode *after)
{
    Tangent *b = r->tangent;
    const Event *e = &before->events[event];
    Handed done;
    if (!b || (before == after && e->kind != STRIKE) || !known_part(b, e))
        return;
    done = b->handed.here ? note_handed(r, after) : jump(r, e, before, after);
    b->handed.here = 0;
    if (e->kind == STRIKE && done.kind != SAME)
        tangencies_struck_at(r, e->part, &r->next);
    if (!same_ties(r, before, after)) {
        change_ties(r, after);
    } else if (done.kind != SAME && !b->given) {
        Real volume, longest = 0.0, determinant = fabs(done.determinant);
        int i, flat;
        gauge_apply(b);
        if (determinant == 0) {
            b->losses += 1;
            fit(r, after, 1);
            return;
        }
        for (i = 0; i < b->possible; i++) {
            Real length = length_of(b, i);
            longest = length > longest ? length : longest;
        }
        volume = renormalise(b);
        flat = b->shortest <= FLAT * longest;
        if (flat) /* what is left of nearly parallel vectors is not orthogonal to rounding */
            renormalise(b);
        if (b->complete && determinant > FLAT && !flat)
            b->residual = b->residual + (volume - logarithm(determinant));
    }
}
