/* Small disturbances of the state that a run carries along; what the files of the tangent bundle share.
 *
 * Entry k of disturbance i is vectors[k * stride + i]: side by side, those of one entry move by the same operations.
 */
#ifndef VIBSIM_TANGENT_H
#define VIBSIM_TANGENT_H

#include "engine.h"
#include "pair.h"
#include "reading.h"

#define SPANS 100 /* that the growth is recorded in */
#define TANGENT_GROUP 4 /* pairs of disturbances whose series are made side by side */

typedef Real Lane[2];  /* one number of two disturbances */

/* A stop: its columns and its damping; a friction: its columns and the sizes of its force where P slips forwards and backwards. */
typedef struct {
    int P, Q;
    Real c;
} StopEnds;

typedef struct {
    int P, Q;
    Real forward, backward;
} FrictionEnds;

/* What an event does to disturbances: nothing; it moves them, in C by S = I + jump n^T; or tied bodies get their common velocity. */
enum { SAME, MOVED, JOINED };
typedef struct {
    int kind;
    const Mode *before;
    const Event *event;
    Real *jump, determinant;
} Saltation;

/* Responses of the modal coordinates over a piece: q by q0, u0 and load; u by the same. */
typedef struct {
    Real q[3], u[3];
} Moving;

/* Coefficient i + 1 of c w = s', and those of order i of c a1 and s, each twice. */
typedef struct {
    Real turning[2], pull[2], sine[2];
} Joint;

/* Shares that go with the round-off, here as it is for doubles. A piece in which disturbances feel nothing but means of derivatives has
 * an error of the second order in its length, and one of the first in those means: so it is of the size of the root of the round-off.
 */
#define LEFT_OUT (64 * EPS)            /* 2^-47, the most of a disturbance that an approximation may leave out */
#define OF_MEANS sqrt(EPS / 128)       /* 2^-30, the most that means may be wrong by */
#define LEAST_SHARE sqrt(EPS / 524288) /* 2^-36 of a stretch, below which it is not shortened: where a derivative begins at infinity */
#define MOST_ZEROS 8 /* bases of powers that come to zero in one piece */

/* A base of powers that is zero where a piece begins or ends: place on the tape of derivatives, values there, rate, bend. */
typedef struct {
    int place;
    Real first, last, rate, bend;
} Zero;

/* Those of a piece; opening: whether one comes from its zero; mild: whether their powers have exponents above 0 only. */
typedef struct {
    Zero all[MOST_ZEROS];
    int count, opening, mild;
} Zeros;

/* What the recurrences of all disturbances share over a piece of a Taylor step; in `series`, the coefficients of pairs of
 * disturbances: those of component k of a pair begin at k * SERIES.
 */
typedef struct {
    Joint *joint; /* SERIES of them */
    Real first_turning[2];
    Real to_a1, to_w, cross, tau, reach;
    Real (*series)[2], (*force)[2];
    Taylor spare; /* for an expansion within the step */
    TapeRoom step, here; /* series of the derivatives of formulas: along the step, and along an expansion within it */
    const TapeRoom *along; /* that which is prepared */
    Real *entries, prepared_at;
    Rotors spare_rotors;   /* those of `spare` */
    const Rotors *rotors;  /* those that are prepared */
    Real *turning, *pull; /* TAPE_WIDTH of each rotor on a body: c w = s', c a */
    Lane *pushed, *torques; /* series of disturbed accelerations, by pair and group of rotors; by rotor */
    int undefined; /* whether a derivative has no integral over the piece in hand */
    int entry_room, has_step, prepared; /* whether `step` is of the step in hand; whether all is prepared at a time of it */
} TaylorTangent;

/* Events that are crossed almost tangentially. rate: that compares displacements with velocities [rad/s]; by stop the fastest
 * motion of its ends so far and since the last impact, and where that was; closest: least share of a crossing, and its time;
 * count: of shares below CLOSE; undefined: events that have no derivative, and the time of the first.
 */
typedef struct {
    Real rate, *fastest, *since, *struck, closest, closest_time, undefined_time;
    long long count, undefined;
} Tangencies;

/* What an event did, where Python took it: disturbances that are MOVED come from Python, those to be JOINED are left to C. */
typedef struct {
    int here, kind, tangencies, undefined;
    Real determinant, closest;
} Handed;

/* Disturbances, entries dx of each body, dv of each body, then dphi, dw with a motor. The first `possible` of them lie in the
 * tangent space of the mode, the others wait outside. complete: whether they are as many as the scene has exponents; outside:
 * directions that the ties of the mode hold; losses: that ties took since counting began. sums: logarithm of the growth of each;
 * rows: (time, growth by column), at `begin` and at the ends of SPANS equal spans from there; columns: of the rows, by
 * disturbance; lost: whether one has replaced a direction since `begin`. residual: growth of the logarithm of the volume that
 * nothing explains. components: entries that the scene has; shift_from, shift_to, references: see tangent_space.py. weights: of
 * the squared entries.
 */
typedef struct Tangent {
    int given; /* whether disturbances are carried as they are: never orthonormalised */
    int count, possible, size, stride, complete, outside, next_row, row_count, losses, stop_count, friction_count;
    int component_count, shift_count, reference_count;
    int arrived; /* whether the stretch in hand is carried to its very end, which may be beside the grid of time */
    int *seat, *components, *shift_from, *shift_to, *references, *columns, *lost, *over_columns;
    StopEnds *stops;
    FrictionEnds *frictions;
    double pieces;
    Real begin, residual, shortest, t; /* shortest: length that the last orthogonalisation left; t: how far the stretch in hand is carried */
    Real *weights, *vectors, *moved, *sums, *over, *rows;
    Real *fitted, *candidates, *vector; /* of one vector after the other */
    Real *q, *u, *line, *zeros;         /* of modal coordinates; one entry of all */
    Real *accelerations, *other_accelerations, *force, *jump;
    Moving *moving;
    TaylorTangent taylor;
    Tangencies tangencies;
    Handed handed;
} Tangent;

/* Disturbance number i, entry after entry, and back. */
static inline void take_vector(const Tangent *b, int i, Real *vector)
{
    int k;
    for (k = 0; k < b->size; k++)
        vector[k] = b->vectors[k * b->stride + i];
}

static inline void put_vector(Tangent *b, int i, const Real *vector)
{
    int k;
    for (k = 0; k < b->size; k++)
        b->vectors[k * b->stride + i] = vector[k];
}

/* accelerations.c; out: by column; each returns the acceleration of the rotor */
Real accelerations(const Run *r, const Mode *m, const State *state, Real *out);
Real response(const Run *r, const Mode *m, const State *state, const Real *F, Real torque, Real base, Real *out);
void seat_disturbances(const Run *r, const Mode *m);
void join_disturbances(const Run *r, const Mode *m, const State *state);

/* saltation.c */
Saltation saltation(const Run *r, const State *state, const Mode *before, const Mode *after, const Event *event);
void saltation_apply(const Run *r, const Saltation *s, const State *state);
Real gradient(const Run *r, const Mode *m, const Event *event, const Real *vector, int stride);
Real event_rate_at(const Run *r, const State *state, const Mode *m, const Event *event);
void reversal_accelerations(const Run *r, const Mode *m, const State *state, int i, Real *out);

/* tangencies.c */
void tangencies_forget(Tangencies *near);
void tangencies_pass_by(Run *r, const State *state);
void tangencies_struck_at(Run *r, int i, const State *state);
void tangencies_refuse(Tangencies *near, Real t);
void tangencies_note(Tangencies *near, int count, Real share, Real t);
void tangencies_judge(Run *r, const Event *event, const State *state, const Mode *before, const Mode *after);

/* tangent_space.c */
void seats_of(const Run *r, const Mode *m);
int same_seats(const Run *r, const Mode *one, const Mode *other);
/* ...; each gives the number of vectors in b->candidates */
int space_inside(const Run *r, const Mode *m);
int space_outside(const Run *r, const Mode *m);
int space_held(const Run *r, const Mode *m);
void gauge_apply(Tangent *b);

/* tangent_closed_form.c, tangent_taylor.c, tangent_reach.c: the end of the piece from t that is moved at once; a piece */
Real closed_form_piece_end(const Run *r, Real t, Real end, Real mark);
void closed_form_move(Run *r, Real tau);
Real taylor_piece_end(Run *r, Real t, Real end);
void taylor_prepare(Run *r, Real t); /* with formulas: what disturbances share from there on */
/* tau: to `end` or behind it; 0 where the piece is too long: as they were disturbances are in b->moved then. A signal leaves them so. */
int taylor_move(Run *r, Real t, Real end, Real tau);

/* formula_tangent.c; tau: after where all is prepared, by sound_stretch at t */
void formula_slopes_expand(Run *r, TapeRoom *room);
const TapeRoom *formula_slopes_of_step(Run *r);
Real formula_sound_stretch(Run *r, Real t, Real tau);
Zeros formula_zeros(Run *r, Real t, Real end); /* of the piece from t to `end` */
int formula_take_means(Run *r, const Zeros *zeros, Real t, Real tau); /* 0 where there are none: nothing is replaced then */
void formula_rates(const Run *r, Real tau, Real *stiffness, Real *damping);
const Real *formula_damping(const Run *r, Real tau);
Real formula_divergence(const Run *r, Real tau, int on, Real *own, Real *spin);

/* rotor_tangent.c; pushed: of the pair of disturbances */
void rotor_tangent_prepare(Run *r);
void rotor_tangent_turn(const Run *r, Lane *series, int n, const Lane *F, Lane *acceleration, Lane *pushed);

/* Of the series of a pair of disturbances, those of a component. */
static inline Lane *component(Lane *series, int k)
{
    return series + k * SERIES;
}

/* tangent_volume.c */
Real log_volume(const Run *r, Real t, Real end);

/* reading_tangent.c; read gives 0 without memory or where the numbers are no bundle */
int tangent_read(Run *r, Reader *in);

#endif
