/* Least and greatest displacements of a run, period by period, and the smallest gaps at turns without contact, read off the flow
 * as it passes.
 *
 * Between two nodes a displacement d = x_P - x_Q is greatest or least where its rate turns. The nodes lie so close that a cubic
 * through displacements and rates tells whether it turns; the turn itself is found on the flow, to the rounding of d. The speed
 * of a rotor is taken like a displacement.
 *
 * Reading them changes no trajectory.
 */
#include "columns.h"
#include "modes.h"
#include "numbers.h"

#define NODES_OF_CLOSED_FORM 4 /* in a piece of 2.25 rad of the fastest rate */
#define ORDERS_TO_A_NODE 10 /* of a Taylor step, which spans 1.3 rad with order 20 */
#define NEARLY 0.2 /* share of the rates at both ends below which the one between them is taken to come near 0 */
#define HALVINGS 4 /* of an interval in which a displacement may turn twice */
#define ITERATIONS 8 /* to a turn, at most */
#define ROUNDING 0x1p-55 /* of a displacement: a turn is found where what it may still differ by is below that */

typedef struct {
    Real t, value, rate;
} Node;

/* Displacements and their rates at t; of pair `only` alone where that is not negative. */
static void measure(Run *r, Real t, int only, Real *values, Real *rates)
{
    Extremes *e = &r->extremes;
    const Real *x = r->scratch.x, *v = r->scratch.v, *w = &r->scratch.w;
    Real X = 0.0, V = 0.0;
    int q;
    if (r->closed) {
        flow_state(r, t, &r->scratch);
    } else {
        x = t == r->t0 ? taylor_columns_at_start(r) : taylor_columns(r, t - r->t0);
        v = x + r->taylor.rates;
        w = v + r->bodies;
    }
    if (e->based)
        base_motion_at(r, r->mode, t, &X, &V);
    for (q = only < 0 ? 0 : only; q < (only < 0 ? e->count : only + 1); q++) {
        if (q < e->pairs) {
            values[q] = column_value(r, x, e->P[q], X) - column_value(r, x, e->Q[q], X);
            rates[q] = column_value(r, v, e->P[q], V) - column_value(r, v, e->Q[q], V);
        } else {
            values[q] = *w;
            rates[q] = taylor_spin_rate(r, t - r->t0);
        }
    }
}

/* Displacement number q and its rate at t. */
static Node measured(Run *r, int q, Real t)
{
    Extremes *e = &r->extremes;
    Node node;
    measure(r, t, q, e->here, e->here + e->count);
    node.t = t;
    node.value = e->here[q];
    node.rate = e->here[e->count + q];
    return node;
}

/* Count a value of displacement number q, in the present period and in all. */
static void take(Extremes *e, int q, Real value)
{
    if (value < e->low[q])
        e->low[q] = value;
    if (value > e->high[q])
        e->high[q] = value;
    if (value < e->least[q])
        e->least[q] = value;
    if (value > e->greatest[q])
        e->greatest[q] = value;
}

/* Keep the gaps of open stops that are smallest at a turn of displacement number q: where it is least (falling before) of the
 * stops that it closes downwards, where it is greatest of the others.
 */
static void note_gaps(Run *r, int q, Real value, int falling)
{
    Extremes *e = &r->extremes;
    int i;
    for (i = 0; i < e->gap_count; i++) {
        const Gap *g = &e->gaps[i];
        if (g->pair == q && (g->sense > 0) == falling && r->mode->codes[g->stop] == 0) {
            Real left = g->gap + g->sense * value;
            if (left < e->margins[i])
                e->margins[i] = left;
        }
    }
}

/* Whether the rate comes near 0 between two nodes at which it has one sign. Judged by the rate half-way of the cubic through
 * displacements and rates; errs on the side of yes.
 */
static int may_turn_twice(const Node *left, const Node *right)
{
    Real halfway = 1.5 * ((right->value - left->value) / (right->t - left->t)) - 0.25 * (left->rate + right->rate);
    return left->rate * right->rate > 0 && halfway * left->rate < NEARLY * (left->rate * left->rate) &&
           halfway * right->rate < NEARLY * (right->rate * right->rate);
}

/* Place in [0, 1] at which a cubic turns whose rates at both ends of an interval have opposite signs. Of the two roots of its
 * derivative that which lies inside, by the form without cancellation; where rounding puts both outside, the zero of the straight
 * line between the rates.
 */
static Real turn_of_cubic(Real length, Real rise, Real rate0, Real rate1)
{
    Real d0 = length * rate0, d1 = length * rate1;
    Real a = d0 + d1 - 2 * rise, b = 3 * rise - 2 * d0 - d1;
    Real square = b * b - 3 * (a * d0);
    Real root = square > 0 ? sqrt(square) : 0.0;
    Real q = b > 0 ? -(b + root) : root - b;
    Real place = q != 0 ? d0 / q : 0.0;
    if (!(0 < place && place < 1))
        place = a != 0 ? q / (3 * a) : 0.0;
    return 0 < place && place < 1 ? place : d0 / (d0 - d1);
}

/* Take the value at the zero of a rate that changes sign between two nodes. The value there differs from that of the turn by
 * rate^2 / (2 |slope|), slope of the rate: enough where that is within its rounding.
 */
static void turn(Run *r, int q, Node left, Node right)
{
    int falling = left.rate < 0, i;
    for (i = 0; i < ITERATIONS; i++) {
        Real length = right.t - left.t, slope;
        Real t = left.t + turn_of_cubic(length, right.value - left.value, left.rate, right.rate) * length;
        Node node;
        if (!(left.t < t && t < right.t))
            return;
        node = measured(r, q, t);
        r->spent += 1;
        take(&r->extremes, q, node.value);
        note_gaps(r, q, node.value, falling);
        slope = (right.rate - left.rate) / length;
        if (node.rate * node.rate <= ROUNDING * (fabs(slope) * fabs(node.value)))
            return;
        if ((node.rate < 0) == falling)
            left = node;
        else
            right = node;
    }
}

/* Whether the turn between two nodes may be a new extreme, or a gap smaller than those before. Where the cubic through both bends one
 * way, it is not beyond the place where its tangents there meet.
 */
static int may_count(const Run *r, int q, const Node *left, const Node *right)
{
    const Extremes *e = &r->extremes;
    const Real length = right->t - left->t, bend = right->rate - left->rate;
    const Real meeting = (right->rate * length - (right->value - left->value)) / bend, beyond = left->value + left->rate * meeting;
    const int falling = left->rate < 0;
    int i;
    if (!(length < 3 * meeting && 3 * meeting < 2 * length) || (falling ? beyond < e->low[q] : beyond > e->high[q]))
        return 1;
    for (i = 0; i < e->gap_count; i++) {
        const Gap *g = &e->gaps[i];
        if (g->pair == q && (g->sense > 0) == falling && g->gap + g->sense * beyond < e->margins[i])
            return 1;
    }
    return 0;
}

/* Find what turns between two nodes: one turn where the rate changes sign; where it may turn twice, each half in turn. */
static void span(Run *r, int q, Node left, Node right, int halvings)
{
    if (left.rate * right.rate < 0) {
        if (may_count(r, q, &left, &right))
            turn(r, q, left, right);
    } else if (halvings > 0 && may_turn_twice(&left, &right)) {
        Real t = left.t + (right.t - left.t) / 2;
        if (left.t < t && t < right.t) {
            Node middle = measured(r, q, t);
            r->spent += 1;
            take(&r->extremes, q, middle.value);
            span(r, q, left, middle, halvings - 1);
            span(r, q, middle, right, halvings - 1);
        }
    }
}

/* Begin a stretch at the state of now; its first node is not evaluated yet. */
void extremes_open(Run *r)
{
    r->extremes.at = r->state.t;
    r->extremes.has_node = 0;
}

/* Distance of the nodes [s]. */
static Real step(const Run *r)
{
    Real piece = longest_piece(r, r->extremes.at - r->t0);
    return piece / (r->closed ? NODES_OF_CLOSED_FORM : 1 + r->taylor.order / ORDERS_TO_A_NODE);
}

static Node node_of(const Extremes *e, int q, Real t, const Real *values)
{
    Node node = {t, values[q], values[e->count + q]};
    return node;
}

/* Take the stretch up to `end`, from `since` on; 0 where the work of a call is spent before, if that is bounded. */
int extremes_until(Run *r, Real end, int bounded)
{
    Extremes *e = &r->extremes;
    int q;
    if (!e->count || end < e->since)
        return 1;
    if (!e->has_node) {
        e->at = e->at < e->since ? e->since : e->at;
        measure(r, e->at, -1, e->node, e->node + e->count);
        for (q = 0; q < e->count; q++)
            take(e, q, e->node[q]);
        e->has_node = 1;
    }
    while (e->at < end) {
        Real length = step(r), ahead = length < end - e->at ? e->at + length : end, *before;
        if (bounded && r->spent > r->work_at_once)
            return 0;
        measure(r, ahead, -1, e->ahead, e->ahead + e->count);
        r->spent += 1;
        for (q = 0; q < e->count; q++) {
            take(e, q, e->ahead[q]);
            span(r, q, node_of(e, q, e->at, e->node), node_of(e, q, ahead, e->ahead), HALVINGS);
        }
        before = e->node;
        e->node = e->ahead;
        e->ahead = before;
        e->at = ahead;
    }
    return 1;
}

/* End a period; its extremes go into the rows behind the state of the section. Those of the rotor are of all periods. */
void extremes_close(Run *r, Real *row, long room)
{
    Extremes *e = &r->extremes;
    int q;
    for (q = 0; q < e->pairs; q++) {
        row[q * room] = e->low[q];
        row[(e->pairs + q) * room] = e->high[q];
        if (e->has_node)
            e->low[q] = e->high[q] = e->node[q];
    }
}

/* As before the start. */
void extremes_reset(Extremes *e)
{
    int i;
    for (i = 0; i < e->count; i++) {
        e->low[i] = e->least[i] = INFINITY;
        e->high[i] = e->greatest[i] = -INFINITY;
    }
    for (i = 0; i < e->gap_count; i++)
        e->margins[i] = INFINITY;
}

int extremes_read(Run *r, Reader *in)
{
    Extremes *e = &r->extremes;
    int pairs = read_index(in, 0, 1 << 16), gaps = read_index(in, 0, 1 << 16), count = pairs + (r->has_motor ? 1 : 0), i;
    in->owner = r->masses;
    e->P = room(in, 2 * (size_t)pairs, sizeof(int));
    e->gaps = room(in, (size_t)gaps, sizeof(Gap));
    e->numbers = room(in, (size_t)(10 * count + gaps), sizeof(Real));
    if (in->short_of)
        return 0;
    e->Q = e->P + pairs;
    for (i = 0; i < pairs; i++) {
        e->P[i] = read_index(in, 0, r->columns - 1);
        e->Q[i] = read_index(in, 0, r->columns - 1);
        e->based = e->based || e->P[i] > r->bodies || e->Q[i] > r->bodies;
    }
    for (i = 0; i < gaps; i++) {
        e->gaps[i].stop = read_index(in, 0, r->parts - 1);
        e->gaps[i].pair = read_index(in, 0, pairs - 1);
        e->gaps[i].sense = read_index(in, -1, 1);
        e->gaps[i].gap = read_double(in);
    }
    e->since = read_double(in);
    e->low = e->numbers;
    e->high = e->low + count;
    e->least = e->high + count;
    e->greatest = e->least + count;
    e->node = e->greatest + count;
    e->ahead = e->node + 2 * count;
    e->here = e->ahead + 2 * count;
    e->margins = e->here + 2 * count;
    e->pairs = pairs;
    e->gap_count = gaps;
    e->count = count;
    extremes_reset(e);
    return read_through(in);
}
