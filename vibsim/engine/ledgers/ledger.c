/* The integrals of the ledgers, stretch by stretch, by Gauss-Legendre quadrature of the flow itself; vibsim/engine/ledger.py says what
 * the ledgers are.
 */
#include <string.h>

#include "columns.h"
#include "event_functions.h"
#include "gauss_nodes.h"
#include "numbers.h"
#include "wide.h"

WIDE static void series_at_all(const Real *c, int count, int stride, const Real *tau, const Real *square, Real *out)
{
    series_at(c, count, stride, tau, square, out, NODE_COUNT);
}

WIDE static void series_at_few(const Real *c, int count, int stride, const Real *tau, const Real *square, Real *out)
{
    series_at(c, count, stride, tau, square, out, FEW_NODES);
}

/* A force a time tau after the expansion point; its phase there and the angle since are reduced apart, without a large product. */
static Real force_at(const Run *r, const Force *force, Real tau)
{
    Real total = force->constant;
    int i;
    for (i = 0; i < force->count; i++) {
        const Harmonic *term = &force->terms[i];
        Real anchor = turn_angle(term->cycles, term->cycles_lo, r->t0) + term->phase;
        Real sine = sine_of(anchor + turn_angle(term->cycles, term->cycles_lo, tau));
        total = total + term->amplitude * sine;
    }
    return total;
}

/* A force at the point that the closed form evaluated last. */
static Real force_here(const Run *r, const Force *force)
{
    Real total = force->constant;
    int i;
    for (i = 0; i < force->count; i++)
        if (force->terms[i].harmonic >= 0)
            total = total + force->terms[i].amplitude * r->closed_form.sines[force->terms[i].harmonic];
    return total;
}

/* What the integrals read at `count` nodes, tau after the expansion point of a Taylor step. */
static void taylor_nodes(Run *r, const LedgerIntegrals *m, const Real *tau, int count)
{
    Taylor *f = &r->taylor;
    Nodes *at = &r->ledger.nodes;
    const Real *rates = f->table + f->rates;
    void (*series_at_nodes)(const Real *, int, int, const Real *, const Real *, Real *) = count == FEW_NODES ? series_at_few : series_at_all;
    int rows = f->order + 2, i, n;
    Real squares[NODE_COUNT];
    for (n = 0; n < count; n++)
        squares[n] = tau[n] * tau[n];
    for (i = 0; i < r->columns; i++)
        if (m->reads[i] && (i < r->bodies || (i > r->bodies && r->has_base)))
            series_at_nodes(rates + column_in_table(r, i), rows, f->stride, tau, squares, at->v[i]);
    if (m->spins)
        series_at_nodes(rates + r->bodies, rows, f->stride, tau, squares, at->w);
    for (i = 0; m->forces && i < r->force_count; i++)
        for (n = 0; n < count; n++)
            at->force[i][n] = force_at(r, &r->forces[i], tau[n]);
    for (i = 0; i < m->function_count; i++)
        series_at_nodes(at->series + i * SERIES, at->lengths[i], 1, tau, squares, at->function[i]);
}

/* Whether nodes ascend: in a very short piece rounding makes some of them one. */
static int ascend(const Real *tau)
{
    int n = 1;
    while (n < NODE_COUNT && tau[n - 1] < tau[n])
        n++;
    return n == NODE_COUNT;
}

/* All nodes from the first that is told. */
static void many_nodes(Run *r, const LedgerIntegrals *m, const Real *tau, int first)
{
    Nodes *at = &r->ledger.nodes;
    const int base = r->columns - 1, count = NODE_COUNT - first;
    Real X[NODE_COUNT], x[NODE_COUNT];
    int i, k, n;
    closed_form_many(r, tau + first, count);
    closed_form_base(r, X, at->v[base] + first);
    for (i = 0; i < r->bodies; i++)
        if (m->reads[i])
            closed_form_body(r, i, X, at->v[base] + first, x, at->v[i] + first);
    for (i = 0; m->forces && i < r->force_count; i++) {
        const Force *force = &r->forces[i];
        Real *out = at->force[i] + first, sines[NODE_COUNT];
        for (n = 0; n < count; n++)
            out[n] = force->constant;
        for (k = 0; k < force->count; k++) {
            if (force->terms[k].harmonic < 0)
                continue;
            closed_form_sines(r, force->terms[k].harmonic, sines);
            for (n = 0; n < count; n++)
                out[n] = out[n] + force->terms[k].amplitude * sines[n];
        }
    }
}

/* What the integrals read at the nodes, tau after the anchor of the closed form: many times at once, but one by one where
 * functions of the rows are read. A node where the flow was evaluated last is taken from there.
 */
static void closed_form_nodes(Run *r, const LedgerIntegrals *m, const Real *tau)
{
    Nodes *at = &r->ledger.nodes;
    const ClosedForm *f = &r->closed_form;
    const int base = r->columns - 1, one_by_one = m->function_count > 0 || !ascend(tau); /* they coincide in a very short piece */
    const int alone = one_by_one ? NODE_COUNT : tau[0] == f->tau; /* how many, from the first */
    int i, n;
    for (n = 0; n < alone; n++) {
        closed_form_state_after(r, tau[n], &r->scratch);
        for (i = 0; i < r->bodies; i++)
            if (m->reads[i])
                at->v[i][n] = r->scratch.v[i];
        at->v[base][n] = 0.0;
        for (i = 0; i < r->base_count; i++)
            if (r->base[i].harmonic >= 0)
                at->v[base][n] = at->v[base][n] + r->base[i].amplitude * r->base[i].omega * f->cosines[r->base[i].harmonic];
        for (i = 0; m->forces && i < r->force_count; i++)
            at->force[i][n] = force_here(r, &r->forces[i]);
        if (m->function_count > 0)
            closed_form_jets(r, 2);
        for (i = 0; i < m->function_count; i++)
            at->function[i][n] = event_derivative(r, &m->functions[i], 0);
    }
    if (alone < NODE_COUNT)
        many_nodes(r, m, tau, alone);
}

/* What `m` integrates, at node n. */
static Real integrand(const Run *r, const LedgerIntegral *m, int n)
{
    const Nodes *at = &r->ledger.nodes;
    Real u;
    switch (m->kind) {
    case SQUARE:
        u = at->v[m->P][n] - at->v[m->Q][n];
        return u * u;
    case WORK: return at->force[m->source][n] * at->v[m->P][n];
    case TORQUE: return (r->M0 - r->drag * at->w[n]) * at->w[n];
    case SLIP: return (at->v[m->P][n] - at->v[m->Q][n]) - m->drift;
    case RUB: return at->function[m->source][n] * ((at->v[m->P][n] - at->v[m->Q][n]) - m->drift);
    case IMPULSE: return at->force[m->source][n];
    default: return m->P < 0 ? at->function[m->source][n] : at->function[m->source][n] * at->v[m->P][n];
    }
}

/* Its integral over the nodes, by the length of the piece. */
static Real integral(const Run *r, const LedgerIntegral *m, const Quadrature *rule)
{
    Real total = 0.0;
    int n;
    for (n = 0; n < rule->count; n++)
        total = total + rule->weights[n] * integrand(r, m, n);
    return total;
}

/* Add a piece that begins tau after the start of the flow. The nodes lie where they should, not on the grid of time, whose
 * rounding would show in the sums. Eight nodes do for Taylor steps of a moderate order (FEW_NODES_ORDER) without forces or
 * formulas.
 */
static void integrate(Run *r, const LedgerIntegrals *m, Real tau, Real length)
{
    const int by_formulas = r->mode->tape.op_count > 0 || r->mode->base_tape.op_count > 0;
    const Quadrature *rule = r->closed || by_formulas || !r->taylor.few_nodes ? &TWELVE : &EIGHT;
    Real offsets[NODE_COUNT], *entries = r->ledger.open;
    int i;
    for (i = 0; i < rule->count; i++)
        offsets[i] = tau + rule->nodes[i] * length;
    if (r->closed)
        closed_form_nodes(r, m, offsets);
    else
        taylor_nodes(r, m, offsets, rule->count);
    for (i = 0; i < m->count; i++)
        entries[m->integrals[i].entry] = entries[m->integrals[i].entry] + length * (m->integrals[i].factor * integral(r, &m->integrals[i], rule));
}

/* Longest stretch from tau that one quadrature rule integrates to round-off: a Taylor step, or 3 rad of the fastest force. Behind
 * an event the fast transient of strong damping wants short pieces of the closed form, which may grow as it decays.
 */
Real longest_piece(const Run *r, Real tau)
{
    Real longest;
    int m;
    if (!r->closed)
        return r->taylor.longest;
    longest = 1.5 * r->mode->modal->window;
    for (m = 0; m < r->mode->modal->count; m++) {
        Real a = r->mode->modal->coordinates[m].a;
        if (a > 0) {
            Real growing = 1.5 / (2 * a) + tau;
            longest = growing < longest ? growing : longest;
        }
    }
    return longest;
}

/* Open the stretch in hand: its entries, and the functions of the rows as polynomials over a Taylor step. */
void ledger_open(Run *r)
{
    Ledger *l = &r->ledger;
    Nodes *at = &l->nodes;
    const LedgerIntegrals *m = &r->mode->integrals;
    int i;
    if (!l->wanted)
        return;
    memcpy(l->open, l->entries, sizeof(Real) * (size_t)l->count);
    l->tau = r->state.t - r->t0;
    if (!r->closed)
        for (i = 0; i < m->function_count; i++)
            at->lengths[i] = taylor_polynomial(r, &m->functions[i], at->series + i * SERIES);
}

/* Add the stretch in hand, piece by piece; the entries change when all are done, for a call may end before that. */
int ledger_gather(Run *r)
{
    Ledger *l = &r->ledger;
    const LedgerIntegrals *m = &r->mode->integrals;
    Real last = r->pending_tau, *done;
    if (!l->wanted)
        return 1;
    while (l->tau < last) {
        Real piece = longest_piece(r, l->tau);
        Real ahead = piece < last - l->tau ? l->tau + piece : last;
        if (r->spent > r->work_at_once)
            return 0;
        integrate(r, m, l->tau, ahead - l->tau);
        r->spent += NODE_COUNT;
        l->tau = ahead;
    }
    done = l->open;
    l->open = l->entries;
    l->entries = done;
    return 1;
}

/* Count what the springs of stops hold where those let go, or push again, though pressed. */
void ledger_cross(Run *r, const State *state, const int *before, const int *after)
{
    Ledger *l = &r->ledger;
    int i;
    for (i = 0; i < l->jump_count; i++) {
        const Jump *j = &l->jumps[i];
        int pressed = before[j->stop] == IN_CONTACT;
        Real X = 0.0, V, depth, held;
        if (pressed == (after[j->stop] == IN_CONTACT))
            continue;
        if (r->has_base)
            base_motion_at(r, r->mode, state->t, &X, &V);
        depth = -(j->sense * (column_value(r, state->x, j->P, X) - column_value(r, state->x, j->Q, X))) - j->gap;
        held = j->k * (depth * depth) / 2;
        l->entries[j->entry] = pressed ? l->entries[j->entry] + held : l->entries[j->entry] - held;
    }
}
