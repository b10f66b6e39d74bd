/* The engine: motions of scenes made of parts, in doubles or, where LIMBS is defined, in numbers of so many words (real.h).
 *
 * It knows no part of a scene: it reads the rows of modes, which Python makes when they are met, and asks Python what follows an
 * event where it has no rule. Every expression has one order of operations: compile with -ffp-contract=off and never with -ffast-
 * math, and the bits are the same everywhere.
 */
#ifndef VIBSIM_ENGINE_H
#define VIBSIM_ENGINE_H

#include <math.h>

#include "tape.h"
#ifdef FIXED_SERIES
#include "fixed_series.h"
#endif

#define JET_ORDER 9 /* derivatives taken at the start of a segment: enough for a zero of order FLAT_ORDER - 1 */
#define FLAT_ORDER (JET_ORDER - 3) /* order of a zero that they are too few for */
#define JET (JET_ORDER + 4)
#define NODE_COUNT 12 /* most of a quadrature */
#define FEW_NODES 8
#define TIMES_AT_ONCE 32
#ifdef LIMBS
#define WORK_AT_ONCE 1000
#else
#define WORK_AT_ONCE 100000 /* evaluations of the motion of two bodies between two returns to Python */
#endif
#define UNHURRIED 1e100 /* window of a free mass [s]: longer than any run, yet finite, for 0 times infinity is no bound */
#define MOST_WATCHED 6 /* event functions of a mode whose signs are looked at ahead of the search for zeros */
#define MARCH_LIMIT 1000 /* evaluations of an event function in one march; a longer one needs a new expansion, of tighter bounds */

enum { GAP, PUSH, SLIDE, HOLD, CLEARANCE, STRIKE, SWITCH, DOMAIN_EDGE }; /* kinds of event functions */
enum { DIFFERENCE, RATE, COUPLING, LOAD, ACCELERATION, FORMULA }; /* kinds of terms */
enum { SQUARE, WORK, TORQUE, FUNCTION, IMPULSE, SLIP, RUB };    /* kinds of integrals, see ledger_integrals.py */
enum { IN_CONTACT = 1, AT_REST = 3 };                           /* codes of a stop */
enum { ADVANCE, SAMPLE, SECTION, ARRIVE, EXTREMES, LEDGER, TANGENT, STAGES }; /* of a stretch */
enum { DECIDE_IN_PYTHON, CROSS, STICK_OR_REVERSE, RIGID_IMPACT, CROSS_IF_TIES_HOLD }; /* rules for what follows an event */
enum { START, CONTACT_BEGIN, CONTACT_END, REVERSAL, STICK_BEGIN, STICK_END, VIOLATION_BEGIN, VIOLATION_END, END,
       IMPACT, TRANSMITTED, CHATTER, REST_BEGIN, REST_END, SWITCH_TURN, KINDS };
enum { OK, ACCUMULATION, DIVERGED, UNDECIDED, NO_MEMORY, STANDSTILL, SINGULAR }; /* status of a run */
enum { NOTHING = -1, RATE_ALONE = -JET };
enum { FLOW = 1, ELSEWHERE };

typedef struct {
    Real k, c, offset;
    int P, Q, pair, to_P, to_Q, from, to; /* ends; their difference in the closed form; leading columns; places in the table */
} Coupling;

typedef struct {
    Real coefficient;
    int kind, P, Q, pair, from, to; /* ...; places in the table of Taylor series, -1 for the ground */
} Term;

/* A sum that is one term only, and that of y = share q, or share q + other_share q of a second coordinate: coefficient times y, its
 * rate, or k y + c y' + offset. kind: of the term; NOTHING where a sum is more than that. other: NOTHING without a second one.
 */
typedef struct {
    Real coefficient, share, other_share, k, c, offset;
    int kind, m, other;
} Single;

/* place X + speed V + rest, see reaches.c. */
typedef struct {
    Real place, speed, rest;
} Reach;

/* One group's share in the first derivative of a sliding velocity: factor (sum of terms + constants) / mass. */
typedef struct {
    Real mass, factor;
    int first, terms, first_constant, constants;
    Single single;
} Slope;

/* What follows an event, see rules.c: the modes behind it; the kind and part of what is told of it; the zero behind it. */
typedef struct {
    int kind, target, other, hold, event, part, key, order;
} Rule;

typedef struct {
    Real constant, size;
    int kind, part, key, turns, first, terms, first_slope, slopes;
    Single single;
    Rule rule;
} Event;

/* Constants of y'' + 2 a y' + b y under a load of frequency omega. w0: sqrt(b); wd: damped frequency, or kappa of exp((-a +-
 * kappa) t) above critical damping, where slow and fast are the roots r1 and r2, r1 = b / r2: no cancellation. zr, zi, zz: parts
 * and square of Z = (r1 - i omega)(r2 - i omega); inverse_r, inverse_i: 1 / Z, conjugated. settling, beating: what tells, times
 * t^2 and t^4, from when on responses are quotients. window: time on which bounds of the motion are tight [s]; rate: of the time
 * in power series.
 */
typedef struct {
    Real a, b, omega, w0, wd, slow, fast, zr, zi, zz, settling, beating, window, rate, per_b, per_wd, inverse_r, inverse_i;
    Real *steady_series, *real_series, *imag_series; /* SERIES_TERMS of each, of the coordinate's `series` */
    int oscillates;
} Oscillator;

/* weight (x_P - x_Q), or weight x_P where Q < 0 */
typedef struct {
    Real weight;
    int P, Q;
} Source;

/* factor (sum of signed start positions): load by the place of bodies within their groups */
typedef struct {
    Real factor;
    int first, count;
} Shift;

/* A harmonic load on a coordinate: sine sin + cosine cos; size = |sine| + |cosine|. */
typedef struct {
    Real sine, cosine, size;
    int harmonic;
    Oscillator oscillator;
} Drive;

/* One modal coordinate: q'' + 2 a q' + b q = load + its drives. */
typedef struct {
    Real a, b, load, forced[JET + 1]; /* forced: by n, sum of size omega^n / 2 */
    int is_free, first_source, sources, first_shift, shifts, drive_count;
    int depth; /* orders beyond the event functions' own that these read of its derivatives; RATE_ALONE: nothing but q' */
    Drive *drives;
    Real *series; /* of the oscillators of its drives, or its own */
    Oscillator oscillator;
} Coordinate;

typedef struct {
    Real share;
    int m;
} Share;

/* A column, or a difference of columns: sum share q_m + signed start positions + base X(t). */
typedef struct {
    int first_share, shares, first_fixed, fixed, base;
    const Share *share;
} Place;

typedef struct {
    int column, sign;
} Fixed;

/* load, drives: magnitudes of the terms that the load, and by drive sine and cosine, of a coordinate are sums of; reaches: of
 * itself, its rate and its acceleration.
 */
typedef struct {
    Real load, *drives;
    Reach reaches[3];
} Terms;

/* A mode that has a closed form. window: length of a stretch on which bounds of the motion are tight [s]; pace: the largest of the
 * coordinates' rates [rad/s].
 */
typedef struct {
    Real window, pace;
    Coordinate *coordinates;
    Terms *terms; /* by coordinate */
    Reach *reaches; /* by event function */
    Source *sources;
    Shift *shifts;
    Place *places, *pairs;
    Share *shares;
    Fixed *fixed;
    int count;
} Modal;

typedef struct {
    Real factor, drift;
    int kind, entry, P, Q, source;
} LedgerIntegral;

/* What the ledgers integrate in a mode, and what that reads: velocities by column, forces, the rotor, functions of the rows. */
typedef struct {
    LedgerIntegral *integrals;
    Event *functions;
    int *reads, count, function_count, forces, spins;
} LedgerIntegrals;

typedef struct {
    Coupling *couplings;
    Event *events;
    Term *terms;
    Slope *slopes;
    Real *mobility, *group_mass, *drift, *sides, *constants, *slope_constants, carried; /* sides: of all switches, 0 of one that is not read */
    int *leader, *constant_columns, *codes, *tied; /* tied: bodies under forces that are tied to another column */
    int tied_count, coupling_count, event_count, term_count, constant_count, side_count, untied, shape;
    Coupling small;            /* the one coupling of a small scene; zero without one */
    Real small_constants[2]; /* forces of slipping frictions by column */
    LedgerIntegrals integrals;
    Modal *modal; /* NULL where only Taylor series will do */
    Tape tape, base_tape;      /* formulas of the mode; of the motion of the base */
    Tape base_values;          /* of that motion with its first two derivatives */
    FormulaForce *formulas;
    Follower *followers;
    FormulaSlopes formula_slopes; /* where disturbances are carried */
    int formula_count, follower_count, switch_count; /* switch_count: event functions that are those of switches */
#ifdef FIXED_SERIES
    mutable Scales<SERIES> scales; /* of the series of the rotor, as expansions find them */
#endif
} Mode;

typedef struct {
    Real amplitude, omega, cycles, cycles_lo, phase;
    int harmonic; /* among the distinct ones; -1 without amplitude */
} Harmonic;

typedef struct {
    Real constant;
    Harmonic *terms;
    int on, count;
} Force;

typedef struct {
    Real t, phase, turns, w, *x, *v;
} State;

/* Why a stretch or an event is not proved, see certificate.h; as in vibsim/engine/doubts.py */
enum { DECISION, WHICH_IS_FIRST, TOUCH_OR_MISS, TOO_SHORT_STEPS, WHICH_SIDE, RESTS_AT_ZERO };
#define MOST_DOUBTS 8 /* that are described */

/* A doubt: near which time [s], for which reason, and the event functions in doubt by their numbers in the mode of then, or NOTHING. */
typedef struct {
    Real at;
    int reason, mode, event, other;
} Doubt;

/* mode: of now; watched: the event function whose zeros are looked for, by its number in that mode */
typedef struct {
    Real margin, margin_time, first_doubt, doubted;
    double uncertified;
    int mode, watched;
    Doubt doubts[MOST_DOUBTS]; /* the first ones */
} Certificate;

/* Coefficient n of displacement c is table[n * stride + c], of its rate table[n * stride + rates + c]; columns as in
 * `column_in_table`, phi and w in that of number `bodies`.
 */
typedef struct {
    Real *table, *values;
    Real *load, **loaded_on; /* series of the forces, by column; NULL where there is none */
    Real *inverse, *sine, *cosine, *w_back, *a1_back; /* w_back[order - n]: order n */
    Real h, turns, longest; /* longest: piece of a step that one quadrature rule takes [s] */
    Real nearest; /* time [s] within which zeros of bases of powers are zeros in any case */
    Real *latest, latest_at; /* columns where they were asked for last, and when [s]; 0: nowhere */
    Real spin_rate, spin_rate_at; /* of the rotor's speed, where it is known, and when [s]; 0: nowhere */
    Real *checked, checked_at; /* columns at the end of the step and before it, where formulas are compared; the former [s], or 0 */
    int order, most, next, since; /* of the series in hand, of those behind an event, of the next ones; steps behind that event */
    int rates, stride, *loaded, loaded_count, few_nodes;
    unsigned clear; /* bits: event functions that are known to stay positive on the whole step */
    Real *acceleration; /* by leading column, where a mode has formulas or rotors */
    TapeRoom tapes, base_tapes; /* of the formulas of modes; of the motion of the base */
#ifdef FIXED_SERIES
    Digits (*rotor)[SERIES];    /* series of the rotor, `Scales` of the mode says how */
    const Scales<SERIES> *scales; /* NULL where there are none, or a coefficient did not fit */
    FixedTable *fixed;     /* the table, where values are asked for */
    Rest rest;             /* orders in doubles; first: 0 where there are none */
#endif
} Taylor;

/* Rotors on bodies, and of the step in hand: series of sine, cosine and speed of each, of the acceleration of each group that some
 * are on, its mass less what its rotors take part of it with, one by that, and its leading column; of each order torque and pull of a rotor;
 * lean: what its torque pulls with.
 */
typedef struct {
    RotorOn *of;
    Real *sine, *cosine, *acceleration, *speed; /* TAPE_WIDTH of each */
    Real *mass, *mobility, *torque, *pulled, *lean;
    int count, groups, *leaders;
} Rotors;

/* Of an event function: the rest of a known zero, and its reach. */
typedef struct {
    Real residue, reach;
} RoundingBound;

typedef struct {
    Real t, reach, window, stall, settled;
    Real (*watched)[5]; /* by event: time, value, slope, curvature, bound of a gap function */
    RoundingBound *rounding_bounds; /* by event */
    int *events, event_count, leading, measured; /* measured: whether the close scales of coordinates are those of here */
} Search;

typedef struct {
    Real load_sine, load_cosine, hc, hs, dc, ds;
} Response;

/* What the rounding of a coordinate, its rate and its acceleration is proportional to, see rounding.c. */
enum { PLAIN, CLOSE, MEASURES };
typedef struct {
    Real q, u, a;
} Scale;

/* A coordinate in the present segment: its derivatives, start, and the terms that make it at the point evaluated last. */
typedef struct {
    Real jet[JET + 1], q0, u0, load, stiff, impulse, steady;
    Response *responses; /* by drive */
} Motion;

/* At many times: cosine and sine of the harmonics' angles since the anchor; coordinates and their rates. */
typedef struct {
    Real (*cosine)[TIMES_AT_ONCE], (*sine)[TIMES_AT_ONCE], (*q)[TIMES_AT_ONCE], (*u)[TIMES_AT_ONCE];
    int count;
} Times;

typedef struct {
    Motion *motions; /* by coordinate */
    Response *responses;
    Real *sin0, *cos0, *sines, *cosines, *sine, *cosine; /* by harmonic: at the anchor, here, and of the angle between */
    Times times;
    Real *x0, *v0, *rest, base[JET + 1]; /* rest: of each body, what does not move in this segment */
    Real tau, counted; /* the time that all this is of; that of the last evaluation, by itself or among many */
    Search search;
    Scale *scales[MEASURES]; /* by coordinate */
} ClosedForm;

/* A stop whose stored energy is lost where it lets go though pressed. */
typedef struct {
    Real gap, k;
    int stop, entry, P, Q, sense;
} Jump;

/* Values at the nodes of the quadrature. */
typedef struct {
    Real (*v)[NODE_COUNT], (*force)[NODE_COUNT], (*function)[NODE_COUNT], w[NODE_COUNT], *series; /* series: SERIES of each */
    int *lengths, function_room;
} Nodes;

/* Entries of the ledgers, of the stretches that are done; `open`: of the stretch in hand as far as `tau` from the anchor. */
typedef struct {
    Real *entries, *open, tau;
    Jump *jumps;
    int wanted, count, jump_count;
    Nodes nodes;
} Ledger;

/* Stroboscopic section of a scene without motor: a period is `turns` turns of a harmonic, 0 where there is none; or a
   turn of a rotor, whose number is one less than `rotor`, 0 where none turns the scene. */
typedef struct {
    Real cycles, cycles_lo, turns, next; /* ...; the next period, or turn of the rotor in the present stretch */
    int rotor;
} Section;

/* A stop whose gap is watched: its place among the parts and among the pairs. */
typedef struct {
    int stop, pair, sense;
    Real gap;
} Gap;

/* Extremes of x_P - x_Q of `pairs` pairs of columns and of the rotor's speed: low and high in the present period (of the speed in all),
 * least and greatest in all; node: values, then rates, where the stretch is worked out to; count is 0 where nothing is kept.
 */
typedef struct {
    int pairs, count, gap_count, based, has_node, *P, *Q;
    Real since, at, *numbers, *low, *high, *least, *greatest, *node, *ahead, *here, *margins;
    Gap *gaps;
} Extremes;

/* A rigid stop: its number, ends, and the entries of the ledgers that an impact adds to, -1 for none. */
typedef struct {
    Real gap, e;
    int stop, P, Q, sense, loss, work, impulse;
} RigidStop;

/* A friction: its ends and the velocity of its belt. */
typedef struct {
    Real belt;
    int P, Q;
} Rubbing;

/* An elastic stop or a clearance: its ends and where it closes. */
typedef struct {
    Real gap;
    int P, Q, sense;
} Bound;

/* What an impact may change: rigid stops and frictions in the order of their numbers, elastic stops, clearances; none where none
 * were told of. `codes`: of the mode behind an impact; kinds, parts: of the events that it makes. early: see
 * vibsim/engine/events/impacts/chatter.py
 */
typedef struct {
    RigidStop *stops;
    Rubbing *frictions;
    Bound *bounds;
    int stop_count, friction_count, bound_count, early, *codes, *kinds, *parts;
} Impacts;

/* An impact: rates of the depth before and after it, impulse, speeds of its ends in front of it; position and velocity of the
 * base; the mode behind it and how many events it makes.
 */
typedef struct {
    const RigidStop *stop;
    Real before, after, impulse, size, X, V;
    int target, happened;
} Impact;

/* A run: everything between two calls. */
typedef struct Run {
    int bodies, columns, parts, clearances, switches, harmonic_count, key_count, mode_count, force_count, base_count;
    int slope_ops, slope_entries; /* most of a mode's derivatives of formulas */
    int tapes_read;
    int has_motor, motor_on, rest_columns, force_taylor, stop_on_violation, closed; /* closed: the flow in use */
    int has_base, *alone, alone_count; /* has_base: be it by a formula; alone: columns of units of their own, of rotors and states */
    Real m3, e, M0, unbalance, inertia, drag, t_end, every_num, every_den;
    double tolerance_exponent;
    Harmonic *harmonics, *base;
    Force *forces;
    Mode **modes;
    const Mode *mode;
    int mode_number, event_room, *known, *behind; /* order of the zeros at the start of the segment, and behind an event, by key */
    Real *masses;
    State state, next, scratch;
    Real known_since, first_violation, t0;
    Real samples_from, section_from; /* times before which neither is recorded [s]; the state at the former is kept */
    Real pause; /* time at which a call of `advance` ends [s] */
    State at_begin; /* at samples_from, once that is reached; its time is negative until then */
    double evaluations, steps, steps_beside, counts[KINDS]; /* steps_beside: of the steps, those taken beside other runs */
    Real progress_deadline; /* time up to which `stretches` are counted */
    int stretches, dither;
    unsigned dithered; /* events so far whose times were moved by `dither` */
    unsigned long long kicks; /* state of the generator that the signs of kicks are drawn from; 0: none, see driver.c */
    Certificate certificate;
    long long next_sample;
    int events_at_instant, finished, status, violated_once, stage, pending_event; /* stage: of the stretch in hand, which may take many calls */
    int abreast, waits; /* whether the run is one of several that take steps together; and waits for its next one */
    int arrived; /* whether `next` is the state at the end of that stretch */
    int singular; /* output of the tape that no step is short enough for, where the status is SINGULAR */
    Real pending_tau, *before_v, before_w; /* from the start of the flow to the pending event [s]; velocities in front of it */
    Real pending_end, *force;
    double spent, work_at_once;
    double unheard; /* work of an expansion since signals were looked for last */
    int hears, interrupted; /* whether an expansion may be given up for a signal; what was, and is to be made anew: FLOW, ELSEWHERE or 0 */
    Ledger ledger;
    Section section;
    Extremes extremes;
    Impacts impacts;
    Taylor taylor;
    Rotors rotors;
    ClosedForm closed_form;
    struct Tangent *tangent; /* small disturbances that it carries along; NULL where there are none */
} Run;

enum { ANY, TWO_FREE, TWO_HELD, ONE, FORMULAS }; /* shapes of the recurrences: see taylor_expansion.c */

/* Place of a column among the displacements in the table of Taylor series: bodies, phi, ground, base. */
static inline int column_in_table(const Run *r, int column)
{
    return column < r->bodies ? column : column + 1;
}

static inline int base_column(const Run *r)
{
    return r->bodies + 2;
}

/* responses.c */
void oscillator_set(Oscillator *o, Real a, Real b, Real omega);

/* polynomial_root.c; what became of the search for a zero within a step */
enum { POSITIVE, ZERO, UNFINISHED };
int polynomial_first_root(Certificate *c, const Real *coefficients, int count, int known, Real t0, Real h, int keep_margin,
                          int sharp, Real *end);
Real polynomial_nearer(const Real *coefficients, int count, Real t0, Real h, Real size);
int polynomial_near_zero(const Real *coefficients, int count, int known, Real tau, Real size, Real *value,
                         Real *slope, Real *noise); /* returns 0 where it rests at zero */

/* step_length.c */
Real step_length(const Run *r);
void tune_order(Run *r); /* take the order of the next step of the stretch, in modes with formulas */

/* taylor.c */
void taylor_set(Run *r);
void taylor_open(Run *r, const State *state);
void taylor_look(Run *r, const State *state); /* expand the motion there; no step follows */
void taylor_enter(Run *r, const State *state);
void taylor_continue(Run *r, const State *state); /* the same where the stretch goes on */
void taylor_values(const Taylor *f, Real tau, Real *out); /* of all columns of the table */
void taylor_values_twice(const Taylor *f, const Real *tau, Real *out);
Real taylor_advance(Run *r, Real limit, int *event);
const Real *taylor_columns(Run *r, Real tau); /* a time tau [s] after the expansion point; hold until the next call */
const Real *taylor_columns_at_start(Run *r); /* for who reads a motion there; no state is taken from them */
void taylor_state_after(Run *r, Real tau, State *out);
void taylor_samples(Run *r, const Real *tau, int count, Real *row, long room);
Real taylor_spin_rate(const Run *r, Real tau);
int taylor_near_zero(const Run *r, const Event *e, Real tau, Real *value, Real *slope, Real *noise);

/* taylor_loads.c, taylor_expansion.c, taylor_polynomial.c; those of terms and event functions return how many coefficients there are */
void taylor_expand_base(Run *r, Real t);
void taylor_expand_loads(Run *r, Real t);
void taylor_expand(Run *r, const State *state);
#ifdef FIXED_SERIES
/* digits_by_order.cpp: the orders from `first` on of the series of a small scene, far: its second column; how right an expansion by
 * taylor.scales was, and what that tells the next one in this mode
 */
void last_orders(Run *r, int first, int bodies, int moving, int far);
double bits_to_spare(const Run *r);
void set_digits(Run *r, double spare);
#endif
#ifdef WORDS_BY_RUN
/* module.c: whether a signal ends the expansion, of which order n is to come: one in 1000 digits takes seconds; or other work, of so many
 * products since this was asked last. The error is set then.
 */
int is_interrupted(Run *r, int n);
int hears_signal(Run *r, double products);
#else
#define is_interrupted(run, n) 0
#define hears_signal(run, products) ((void)(products), 0)
#endif
int taylor_term(const Run *r, const Term *t, Real *out);
int taylor_polynomial(const Run *r, const Event *e, Real *out);
Real taylor_magnitude(const Run *r, const Event *e);

/* taylor_rounding.c: bounds of the derivatives of order 0 to `count` of an event function where the motion was looked at; exact: whether
 * the state there is a start, and not what a motion led to; summed: whether the constant of the function is rounded. span: time [s] before
 * that state for which its series are taken to tell how large displacements and velocities were, whose rounding it has, however
 * small it is itself; 0 for its own. 0 without memory.
 */
int taylor_bounds(const Run *r, const Event *e, int count, int exact, int summed, Real span, Real *out);

/* formula_step.c; shorten_step sets the status SINGULAR where no step is short enough */
void tape_values(const Run *r, Real tau);
void tape_values_at(const Run *r, const Mode *m, const State *state, Real X, Real V, const Real *rates);
void shorten_step(Run *r);
Real overflowing_zero(const Tape *tape, const TapeRoom *room, int count);

/* rotors_on_bodies.c */
void rotors_expand(Run *r);
void rotors_turn(Run *r, int n);
void rotors_thrust(const Run *r, int column, Real *out); /* adds to it */

/* memory.c */
void keep_freed_memory(void);

/* flat_zeros.c */
int leaves_flat(const Run *r, const State *state);

/* closed_form.c */
void closed_form_enter(Run *r, const State *state);
int closed_form_dimension(const Run *r);
void closed_form_evaluate(Run *r, Real tau);
void closed_form_jets(Run *r, int n);
Real harmonic_turned(const ClosedForm *f, const Harmonic *term, int quarters);
void closed_form_state_after(Run *r, Real tau, State *out);

/* rounding.c */
void measure_start(Run *r);
void measure_plainly(Run *r);
void measure_closely(Run *r);

/* reaches.c */
void reaches_set(Mode *m);

/* closed_form_times.c */
void closed_form_many(Run *r, const Real *tau, int count);
void closed_form_sines(const Run *r, int harmonic, Real *out);
void closed_form_base(const Run *r, Real *X, Real *V);
void closed_form_body(const Run *r, int c, const Real *X, const Real *V, Real *x, Real *v);

/* closed_form_search.c */
void closed_form_open(Run *r);
Real closed_form_advance(Run *r, Real limit, int *event);

/* recording.c; samples returns 0 when the buffer is full before the end of the stretch */
typedef struct {
    Real *samples;           /* rows of sample_room: time, x, v of each body, phi, w */
    signed char *sample_modes; /* rows of sample_room: one per part */
    Real *events;            /* rows of event_room: t, x, v of each body, phi, w, phase; v, w in front of it; sides of switches */
    signed char *event_codes;  /* rows of event_room: kind, part, one per part */
    Real *section;           /* rows of section_room, as samples, then extremes; none where section_room is 0 */
    long sample_room, event_room, section_room, sample_count, event_count, section_count;
} Buffers;

long long sample_index(const Run *r, Real t);
void record_begin(Run *r);
void write_state(const Run *r, Real *row, long room, const State *s);
void write_codes(const Run *r, signed char *row, long room, int count);
void record_event(Run *r, Buffers *b, int kind, int part, const Real *v, Real w);
void record_zeros(const Run *r, Buffers *b, long first);
int record_samples(Run *r, Buffers *b);

/* driver.c */
void flow_state(Run *r, Real t, State *out);
void run_rewind(Run *r, Real t_end);
void run_start(Run *r, int mode, Buffers *b);
void run_advance(Run *r, Buffers *b);
void runs_advance(Run **runs, Buffers **buffers, int count, int widest);
void run_arrive(Run *r);
void run_take(Run *r, Buffers *b, int mode, int happened, const int *kinds, const int *parts);
Real run_worked_to(const Run *r);
int run_state_at(Run *r, Buffers *b, Real t, State *out);

/* accelerations.c: displacement, velocity and acceleration of the base in the mode m */
void base_motion_at(const Run *r, const Mode *m, Real t, Real *X, Real *V);
Real base_acceleration_at(const Run *r, const Mode *m, Real t);

/* impacts.c; take returns 0 where Python has to decide */
int impact_take(Run *r, const Event *event, Impact *done);
void impact_count(Run *r, const Impact *done);

/* order_of_events.c: whether it matters which of two events at one instant comes first, whose functions have one value and one slope */
int order_is_open(const Run *r, const Event *one, const Event *other);

/* rules.c; take returns 0 where Python has to decide */
int rule_take(Run *r, Buffers *b);
void review_zeros(Run *r, const Mode *left); /* of the mode of now, behind `left`: those of events before the last at the same instant */
Real derivative_at_next(Run *r, const Mode *m, int key, int order);
Real forces_of(const Run *r, const Mode *m, const State *state, Real X, Real V);

/* ledger.c; gather returns 0 when the work of one call is spent before the stretch is done */
void ledger_open(Run *r);
int ledger_gather(Run *r);
Real longest_piece(const Run *r, Real tau);
void ledger_cross(Run *r, const State *state, const int *before, const int *after);

/* tangent_bundle.c, reading_tangent.c; gather returns 0 when the work of one call is spent before the stretch is done */
void tangent_open(Run *r);
void tangent_begin_stretch(Run *r);
int tangent_gather(Run *r);
void tangent_cross(Run *r, int event, const Mode *before, const Mode *after);
Real tangent_worked_to(const Run *r);
void tangent_free(struct Tangent *b);

/* extremes.c; `until` returns 0 when the work of one call is spent before, where that is bounded */
void extremes_reset(Extremes *e);
void extremes_open(Run *r);
int extremes_until(Run *r, Real end, int bounded);
void extremes_close(Run *r, Real *row, long room);

/* section.c; gather returns 0 when the buffer is full before the stretch is done */
void section_start(Run *r);
int section_gather(Run *r, Buffers *b, Real end);

#endif
