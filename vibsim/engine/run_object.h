/* The type Run of Python, and its methods that stand in files of their own. */
#ifndef VIBSIM_RUN_OBJECT_H
#define VIBSIM_RUN_OBJECT_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include <string.h>

#include "modes.h"
#include "tangent.h"

enum { BUFFERS = 5 };

typedef struct {
    PyObject_HEAD
    Run run;
    Buffers buffers; /* what is filled, of the arrays in `views` */
    Py_buffer views[BUFFERS];
    int started, busy, looked, view_count, bits; /* looked: whether a state was, see run_look.c; bits: of numbers that are no doubles */
} RunObject;

/* A number as an object of Python, and back as a converter of PyArg_ParseTuple. */
#ifdef LIMBS
/* number_object.cpp; also what Python calls of it, and whether so many bits can be had */
PyObject *number_object(const Real &x);
int number_from(PyObject *object, void *out);
int numbers_ready(void);
int bits_fit(int bits);
extern PyMethodDef number_functions[];
#else
/* What Python calls of the module of doubles alone: of module.c, several runs side by side; of double_functions.c, sines of arrays; of
 * matrices.c; of roots_alone.c.
 */
#define DOUBLE_FUNCTIONS(F) \
    F(advance_together, advance_together, \
      "advance_together(runs, widest) -> list of what `advance()` gives of each of up to 64 runs in a tuple, computed side by side;\n" \
      "None of a run that waits for the next call, because another one has stopped.\n" \
      "widest: lanes in a vector at most, where fewer than the processor has are wanted; 0: none.") \
    F(sines_cosines, sines_cosines, "sines_cosines(angles, sines, cosines): of arrays of doubles, the last two to be filled.") \
    F(product, matrix_product, "product(a, b, out): matrix product; vectors are a row a, a column b") \
    F(dot, matrix_dot, "dot(a, b) -> sum of the products of two vectors") \
    F(solved, matrix_solved, "solved(a, b, x) -> smallest pivot, 0 where a is singular: x with a x = b") \
    F(determinant, matrix_determinant, "determinant(a)") \
    F(singular, matrix_singular, "singular(a, out) -> whether a is finite; out: values, V and W of a (m, n), n (1 + n + m) doubles") \
    F(first_root, root_first, \
      "first_root(coefficients, known, t0, h, keep_margin) -> (0: positive on the whole step, 1: a zero, 2: unproved behind it; " \
      "time, doubts, margin and when), see events/roots/polynomial_root.c") \
    F(safe_step, root_safe_step, "safe_step(value, slope, bound of the curvature): a step that passes no zero") \
    F(deflated_step, root_deflated_step, "deflated_step(order, leading, following, bound): one behind a zero") \
    F(eigenvalues, matrix_eigenvalues, "eigenvalues(a, out) -> whether they were found; out (n, 2)")

#define FUNCTION_OF_DOUBLES(name, function, text) PyObject *function(PyObject *module, PyObject *args);
DOUBLE_FUNCTIONS(FUNCTION_OF_DOUBLES)
#undef FUNCTION_OF_DOUBLES
extern PyMethodDef double_functions[];
#define number_object PyFloat_FromDouble

static inline int number_from(PyObject *object, void *out)
{
    double value = PyFloat_AsDouble(object);
    if (value == -1 && PyErr_Occurred())
        return 0;
    *(double *)out = value;
    return 1;
}
#endif
extern PyMethodDef elementary_functions[]; /* function_objects.c: of either kind of numbers */

/* module.c: a packed state; 0, or -1 where an error is set */
int read_state(const Run *r, const Py_buffer *view, State *s);

/* The methods of Run, each by a function Run_<name>: what a run is told of before its start, modes as they are met, and jumps, in
 * run_setup.c; what it has come to in run_outcome.c; what a run that is only looked through tells in run_look.c; the others in module.c.
 */
#define RUN_METHODS(M) \
    M(add_mode, METH_VARARGS, "add_mode(ints, doubles) -> its number") \
    M(forget_modes, METH_NOARGS, "forget_modes() -> the number that the mode of now had: it is 0 then, the only one, and has no rules") \
    M(renew_mode, METH_VARARGS, \
      "renew_mode(mode, ints, doubles): other numbers in rows of the same form; `rewind` and `start` have to follow") \
    M(keep_ledger, METH_VARARGS, "keep_ledger(ints, doubles): before the start") \
    M(set_integrals, METH_VARARGS, "set_integrals(mode, ints, doubles): what the ledger integrates there") \
    M(set_slopes, METH_VARARGS, "set_slopes(mode, ints, doubles): derivatives of its formulas") \
    M(keep_tangent, METH_VARARGS, "keep_tangent(ints, doubles): before the start") \
    M(keep_extremes, METH_VARARGS, "keep_extremes(ints, doubles): before the start and `fill`") \
    M(keep_impacts, METH_VARARGS, "keep_impacts(ints, doubles): before the start") \
    M(keep_section, METH_VARARGS, \
      "keep_section(cycles, cycles_lo, turns, rotor): the period, or the rotor whose turns it is, else -1; before the start") \
    M(record_from, METH_VARARGS, "record_from(samples, section): times [s] before which they are left out; before the start") \
    M(pause_at, METH_VARARGS, "pause_at(t): where `advance` ends, behind the stretch that reaches t") \
    M(dither, METH_VARARGS, "dither(which): how the times of events are moved; before the start") \
    M(kick, METH_VARARGS, "kick(seed): have states moved as doubles round, from the next start on; 0: not") \
    M(set_rule, METH_VARARGS, "set_rule(mode, event, (rule, target, other, hold, kind, part, key, order)): what follows the event") \
    M(fill, METH_VARARGS, \
      "fill(samples, sample_modes, events, event_codes, section): arrays that take what is computed from now on, from their start") \
    M(start, METH_VARARGS, \
      "start(mode, state, known) -> as advance\n\n" \
      "known: order by key; below zero that of a zero to be looked at once more.") \
    M(rewind, METH_VARARGS, "rewind(t_end): as before the start, without disturbances; modes and rules are kept") \
    M(retune, METH_VARARGS, "retune(doubles): the numbers of another scene of the same modes; `rewind` and `start` have to follow") \
    M(advance, METH_VARARGS, \
      "advance(work) -> (samples, events, section, finished, status): how many the arrays hold\n\n" \
      "Compute on until an array is full, a slice of work is done, Python has to decide or the run ends.\n" \
      "work: 1 ends the slice behind one stretch, 0 behind an event that has its rule now; a slice of its own without it.") \
    M(pending, METH_NOARGS, \
      "pending() -> (mode, event, order of its zero at the start of the stretch, state) that Python has to decide") \
    M(take, METH_VARARGS, \
      "take(mode, state, known, kinds, parts) -> as advance\n\n" \
      "Go on behind the pending event; known: order by key, -1 where nothing is said.") \
    M(add_entry, METH_VARARGS, "add_entry(entry, value): to the ledger, what an event adds") \
    M(doubt, METH_VARARGS, \
      "doubt(t) -> its number among the doubts that are described: count what happened at t as not proved; -1 where it is counted already or they are enough") \
    M(doubts, METH_NOARGS, "doubts() -> the first of them: (time, reason, mode, event, other)") \
    M(states_at, METH_VARARGS, \
      "states_at(times, states, codes, made) -> how many there are now: call again for more; what became of the run") \
    M(at_begin, METH_VARARGS, "at_begin(out): fills a column with the state at the time from which samples are recorded") \
    M(extremes, METH_NOARGS, "extremes() -> lists of the least, the greatest, the smallest gaps") \
    M(disturbances, METH_NOARGS, "disturbances() -> disturbances and how close events were to tangency") \
    M(outcome, METH_VARARGS, "outcome(out) -> how many numbers: fills `out` with what a motion that carries disturbances has come to") \
    M(hand_jump, METH_VARARGS, \
      "hand_jump(kind, determinant, tangencies, closest, undefined, vectors): what the pending event, which Python takes, did to disturbances") \
    M(look, METH_VARARGS, "look(mode, state) -> length of a step: expand the motion there; of a run that is not started") \
    M(derivatives, METH_VARARGS, \
      "derivatives(event, count) -> those of order 0 to `count` of an event function where the motion was looked at") \
    M(bounds, METH_VARARGS, \
      "bounds(event, count, exact, summed, span) -> of the rounding of derivatives, see `taylor_bounds` in engine.h") \
    M(forces, METH_NOARGS, "forces() -> sum of the magnitudes of all forces there") \
    M(formulas, METH_NOARGS, "formulas() -> values of the outputs of the mode's tape there") \
    M(tally, METH_NOARGS, "tally() -> dict of state, counts and margins")

#define METHOD_OF_RUN(name, flags, text) PyObject *Run_##name(RunObject *self, PyObject *args);
RUN_METHODS(METHOD_OF_RUN)
#undef METHOD_OF_RUN

/* run_setup.c; 0 of run_is_idle: an error is set */
int reader_of(const Py_buffer *ints, const Py_buffer *doubles, Reader *in);
int run_is_idle(RunObject *self);

/* run_outcome.c; 0 of run_is_ready: an error is set */
int run_is_ready(RunObject *self);
PyObject *list_of(const Real *values, int count, int stride);
PyObject *state_tuple(const Run *r, const State *s);

#endif
