/* The vector field of a mode at a state, as vibsim/engine/flows/accelerations.py has it for what Python decides. */
#include "columns.h"
#include "numbers.h"
#include "tangent.h"

/* Sum of harmonics at t and its rate of change. */
static void value_and_rate(const Harmonic *terms, int count, Real t, Real *value, Real *rate)
{
    int i;
    *value = *rate = 0.0;
    for (i = 0; i < count; i++) {
        const Harmonic *term = &terms[i];
        Real sine, cosine;
        rounded_sine_cosine(turn_angle(term->cycles, term->cycles_lo, t) + term->phase, &sine, &cosine);
        *value = *value + term->amplitude * sine;
        *rate = *rate + term->amplitude * term->omega * cosine;
    }
}

/* Derivative number `order` of the motion of the base by a formula; `known`: the values along its tape. */
static Real base_output(const Run *r, const Mode *m, const Real *known, int order)
{
    const int output = r->has_base == 2 ? order - 1 : order; /* 2: the formula is that of the velocity */
    return output < 0 ? 0.0 : known[m->base_values.outputs[output]];
}

/* Values along the tape of the motion of the base by a formula, at t. */
static const Real *base_values_at(const Run *r, const Mode *m, Real t)
{
    const TapeRoom *room = &r->taylor.tapes;
    TapeInputs at = room->at;
    at.t = t;
    tape_evaluate(&m->base_values, &at, &at, room->base, room->base + room->ops); /* bounds are of no use here */
    return room->base;
}

void base_motion_at(const Run *r, const Mode *m, Real t, Real *X, Real *V)
{
    if (m->base_values.op_count > 0) {
        const Real *known = base_values_at(r, m, t);
        *X = base_output(r, m, known, 0);
        *V = base_output(r, m, known, 1);
    } else {
        value_and_rate(r->base, r->base_count, t, X, V);
    }
}

Real base_acceleration_at(const Run *r, const Mode *m, Real t)
{
    Real total = 0.0;
    int i;
    if (m->base_values.op_count > 0)
        return base_output(r, m, base_values_at(r, m, t), 2);
    for (i = 0; i < r->base_count; i++) {
        const Harmonic *term = &r->base[i];
        Real sine, cosine;
        rounded_sine_cosine(turn_angle(term->cycles, term->cycles_lo, t) + term->phase, &sine, &cosine);
        total = total - term->amplitude * term->omega * term->omega * sine;
    }
    return total;
}

/* Add the forces by formulas. */
static void add_formulas(const Run *r, const Mode *m, const State *state, Real X, Real V, Real *F)
{
    int i;
    tape_values_at(r, m, state, X, V, NULL);
    for (i = 0; i < m->formula_count; i++) {
        const FormulaForce *one = &m->formulas[i];
        Real value = one->sign * r->taylor.tapes.values[m->tape.outputs[one->output]];
        F[one->to_P] = F[one->to_P] + value;
        if (one->to_Q >= 0)
            F[one->to_Q] = F[one->to_Q] - value;
    }
}

/* Accelerations of all columns at a state in the mode m; returns that of the rotor. */
Real accelerations(const Run *r, const Mode *m, const State *state, Real *out)
{
    Real X, V, value, rate, torque = 0.0, rotor, *F = r->tangent->force;
    int i;
    base_motion_at(r, m, state->t, &X, &V);
    for (i = 0; i < r->columns; i++)
        F[i] = 0.0;
    for (i = 0; i < r->force_count; i++) {
        const Force *force = &r->forces[i];
        int leader = m->leader[force->on];
        value_and_rate(force->terms, force->count, state->t, &value, &rate);
        F[leader] = F[leader] + (value + force->constant);
    }
    for (i = 0; i < m->coupling_count; i++) {
        const Coupling *q = &m->couplings[i];
        Real force = force_of_coupling(r, q, state->x, state->v, X, V);
        F[q->to_P] = F[q->to_P] - force;
        F[q->to_Q] = F[q->to_Q] + force;
    }
    for (i = 0; i < m->constant_count; i++) {
        int leader = m->leader[m->constant_columns[i]];
        F[leader] = F[leader] + m->constants[i];
    }
    if (m->formula_count > 0)
        add_formulas(r, m, state, X, V, F);
    for (i = 0; i < r->rotors.count; i++) {
        const RotorOn *one = &r->rotors.of[i];
        Real w = state->v[one->column];
        int on = m->leader[one->on];
        F[on] = F[on] + one->unbalance * (w * w * cosine_of(state->x[one->column]));
    }
    if (r->has_motor) {
        int on = m->leader[r->motor_on];
        F[on] = F[on] + r->unbalance * (state->w * state->w * cosine_of(state->phase));
        torque = r->M0 - r->drag * state->w;
    }
    rotor = response(r, m, state, F, torque, base_acceleration_at(r, m, state->t), out);
    for (i = 0; i < m->follower_count; i++) {
        const Follower *one = &m->followers[i];
        out[one->column] = out[one->column] + r->taylor.tapes.values[one->place];
    }
    return rotor;
}

/* Entry of the mass matrix between a rotor and its body: u sin phi. */
static Real coupling_of(const RotorOn *one, const State *state)
{
    return one->unbalance * sine_of(state->x[one->column]);
}

/* Acceleration of a group that moves on its own, under the forces and torques F on it and on the rotors that it carries. */
static Real with_rotors(const Run *r, const Mode *m, const State *state, const Real *F, int leader)
{
    Real force = F[leader], mass = m->group_mass[leader];
    int i;
    for (i = 0; i < r->rotors.count; i++) {
        const RotorOn *one = &r->rotors.of[i];
        Real coupling = coupling_of(one, state);
        if (m->leader[one->on] != leader)
            continue;
        force = force + coupling * F[one->column] / one->inertia;
        mass = mass - coupling * coupling / one->inertia;
    }
    return force / mass;
}

/* Accelerations of rotors on bodies and of the groups that they are on. */
static void turn_rotors(const Run *r, const Mode *m, const State *state, const Real *F, Real *out)
{
    int i;
    for (i = 0; i < r->rotors.count; i++) {
        int leader = m->leader[r->rotors.of[i].on];
        if (leader < r->bodies)
            out[leader] = with_rotors(r, m, state, F, leader);
    }
    for (i = 0; i < r->rotors.count; i++) {
        const RotorOn *one = &r->rotors.of[i];
        out[one->column] = (F[one->column] + coupling_of(one, state) * out[m->leader[one->on]]) / one->inertia;
    }
}

/* Accelerations of all columns under forces F on the groups, a torque on the rotor and the acceleration `base` of the base: one
 * division by the mass matrix of the motor and its group; returns that of the rotor.
 */
Real response(const Run *r, const Mode *m, const State *state, const Real *F, Real torque, Real base, Real *out)
{
    Real own, rotor = 0.0;
    int on = r->has_motor ? m->leader[r->motor_on] : -1, c;
    for (c = 0; c < r->columns; c++)
        if (m->leader[c] == c)
            out[c] = c == r->columns - 1 ? base : F[c] * m->mobility[c];
    if (r->rotors.count > 0)
        turn_rotors(r, m, state, F, out);
    if (on >= 0) {
        Real inertia = r->inertia, coupling = r->unbalance * sine_of(state->phase);
        own = out[on];
        if (m->carried == 0) {
            rotor = (torque + coupling * own) / inertia;
        } else {
            Real mass = m->group_mass[on] + r->m3, determinant = mass * inertia - coupling * coupling;
            out[on] = (inertia * F[on] + coupling * torque) / determinant;
            rotor = (mass * torque + coupling * F[on]) / determinant;
        }
    }
    for (c = 0; c < r->columns; c++)
        out[c] = out[m->leader[c]];
    return rotor;
}

/* Whether a body is in a group with others, or with the ground or the base. */
static int is_tied(const Run *r, const Mode *m, int body)
{
    int tied = m->leader[body] != body, d;
    for (d = 0; d < r->bodies; d++)
        tied = tied || (d != body && m->leader[d] == m->leader[body]);
    return tied;
}

/* `vector`, one entry after the other, after the ties of a mode have given tied bodies one velocity. */
static void join_disturbance(const Run *r, const Mode *m, const State *state, Real *vector)
{
    Tangent *b = r->tangent;
    Real *P = b->force, *velocities = b->accelerations, *dv = vector + r->bodies, turning = 0.0, rotor;
    int n = r->bodies, c, i, on = r->motor_on;
    for (c = 0; c < r->columns; c++)
        P[c] = 0.0;
    for (c = 0; c < n; c++)
        P[m->leader[c]] = P[m->leader[c]] + r->masses[c] * dv[c];
    if (r->has_motor) {
        Real inertia = r->inertia, coupling = r->unbalance * sine_of(state->phase), dw = vector[2 * n + 1];
        P[m->leader[on]] = P[m->leader[on]] + (r->m3 * dv[on] - coupling * dw);
        turning = inertia * dw - coupling * dv[on];
    }
    for (i = 0; i < r->rotors.count; i++) {
        const RotorOn *one = &r->rotors.of[i];
        int leader = m->leader[one->on];
        Real coupling = coupling_of(one, state);
        P[leader] = P[leader] - coupling * dv[one->column];
        P[one->column] = P[one->column] - coupling * dv[one->on];
    }
    rotor = response(r, m, state, P, turning, 0.0, velocities);
    for (c = 0; c < n; c++)
        if (is_tied(r, m, c))
            dv[c] = velocities[c];
    for (i = 0; i < r->rotors.count; i++)
        if (is_tied(r, m, r->rotors.of[i].on))
            dv[r->rotors.of[i].column] = velocities[r->rotors.of[i].column];
    if (r->has_motor && is_tied(r, m, on))
        vector[2 * n + 1] = rotor;
}

/* `vector` after rigid stops have come to rest: their ends have one displacement, the centre of mass stays where they
 * move freely.
 */
static void seat_disturbance(const Run *r, Real *vector)
{
    const int *seat = r->tangent->seat;
    int n = r->bodies, leader, c;
    for (leader = 0; leader < r->columns; leader++) {
        Real moment = 0.0, mass = 0.0, common = 0.0;
        int count = leader >= n;
        for (c = 0; c < n; c++)
            if (seat[c] == leader) {
                moment = moment + r->masses[c] * vector[c];
                mass = mass + r->masses[c];
                count++;
            }
        if (count < 2)
            continue;
        if (leader < n)
            common = moment / mass;
        for (c = 0; c < n; c++)
            if (seat[c] == leader)
                vector[c] = common;
    }
}

/* The same of all possible disturbances. */
void seat_disturbances(const Run *r, const Mode *m)
{
    Tangent *b = r->tangent;
    int i;
    seats_of(r, m);
    for (i = 0; i < b->possible; i++) {
        take_vector(b, i, b->vector);
        seat_disturbance(r, b->vector);
        put_vector(b, i, b->vector);
    }
}

/* All possible disturbances after the ties of a mode have given tied bodies one velocity. */
void join_disturbances(const Run *r, const Mode *m, const State *state)
{
    Tangent *b = r->tangent;
    int i;
    for (i = 0; i < b->possible; i++) {
        take_vector(b, i, b->vector);
        join_disturbance(r, m, state, b->vector);
        put_vector(b, i, b->vector);
    }
}
