/* The C engine: the fast copy of the Python engine, bit for bit equal to it on doubles.
 *
 * Every expression repeats its Python twin operation by operation; compile with -ffp-contract=off and never with
 * -ffast-math. numbers.h, pair.h, first_root.h and turning_point.h are those of ../engine. Twins: responses.c flows/responses.py,
 * regime.c flows/regime.py, closed_form.c flows/closed_form.py, event_functions.c flows/event_functions.py, closed_form_search.c
 * events/closed_form_search.py, taylor.c flows/taylor.py, polynomial_root.c events/polynomial_root.py, certificate.h
 * events/certificate.py, turning_point.h events/turning_point.py,
 * automaton.c events/automaton.py, driver.c kernel/driver.py, stroboscopic.c kernel/stroboscopic.py, ledger.c kernel/ledger.py,
 * closed_form_tangent.c flows/closed_form_tangent.py, taylor_tangent.c flows/taylor_tangent.py, taylor_volume.c
 * flows/taylor_volume.py, tangencies.c events/tangencies.py and events/saltation.py, tangent_bundle.c kernel/tangent_bundle.py.
 */
#ifndef VIBSIM_KERNEL_H
#define VIBSIM_KERNEL_H

#include <math.h>

#define MAX_ORDER 40
#define JET_ORDER 9 /* derivatives of y taken at the start of a segment */
#define SERIES (MAX_ORDER + 2)
#define SERIES_TERMS 26
#define SPANS 100 /* that the growth of disturbances is recorded in */
#define WORK_AT_ONCE 1e5 /* evaluations of the motion that one call may spend: some 20 ms, so that Ctrl-C is soon heard */
#define EPS 1.1102230246251565e-16 /* 2^-53, unit round-off */

enum { NOTHING = -1, GAP = 0, SLIDE = 1, HOLD_PLUS = 2, HOLD_MINUS = 3, CLEARANCE = 4, FUNCTIONS = 5 };
enum { START, CONTACT_BEGIN, CONTACT_END, REVERSAL, STICK_BEGIN, STICK_END, VIOLATION_BEGIN, VIOLATION_END, END, KINDS };
enum { X1, X2, PHI, V1, V2, W, STATES }; /* columns of a table of Taylor coefficients */
enum { DY, DV1, DV2, DPHI, DW, DISTURBANCE }; /* components of a disturbance, y = x1 - x2 */
enum { ADVANCE, SAMPLE, SECTION, ARRIVE, LEDGER, TANGENT, STAGES }; /* of one stretch, in this order */
enum { OK = 0, ACCUMULATION = 1, DIVERGED = 2 };

/* Numbers of a scene, in the order in which vibsim.kernel.c_engine packs them. */
typedef struct {
    double m1, m2, k1, c, k2, G, stop_sign, N;
    double A, F0, omega, cycles, cycles_lo;
    double m3, e, J, M0, Omega0;
    double x1, v1, x2, v2, phi, phidot;
    double rest_distance, t_end, every_num, every_den, tolerance_exponent, order;
    double has_block2, has_stop, has_friction, has_motor, harmonic, has_rest, stop_on_violation, at_stop, at_rest;
    double closed_form, ledger;
    double tangent, tangent_from;
} Scene;

typedef struct {
    double t, x1, v1, x2, v2, phase, turns, w;
} State;

typedef struct {
    int contact, friction, violated;
} Mode;

/* Known zeros at the start of a segment: order by event function. */
typedef struct {
    int order[FUNCTIONS];
} Known;

typedef struct {
    double a, b, omega, w0, wd, slow, fast, zr, zi, zz, settling, beating, window, rate, per_b, per_wd, inverse_r, inverse_i;
    double steady_series[SERIES_TERMS], real_series[SERIES_TERMS], imag_series[SERIES_TERMS];
    int oscillates;
} Oscillator;

typedef struct {
    Oscillator oscillator;
    double k, offset, load, amplitude, centre_load, centre_amplitude, forced[JET_ORDER + 1];
} Regime;

typedef struct {
    double t, reach, window, stall;
    double watched_t, watched_value, watched_slope, watched_curvature, watched_bound; /* the gap function, at its last point */
    double residues[FUNCTIONS]; /* what is left of a known zero by the rounding of the segment before */
    int functions[FUNCTIONS], function_count, leading; /* those of the mode that do not rest at zero */
} ClosedFormSearch;

typedef struct {
    Regime regimes[2][2][3]; /* locked, contact, friction + 1 */
    Oscillator mass_point;
    ClosedFormSearch search;
    double limit, omega, share1, share2, settled;
    double t0, x2, y0, u0, X0, V0, sin0, cos0;
    double load_sine, load_cosine, centre_sine, centre_cosine;
    double y, u, X, V, tau, sine, cosine, stiff, impulse, steady, hc, hs, dc, ds, centre_dc, centre_ds;
    double scale_y, scale_u, scale_V;
    int driven, locked, regime[3];
} ClosedForm;

typedef struct {
    double table[SERIES][STATES]; /* coefficients n of all states */
    double inverse[SERIES + 1], sine[SERIES], cosine[SERIES]; /* of the rotor angle; kept for disturbances only */
    double limit, unbalance, per_m1, per_m2, k, offset, t0, h, turns;
    int order, locked;
} Taylor;

typedef struct {
    double margin, margin_time, uncertified, first_doubt, doubted;
} Certificate;

typedef struct {
    double rate, fastest, closest, time, count;
} Tangencies;

/* Disturbances carried along, and the logarithms of their growth. */
typedef struct {
    double vectors[DISTURBANCE][DISTURBANCE], weights[DISTURBANCE], sums[DISTURBANCE], begin, residual, losses, pieces;
    double reach, dragging; /* of the Taylor flow: length of a piece [rad], drag of the motor [1/s] */
    double rows[SPANS + 1][DISTURBANCE + 1];
    int count, complete, stuck, row_count, next_row;
    Tangencies tangencies;
} Tangent;

/* The integrals of a stretch as far as the ledger has taken them: tau from the anchor [s], energies [J]. */
typedef struct {
    double tau, work, viscous;
} OpenStretch;

/* A run: everything between two calls. */
typedef struct {
    Scene scene;
    State state;
    Mode mode;
    Known known;
    int functions[FUNCTIONS], function_count;
    double known_since, first_violation;
    Certificate certificate;
    double work, viscous, friction_loss, energy_start, stored; /* the energy ledger [J], of the stretches that are done */
    double evaluations, steps, counts[KINDS];
    double period; /* of the ideal source, whose end is the next section point */
    long long next_sample;
    int crowd, finished, status, violated_once;
    int stage, function; /* of the stretch in hand, which may take many calls; the event function that ends it */
    double end, carried, spent; /* of that stretch; tangents are carried to here [s]; work of this call */
    State arrival;
    OpenStretch open;
    ClosedForm closed;
    Taylor taylor;
    Tangent tangent;
} Run;

/* responses.c */
void oscillator_set(Oscillator *o, double a, double b, double omega);
void release_and_impulse(const Oscillator *o, double t, double *release, double *impulse);
double constant_response(const Oscillator *o, double t, double release);
void harmonic_response(const Oscillator *o, double t, double release, double impulse, double cosine, double sine,
                       double *hc, double *hs, double *dc, double *ds);
void free_harmonic_response(const Oscillator *point, double t, double cosine, double sine, double *hc, double *hs);

/* regime.c */
void closed_form_set(Run *r);

/* closed_form.c */
const Regime *regime_of(const ClosedForm *f);
void closed_form_enter(Run *r, const State *state, Mode mode);
void closed_form_evaluate(Run *r, double tau);
void closed_form_measure(ClosedForm *f);
void closed_form_jet_here(const ClosedForm *f, int count, double *d);
double closed_form_longest_piece(const Run *r, double tau);
void closed_form_state_after(Run *r, double tau, State *out);
void closed_form_jet(Run *r, const State *state, Mode mode, int count, double *jet);

/* event_functions.c; d: derivatives of x1 - x2 at the point evaluated last */
double event_derivative(const Run *r, int function, const double *d, int n);
double event_bound(const Run *r, int function, const double *d, int n, double reach);
double event_noise(const Run *r, int function);

/* closed_form_search.c */
void closed_form_open(Run *r);
double closed_form_advance(Run *r, double limit, int *function);

/* taylor.c */
void taylor_set(Run *r);
void taylor_enter(Run *r, const State *state, Mode mode);
double taylor_advance(Run *r, double limit, int *function);
void taylor_state_after(Run *r, double tau, State *out);
void taylor_jet(Run *r, const State *state, Mode mode, int count, double *jet);

/* polynomial_root.c; what became of the search for a zero within a step */
enum { POSITIVE, ZERO, UNFINISHED };
int polynomial_first_root(Run *r, const double *coefficients, int count, int known, double t0, double h, int keep_margin,
                          double *end);
int polynomial_near_zero(const double *coefficients, int count, int known, double tau, double size, double *value,
                         double *slope, double *noise); /* returns 0 where it rests at zero */

/* automaton.c */
void watch(Run *r, Mode mode);
void initial_mode(Run *r);
int transition(Run *r, State *state, int function, Mode *mode, Known *known);

/* flow by method */
void flow_enter(Run *r, const State *state, Mode mode);
void flow_jet(Run *r, const State *state, Mode mode, int count, double *jet);
void flow_state(Run *r, double t, State *out);
void flow_state_after(Run *r, double tau, State *out);
double flow_anchor(const Run *r);
double flow_advance(Run *r, double limit, int *function);
double flow_longest_piece(const Run *r, double tau);

/* ledger.c; gather returns 0 when the work of one call is spent before the stretch is done */
double ledger_energy(const Run *r, const State *state, Mode mode);
void ledger_open(Run *r);
int ledger_gather(Run *r);

/* closed_form_tangent.c, taylor_tangent.c; a move returns the logarithm of the growth of a volume */
double closed_form_tangent_piece_end(const Run *r, double t, double end, double mark);
double closed_form_tangent_move(Run *r, double t, double end);
void taylor_tangent_set(Run *r);
double taylor_tangent_piece_end(const Run *r, double t, double end);
double taylor_tangent_move(Run *r, double t, double end);

/* taylor_volume.c */
double taylor_log_volume(const Run *r, double tau);

/* tangencies.c */
double reversal_factor(const Run *r, const State *state, int contact);
void tangencies_forget(Tangencies *t);
void tangencies_pass_by(Tangencies *t, const State *state);
void tangencies_judge(Run *r, int kind, const State *state, Mode before);

/* tangent_bundle.c; gather as in ledger.c */
void tangent_start(Run *r);
int tangent_gather(Run *r);
void tangent_cross(Run *r, int kind, const State *state, Mode before);

/* driver.c; every call returns after bounded work, run_state_at with 0 when it has to be called again */
typedef struct {
    double *samples;            /* 7 columns of sample_room: time x1 v1 x2 v2 phi phidot */
    signed char *sample_modes;  /* 2 columns of sample_room: contact friction */
    double *events;             /* 8 columns of event_room: t x1 v1 x2 v2 phi phidot phase */
    signed char *event_codes;   /* 3 columns of event_room: kind contact friction */
    double *section;            /* 7 columns of section_room, as samples; none where section_room is 0 */
    long sample_room, event_room, section_room, sample_count, event_count, section_count;
} Buffers;

void write_state(double *row, long room, const State *s);
void run_start(Run *r, const Scene *scene, const State *resume, const Mode *mode, const Known *known, Buffers *b);
void run_advance(Run *r, Buffers *b);
double run_worked_to(const Run *r);
int run_state_at(Run *r, double t, State *out);

/* stroboscopic.c; section_gather returns 0 when the buffer is full before the stretch is done */
void section_start(Run *r);
int section_gather(Run *r, Buffers *b, double end);

#endif
