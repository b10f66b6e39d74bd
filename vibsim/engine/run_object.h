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
/* double_functions.c; module.c: several runs side by side */
extern PyMethodDef double_functions[];
PyObject *advance_together(PyObject *module, PyObject *args);
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

/* module.c: a packed state; 0, or -1 where an error is set */
int read_state(const Run *r, const Py_buffer *view, State *s);

/* run_look.c */
PyObject *run_look(RunObject *self, PyObject *args);
PyObject *run_derivatives(RunObject *self, PyObject *args);
PyObject *run_bounds(RunObject *self, PyObject *args);
PyObject *run_formulas(RunObject *self, PyObject *none);

/* run_setup.c: what a run is told of before its start, modes as they are met, and jumps; 0 of run_is_idle: an error is set */
int reader_of(const Py_buffer *ints, const Py_buffer *doubles, Reader *in);
int run_is_idle(RunObject *self);
PyObject *run_add_mode(RunObject *self, PyObject *args);
PyObject *run_forget_modes(RunObject *self, PyObject *args);
PyObject *run_renew_mode(RunObject *self, PyObject *args);
PyObject *run_keep_ledger(RunObject *self, PyObject *args);
PyObject *run_set_integrals(RunObject *self, PyObject *args);
PyObject *run_set_slopes(RunObject *self, PyObject *args);
PyObject *run_keep_tangent(RunObject *self, PyObject *args);
PyObject *run_keep_extremes(RunObject *self, PyObject *args);
PyObject *run_keep_impacts(RunObject *self, PyObject *args);
PyObject *run_keep_section(RunObject *self, PyObject *args);
PyObject *run_record_from(RunObject *self, PyObject *args);
PyObject *run_pause_at(RunObject *self, PyObject *args);
PyObject *run_dither(RunObject *self, PyObject *args);
PyObject *run_kick(RunObject *self, PyObject *args);
PyObject *run_set_rule(RunObject *self, PyObject *args);
PyObject *run_hand_jump(RunObject *self, PyObject *args);

/* run_outcome.c: what a run has come to; 0 of run_is_ready: an error is set */
int run_is_ready(RunObject *self);
PyObject *list_of(const Real *values, int count, int stride);
PyObject *state_tuple(const Run *r, const State *s);
PyObject *run_tally(RunObject *self, PyObject *none);
PyObject *run_doubts(RunObject *self, PyObject *none);
PyObject *run_at_begin(RunObject *self, PyObject *args);
PyObject *run_extremes(RunObject *self, PyObject *none);
PyObject *run_disturbances(RunObject *self, PyObject *none);
PyObject *run_outcome(RunObject *self, PyObject *args);

#endif
