/* The Python face of the C engine: functions on caller-owned memory; the GIL is released while it computes. */
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <string.h>

#include "kernel.h"

enum { SAMPLE_COLUMNS = 7, EVENT_COLUMNS = 8, STEP_SLICE = 20000 };

static int read_doubles(const Py_buffer *view, void *target, size_t size)
{
    if ((size_t)view->len != size) {
        PyErr_Format(PyExc_ValueError, "expected %zu bytes, got %zd", size, view->len);
        return -1;
    }
    memcpy(target, view->buf, size);
    return 0;
}

static Run *run_of(const Py_buffer *view)
{
    if ((size_t)view->len != sizeof(Run)) {
        PyErr_SetString(PyExc_ValueError, "not the memory of a run");
        return NULL;
    }
    return (Run *)view->buf;
}

static int buffers_of(Py_buffer *views, Buffers *b)
{
    memset(b, 0, sizeof *b);
    b->samples = views[0].buf;
    b->sample_modes = views[1].buf;
    b->events = views[2].buf;
    b->event_codes = views[3].buf;
    b->sample_room = (long)(views[0].len / (Py_ssize_t)(SAMPLE_COLUMNS * sizeof(double)));
    b->event_room = (long)(views[2].len / (Py_ssize_t)(EVENT_COLUMNS * sizeof(double)));
    b->section = views[4].buf;
    b->section_room = (long)(views[4].len / (Py_ssize_t)(SAMPLE_COLUMNS * sizeof(double)));
    if (b->sample_room < 1 || b->event_room < 8 || b->section_room == 1 || views[1].len != 2 * b->sample_room || views[3].len != 3 * b->event_room) {
        PyErr_SetString(PyExc_ValueError, "buffers do not fit together");
        return -1;
    }
    return 0;
}

static void release(Py_buffer *views, int count)
{
    int i;
    for (i = 0; i < count; i++)
        PyBuffer_Release(&views[i]);
}

static PyObject *run_size(PyObject *self, PyObject *args)
{
    return PyLong_FromSize_t(sizeof(Run));
}

PyDoc_STRVAR(start_doc, "start(run, scene, resume, samples, sample_modes, events, event_codes, section) -> (samples, events)\n\n"
                        "Set the memory `run` to the start of `scene` (packed doubles), or to the packed `resume` row: state (8), mode (3),\n"
                        "known zeros (5), as doubles; empty for a fresh start.");

static PyObject *start(PyObject *self, PyObject *args)
{
    Py_buffer v[8];
    Buffers b;
    Scene scene;
    double row[8 + 3 + FUNCTIONS];
    Run *run;
    PyObject *result = NULL;
    if (!PyArg_ParseTuple(args, "w*y*y*w*w*w*w*w*", &v[0], &v[1], &v[2], &v[3], &v[4], &v[5], &v[6], &v[7]))
        return NULL;
    run = run_of(&v[0]);
    if (run && read_doubles(&v[1], &scene, sizeof scene) == 0 && buffers_of(v + 3, &b) == 0) {
        if (v[2].len == 0) {
            run_start(run, &scene, NULL, NULL, NULL, &b);
            result = Py_BuildValue("ll", b.sample_count, b.event_count);
        } else if (read_doubles(&v[2], row, sizeof row) == 0) {
            State state = {row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7]};
            Mode mode = {(int)row[8], (int)row[9], (int)row[10]};
            Known known;
            int i;
            for (i = 0; i < FUNCTIONS; i++)
                known.order[i] = (int)row[11 + i];
            run_start(run, &scene, &state, &mode, &known, &b);
            result = Py_BuildValue("ll", b.sample_count, b.event_count);
        }
    }
    release(v, 8);
    return result;
}

PyDoc_STRVAR(advance_doc, "advance(run, samples, sample_modes, events, event_codes, section) -> (samples, events, section, finished, status)\n\n"
                          "Compute on until a buffer is full, a slice of work is done or the run ends.");

static PyObject *advance(PyObject *self, PyObject *args)
{
    Py_buffer v[6];
    Buffers b;
    Run *run;
    PyObject *result = NULL;
    if (!PyArg_ParseTuple(args, "w*w*w*w*w*w*", &v[0], &v[1], &v[2], &v[3], &v[4], &v[5]))
        return NULL;
    run = run_of(&v[0]);
    if (run && buffers_of(v + 1, &b) == 0) {
        Py_BEGIN_ALLOW_THREADS
        run_advance(run, &b, STEP_SLICE);
        Py_END_ALLOW_THREADS
        result = Py_BuildValue("lllii", b.sample_count, b.event_count, b.section_count, run->finished, run->status);
    }
    release(v, 6);
    return result;
}

PyDoc_STRVAR(state_at_doc, "state_at(run, t) -> (t, x1, v1, x2, v2, phase, turns, w)\n\nState before the next event; t ascending from call to call.");

static PyObject *state_at(PyObject *self, PyObject *args)
{
    Py_buffer v;
    double t;
    Run *run;
    PyObject *result = NULL;
    if (!PyArg_ParseTuple(args, "w*d", &v, &t))
        return NULL;
    run = run_of(&v);
    if (run) {
        State s;
        run_state_at(run, t, &s);
        result = Py_BuildValue("dddddddd", s.t, s.x1, s.v1, s.x2, s.v2, s.phase, s.turns, s.w);
    }
    release(&v, 1);
    return result;
}

PyDoc_STRVAR(tally_doc, "tally(run) -> dict of state, mode, counts and margins");

static PyObject *tally(PyObject *self, PyObject *args)
{
    Py_buffer v;
    Run *r;
    PyObject *result = NULL, *counts;
    int i;
    if (!PyArg_ParseTuple(args, "y*", &v))
        return NULL;
    r = run_of(&v);
    if (r && (counts = PyTuple_New(KINDS)) != NULL) {
        for (i = 0; i < KINDS; i++)
            PyTuple_SET_ITEM(counts, i, PyLong_FromDouble(r->counts[i]));
        result = Py_BuildValue("{s(dddddddd)s(iii)sNsdsds(dddd)sisds(ddddd)}", "state", r->state.t, r->state.x1, r->state.v1,
                               r->state.x2, r->state.v2, r->state.phase, r->state.turns, r->state.w, "mode",
                               r->mode.contact, r->mode.friction, r->mode.violated, "counts", counts, "steps", r->steps,
                               "evaluations", r->evaluations, "certificate", r->certificate.uncertified,
                               r->certificate.first_doubt, r->certificate.margin, r->certificate.margin_time,
                               "violated_once", r->violated_once, "first_violation",
                               r->first_violation, "ledger", r->energy_start, r->stored, r->work, r->viscous,
                               r->friction_loss);
    }
    release(&v, 1);
    return result;
}

PyDoc_STRVAR(growth_doc, "growth(run) -> (count, complete, rows, rank losses, pieces, volume residual, (tangencies, closest, its time, largest speed))\n\n"
                         "The tangent bundle of a run, as `TangentBundle.entries()` has it; rows as one flat tuple.");

static PyObject *growth(PyObject *self, PyObject *args)
{
    Py_buffer v;
    Run *r;
    PyObject *result = NULL, *rows;
    int i, k;
    if (!PyArg_ParseTuple(args, "y*", &v))
        return NULL;
    r = run_of(&v);
    if (r) {
        const Tangent *b = &r->tangent;
        int width = b->count + 1;
        rows = PyTuple_New(b->row_count * width);
        for (i = 0; rows && i < b->row_count; i++)
            for (k = 0; k < width; k++)
                PyTuple_SET_ITEM(rows, i * width + k, PyFloat_FromDouble(b->rows[i][k]));
        if (rows)
            result = Py_BuildValue("iiNddd(dddd)", b->count, b->complete, rows, b->losses, b->pieces, b->residual,
                                   b->tangencies.count, b->tangencies.closest, b->tangencies.time, b->tangencies.fastest);
    }
    release(&v, 1);
    return result;
}

static PyMethodDef methods[] = {
    {"run_size", run_size, METH_NOARGS, "run_size() -> bytes of memory that a run needs"},
    {"start", start, METH_VARARGS, start_doc},
    {"advance", advance, METH_VARARGS, advance_doc},
    {"state_at", state_at, METH_VARARGS, state_at_doc},
    {"tally", tally, METH_VARARGS, tally_doc},
    {"growth", growth, METH_VARARGS, growth_doc},
    {NULL, NULL, 0, NULL},
};

static struct PyModuleDef module = {
    PyModuleDef_HEAD_INIT, "_kernel", "The C engine of vibsim; use vibsim.kernel.", -1, methods, NULL, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__kernel(void)
{
    return PyModule_Create(&module);
}
