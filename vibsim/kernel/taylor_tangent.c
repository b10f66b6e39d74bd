/* Disturbances along one step of the Taylor flow; twin of vibsim/flows/taylor_tangent.py. */
#include "kernel.h"
#include "../engine/numbers.h"
#include "../engine/pair.h"

#define REACH 1.25

/* What the recurrences of all disturbances share over one step. Side by side in `joint`: coefficient i + 1 of c w = s' and
 * coefficient i of c a1; in `sine`: s twice.
 */
typedef struct {
    double k, c, per_m1, per_m2, unbalance, drag, to_a1, to_w, cross, first_turning;
    double joint[SERIES][2], sine[SERIES][2];
    const double *inverse;
    int count, locked, motor;
} Law;

/* Series of one disturbance, row by row. Side by side in `joint`: dw's coefficient n + 1 and A1's coefficient n; in `phi`:
 * dphi twice.
 */
typedef struct {
    double table[SERIES][DISTURBANCE], joint[SERIES][2], phi[SERIES][2];
} Series;

static void joint_series(const Taylor *f, Law *law)
{
    double a1_back[SERIES];
    int count = law->count, n, i; /* a1_back[count - 1 - n] = a1[n] */
    for (n = 0; n < count; n++)
        a1_back[count - 1 - n] = (n + 1) * f->table[n + 1][V1];
    law->first_turning = f->sine[1];
    for (n = 0; n <= count; n++)
        law->sine[n][0] = law->sine[n][1] = f->sine[n];
    for (n = 0; n < count; n++) {
        const double *back = a1_back + (count - 1 - n); /* back[i] = a1[n - i] */
        Pair sums = make_pair(0, 0);
        for (i = 0; i + 1 <= n; i += 2)
            sums = add_product(sums, load_pair(f->cosine + i), load_pair(back + i));
        if (i <= n)
            sums = add_product(sums, make_pair(f->cosine[i], 0), make_pair(back[i], 0));
        law->joint[n][0] = (n + 2) * f->sine[n + 2];
        law->joint[n][1] = sum_of_pair(sums);
    }
}

static void law_set(const Run *r, Law *law)
{
    const Scene *s = &r->scene;
    const Taylor *f = &r->taylor;
    law->k = f->k;
    law->c = s->c;
    law->per_m1 = f->per_m1;
    law->per_m2 = f->per_m2;
    law->unbalance = f->unbalance;
    law->inverse = f->inverse;
    law->count = f->order - 1;
    law->locked = f->locked;
    law->motor = s->has_motor != 0;
    if (law->motor) {
        double mass = s->m1 + s->m3, inertia = s->J + f->unbalance * s->e, coupling = f->unbalance * f->sine[0];
        double inverse_det = 1 / (mass * inertia - coupling * coupling);
        joint_series(f, law);
        law->to_a1 = inertia * inverse_det;
        law->to_w = mass * inverse_det;
        law->cross = coupling * inverse_det;
        law->drag = s->M0 / s->Omega0;
    }
}

/* Coefficient n + 1 of c w dphi + s dw without s_0 dw_(n + 1), and coefficient n of c a1 dphi + s A1 without s_0 A1_n. */
static inline void products(const Law *law, const Series *d, int n, double *tail, double *back)
{
    Pair zero = make_pair(0, 0), turned = zero, driven = zero, turned_odd = zero, driven_odd = zero;
    int i;
    for (i = 2; i < n; i += 2) {
        turned = add_product(turned, load_pair(law->joint[i]), load_pair(d->phi[n - i]));
        driven = add_product(driven, load_pair(law->sine[i]), load_pair(d->joint[n - i]));
        turned_odd = add_product(turned_odd, load_pair(law->joint[i + 1]), load_pair(d->phi[n - i - 1]));
        driven_odd = add_product(driven_odd, load_pair(law->sine[i + 1]), load_pair(d->joint[n - i - 1]));
    }
    if (i == n) {
        turned = add_product(turned, load_pair(law->joint[i]), load_pair(d->phi[0]));
        driven = add_product(driven, load_pair(law->sine[i]), load_pair(d->joint[0]));
    }
    turned = add_pair(add_pair(turned, turned_odd), add_pair(driven, driven_odd));
    if (n > 0) {
        turned = add_product(turned, load_pair(law->joint[1]), load_pair(d->phi[n - 1]));
        turned = add_product(turned, load_pair(law->sine[1]), load_pair(d->joint[n - 1]));
    }
    turned = add_product(turned, load_pair(law->joint[0]), load_pair(d->phi[n]));
    *tail = first_of_pair(turned) + law->first_turning * d->phi[n + 1][0];
    *tail = *tail + law->sine[n + 1][0] * d->table[0][DW];
    *back = second_of_pair(turned);
}

static inline void advance(const Law *law, Series *d, int n, double a1, double force)
{
    const double *row = d->table[n];
    double *next = d->table[n + 1], inverse = law->inverse[n + 1];
    next[DY] = (row[DV1] - row[DV2]) * inverse;
    next[DV1] = a1 * inverse;
    next[DV2] = law->locked ? 0.0 : force * law->per_m2 * inverse;
}

static void expand(const Law *law, Series *d)
{
    int n;
    for (n = 0; n < law->count; n++) {
        const double *row = d->table[n];
        double *next = d->table[n + 1], inverse = law->inverse[n + 1], tail, back, thrust, torque, a1;
        double force = law->k * row[DY] + law->c * (row[DV1] - row[DV2]);
        next[DPHI] = next[DW] = 0.0;
        if (!law->motor) {
            advance(law, d, n, -(force * law->per_m1), force);
            continue;
        }
        next[DPHI] = d->phi[n + 1][0] = d->phi[n + 1][1] = row[DW] * inverse;
        products(law, d, n, &tail, &back);
        thrust = law->unbalance * ((n + 1) * tail) - force;
        torque = law->unbalance * back - law->drag * row[DW];
        a1 = law->to_a1 * thrust + law->cross * torque;
        next[DW] = (law->to_w * torque + law->cross * thrust) * inverse;
        d->joint[n][0] = next[DW];
        d->joint[n][1] = a1;
        advance(law, d, n, a1, force);
    }
}

/* `horner` component by component over the table. */
static void value_at(const Series *d, int count, double tau, double *out)
{
    double square = tau * tau, high[DISTURBANCE], low[DISTURBANCE];
    int n = count - 3, k;
    for (k = 0; k < DISTURBANCE; k++) {
        high[k] = d->table[count - 1][k];
        low[k] = d->table[count - 2][k];
    }
    for (; n > 0; n -= 2)
        for (k = 0; k < DISTURBANCE; k++) {
            high[k] = high[k] * square + d->table[n][k];
            low[k] = low[k] * square + d->table[n - 1][k];
        }
    for (k = 0; k < DISTURBANCE; k++)
        out[k] = count % 2 == 0 ? low[k] + tau * high[k] : (high[k] * square + d->table[0][k]) + tau * low[k];
}

static void move(Run *r, double tau)
{
    Tangent *b = &r->tangent;
    Law law;
    Series d;
    int i, k;
    law_set(r, &law);
    for (i = 0; i < b->count; i++) {
        double *v = b->vectors[i], resting = v[DV2];
        for (k = 0; k < DISTURBANCE; k++)
            d.table[0][k] = v[k];
        d.phi[0][0] = d.phi[0][1] = v[DPHI];
        if (law.locked)
            d.table[0][DV2] = 0.0;
        expand(&law, &d);
        value_at(&d, law.count + 1, tau, v);
        if (law.locked)
            v[DV2] = resting;
    }
}

void taylor_tangent_set(Run *r)
{
    const Scene *s = &r->scene;
    const Taylor *f = &r->taylor;
    double spread = 0;
    int n;
    r->tangent.dragging = 0.0;
    if (s->has_motor != 0) {
        double mass = s->m1 + s->m3, inertia = s->J + f->unbalance * s->e;
        r->tangent.dragging = s->M0 / s->Omega0 * mass / (mass * inertia - f->unbalance * f->unbalance);
    }
    for (n = 2; n <= f->order; n++)
        spread = spread + log(n);
    r->tangent.reach = power_of_two((s->tolerance_exponent + spread / log(2.0)) / f->order);
}

double taylor_tangent_piece_end(const Run *r, double t, double end)
{
    const Taylor *f = &r->taylor;
    double mobility = f->locked ? f->per_m1 : f->per_m1 + f->per_m2;
    double rate = sqrt(f->k * mobility) / REACH, damping = r->scene.c * mobility, ahead;
    rate = damping > rate ? damping : rate;
    if (r->scene.has_motor != 0) {
        double turning = fabs(f->table[0][W]) / REACH;
        rate = r->tangent.dragging > rate ? r->tangent.dragging : rate;
        rate = turning > rate ? turning : rate;
    }
    ahead = rate > 0 ? t + r->tangent.reach / rate : end;
    return t < ahead && ahead < end ? ahead : end;
}

double taylor_tangent_move(Run *r, double t, double end)
{
    double volume, steps = r->steps;
    Taylor kept;
    State state;
    int anew = r->scene.has_motor != 0 && t != r->taylor.t0;
    if (anew) {
        kept = r->taylor;
        flow_state(r, t, &state);
        taylor_enter(r, &state, r->mode);
    }
    move(r, end - t);
    volume = r->tangent.complete ? taylor_log_volume(r, end - t) : 0.0;
    if (anew) {
        r->taylor = kept;
        r->steps = steps;
    }
    return volume;
}
