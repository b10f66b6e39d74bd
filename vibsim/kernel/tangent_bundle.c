/* The tangent bundle of a run; twin of vibsim/kernel/tangent_bundle.py. */
#include "kernel.h"

#define WORK_OF_A_PIECE 10 /* in evaluations of the motion */

static double mark(const Run *r)
{
    const Tangent *b = &r->tangent;
    if (b->next_row >= SPANS)
        return r->scene.t_end;
    return b->begin + (r->scene.t_end - b->begin) * b->next_row / SPANS;
}

static double product(const Tangent *b, const double *v, const double *w)
{
    double total = b->weights[0] * (v[0] * w[0]);
    int k;
    for (k = 1; k < DISTURBANCE; k++)
        total = total + b->weights[k] * (v[k] * w[k]);
    return total;
}

static double renormalise(Tangent *b)
{
    double volume = 0.0;
    int i, j, k;
    for (i = 0; i < b->count; i++) {
        double *v = b->vectors[i], size, growth = -INFINITY;
        for (j = 0; j < i; j++) {
            double overlap = product(b, b->vectors[j], v);
            for (k = 0; k < DISTURBANCE; k++)
                v[k] = v[k] - overlap * b->vectors[j][k];
        }
        size = sqrt(product(b, v, v));
        if (size > 0) {
            for (k = 0; k < DISTURBANCE; k++)
                v[k] = v[k] / size;
            growth = log(size);
        }
        b->sums[i] = b->sums[i] + growth;
        volume = volume + growth;
    }
    return volume;
}

static void lose_rank(Tangent *b)
{
    int i, k;
    b->losses += 1;
    for (i = 0; i < b->count; i++)
        b->vectors[i][DV2] = 0.0;
    for (k = 0; b->complete && k < DISTURBANCE; k++)
        b->vectors[b->count - 1][k] = k == DV2 ? 1.0 : 0.0;
    renormalise(b);
}

static void record_row(Run *r, double t)
{
    Tangent *b = &r->tangent;
    int i;
    if (b->next_row > SPANS || t < mark(r))
        return;
    if (b->next_row == 0) {
        for (i = 0; i < b->count; i++)
            b->sums[i] = 0.0;
        b->losses = b->stuck ? 1 : 0;
        tangencies_forget(&b->tangencies);
    }
    b->rows[b->row_count][0] = t;
    for (i = 0; i < b->count; i++)
        b->rows[b->row_count][i + 1] = b->sums[i];
    b->row_count += 1;
    while (b->next_row <= SPANS && mark(r) <= t)
        b->next_row += 1;
}

static void weights_set(Run *r)
{
    const Scene *s = &r->scene;
    Tangent *b = &r->tangent;
    double mobility = s->has_block2 != 0 ? 1 / s->m1 + 1 / s->m2 : 1 / s->m1;
    double rate = s->k1 > 0 ? sqrt(s->k1 * mobility) : 1.0, arm = s->has_motor != 0 ? s->e : 1.0;
    b->tangencies.rate = rate;
    b->weights[DY] = rate * rate;
    b->weights[DV1] = b->weights[DV2] = 1.0;
    b->weights[DPHI] = (arm * rate) * (arm * rate);
    b->weights[DW] = arm * arm;
}

void tangent_start(Run *r)
{
    const Scene *s = &r->scene;
    Tangent *b = &r->tangent;
    int others[DISTURBANCE] = {DV1}, n = 1, i;
    b->count = (int)s->tangent;
    if (b->count == 0)
        return;
    if (s->has_motor != 0) {
        others[n++] = DPHI;
        others[n++] = DW;
    }
    if (s->has_block2 != 0)
        others[n++] = DV2;
    b->complete = b->count == n + 1;
    b->begin = s->tangent_from;
    weights_set(r);
    if (s->closed_form == 0)
        taylor_tangent_set(r);
    tangencies_forget(&b->tangencies);
    b->vectors[0][DY] = 1.0;
    for (i = 0; i < n; i++)
        b->vectors[0][others[i]] = 1.0;
    for (i = 1; i < b->count; i++)
        b->vectors[i][others[i - 1]] = 1.0;
    renormalise(b);
    for (i = 0; i < b->count; i++)
        b->sums[i] = 0.0;
    b->stuck = s->has_friction != 0 && r->mode.friction == 0;
    if (b->stuck)
        lose_rank(b);
    record_row(r, r->state.t);
}

int tangent_gather(Run *r)
{
    Tangent *b = &r->tangent;
    int closed = r->scene.closed_form != 0;
    if (b->count == 0)
        return 1;
    while (r->carried < r->end) {
        double t = r->carried, ahead, expected, volume;
        if (r->spent > WORK_AT_ONCE)
            return 0;
        ahead = closed ? closed_form_tangent_piece_end(r, t, r->end, mark(r)) : taylor_tangent_piece_end(r, t, r->end);
        expected = closed ? closed_form_tangent_move(r, t, ahead) : taylor_tangent_move(r, t, ahead);
        volume = renormalise(b);
        if (b->complete)
            b->residual = b->residual + (volume - expected);
        b->pieces += 1;
        r->carried = ahead;
        r->spent += WORK_OF_A_PIECE;
        record_row(r, ahead);
    }
    tangencies_pass_by(&b->tangencies, &r->arrival);
    return 1;
}

void tangent_cross(Run *r, int kind, const State *state, Mode before)
{
    Tangent *b = &r->tangent;
    int i;
    if (b->count == 0 || kind == NOTHING)
        return;
    tangencies_judge(r, kind, state, before);
    if (kind == REVERSAL) {
        double factor = reversal_factor(r, state, before.contact);
        for (i = 0; i < b->count; i++)
            b->vectors[i][DV2] = b->vectors[i][DV2] * factor;
        if (b->complete && factor > 0)
            b->residual = b->residual - log(factor);
    } else if (kind == STICK_BEGIN) {
        lose_rank(b);
    }
    b->stuck = kind == STICK_BEGIN || (b->stuck && kind != STICK_END);
}
