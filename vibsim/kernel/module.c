/* The Python face of the C engine: a run is a capsule, its output goes into arrays of the caller. Every index, size, type and
 * layout that comes from outside is checked here; the GIL is released while the engine computes.
 */
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <stdint.h>
#include <string.h>

#include "checks.h"
#include "kernel.h"

#define CAPSULE "vibsim.run"

enum { SAMPLE_COLUMNS = 7, EVENT_COLUMNS = 8, OUTPUTS = 5 };
enum { SCENE_NUMBERS = sizeof(Scene) / sizeof(double), RESUME_NUMBERS = 8 + 3 + FUNCTIONS };

/* Memory of a capsule. */
typedef struct {
    Run run;
    int busy; /* an engine call is under way without the GIL */
} Box;

static void drop(PyObject *capsule)
{
    PyMem_Free(PyCapsule_GetPointer(capsule, CAPSULE));
}

static Box *box_of(PyObject *capsule)
{
    Box *box = PyCapsule_GetPointer(capsule, CAPSULE);
    if (box && box->busy) {
        PyErr_SetString(PyExc_RuntimeError, "a run serves one caller at a time");
        return NULL;
    }
    return box;
}

static int wrong(const char *name, const char *must_be)
{
    PyErr_Format(PyExc_ValueError, "%s must be %s", name, must_be);
    return -1;
}

/* The numbers of a one-dimensional array of doubles. */
static int read_doubles(PyObject *array, const char *name, double *numbers, Py_ssize_t count)
{
    Py_buffer view;
    int fits;
    if (PyObject_GetBuffer(array, &view, PyBUF_CONTIG_RO | PyBUF_FORMAT) < 0)
        return -1;
    fits = view.ndim == 1 && view.shape[0] == count && view.format && strcmp(view.format, "d") == 0;
    if (fits)
        memcpy(numbers, view.buf, (size_t)count * sizeof(double));
    PyBuffer_Release(&view);
    return fits ? 0 : wrong(name, "a row of doubles of the engine's length");
}

/* A contiguous table of `rows` rows to write into. */
static int open_table(PyObject *array, const char *name, const char *format, Py_ssize_t rows, Py_buffer *view)
{
    size_t size = *format == 'd' ? sizeof(double) : 1;
    if (PyObject_GetBuffer(array, view, PyBUF_CONTIG | PyBUF_FORMAT) < 0)
        return -1;
    if (view->ndim == 2 && view->shape[0] == rows && view->format && strcmp(view->format, format) == 0 &&
        (uintptr_t)view->buf % size == 0)
        return 0;
    PyBuffer_Release(view);
    return wrong(name, "a writable, contiguous table of the engine's type and number of rows");
}

static void close_tables(Py_buffer *views, int count)
{
    int i;
    for (i = 0; i < count; i++)
        PyBuffer_Release(&views[i]);
}

/* samples, sample_modes, events, event_codes, section, as `Buffers` has them. */
static int open_tables(PyObject *const *arrays, Py_buffer *views, Buffers *b)
{
    static const char *const names[OUTPUTS] = {"samples", "sample_modes", "events", "event_codes", "section"};
    static const char *const formats[OUTPUTS] = {"d", "b", "d", "b", "d"};
    static const int rows[OUTPUTS] = {SAMPLE_COLUMNS, 2, EVENT_COLUMNS, 3, SAMPLE_COLUMNS};
    Py_ssize_t room[OUTPUTS];
    int i;
    for (i = 0; i < OUTPUTS; i++) {
        if (open_table(arrays[i], names[i], formats[i], rows[i], &views[i]) < 0) {
            close_tables(views, i);
            return -1;
        }
        room[i] = views[i].shape[1];
    }
    if (room[0] < 1 || room[1] != room[0] || room[2] < 8 || room[3] != room[2] || room[4] == 1 || room[0] > LONG_MAX / 16 ||
        room[2] > LONG_MAX / 16 || room[4] > LONG_MAX / 16) {
        close_tables(views, OUTPUTS);
        PyErr_SetString(PyExc_ValueError, "the tables of the output do not fit together");
        return -1;
    }
    memset(b, 0, sizeof *b);
    b->samples = views[0].buf;
    b->sample_modes = views[1].buf;
    b->events = views[2].buf;
    b->event_codes = views[3].buf;
    b->section = views[4].buf;
    b->sample_room = (long)room[0];
    b->event_room = (long)room[2];
    b->section_room = (long)room[4];
    return 0;
}

/* The point to go on from, out of a packed row: state (8), mode (3), known zeros (5). */
static int read_resume(PyObject *row, const Scene *scene, State *state, Mode *mode, Known *known)
{
    double n[RESUME_NUMBERS];
    const char *problem;
    int i;
    if (read_doubles(row, "resume", n, RESUME_NUMBERS) < 0)
        return -1;
    problem = resume_problem(scene, n);
    if (problem) {
        PyErr_Format(PyExc_ValueError, "resume: %s", problem);
        return -1;
    }
    memcpy(state, n, sizeof *state);
    mode->contact = (int)n[8];
    mode->friction = (int)n[9];
    mode->violated = (int)n[10];
    for (i = 0; i < FUNCTIONS; i++)
        known->order[i] = (int)n[11 + i];
    return 0;
}

PyDoc_STRVAR(start_doc, "start(scene, resume, samples, sample_modes, events, event_codes, section) -> (run, samples, events)\n\n"
                        "A run at the start of `scene` (packed doubles), or at the packed `resume` row: state (8), mode (3), known\n"
                        "zeros (5), as doubles; None for a fresh start. Raises ValueError for what no run can be made of.");

static PyObject *start(PyObject *Py_UNUSED(self), PyObject *args)
{
    PyObject *packed, *row, *arrays[OUTPUTS], *capsule = NULL;
    Py_buffer views[OUTPUTS];
    Buffers b;
    Scene scene;
    State state;
    Mode mode;
    Known known;
    Box *box;
    const char *problem;
    if (!PyArg_ParseTuple(args, "OOOOOOO", &packed, &row, &arrays[0], &arrays[1], &arrays[2], &arrays[3], &arrays[4]) ||
        read_doubles(packed, "scene", (double *)&scene, SCENE_NUMBERS) < 0)
        return NULL;
    problem = scene_problem(&scene);
    if (problem) {
        PyErr_Format(PyExc_ValueError, "scene: %s", problem);
        return NULL;
    }
    if ((row != Py_None && read_resume(row, &scene, &state, &mode, &known) < 0) || open_tables(arrays, views, &b) < 0)
        return NULL;
    box = PyMem_Calloc(1, sizeof *box);
    if (!box)
        PyErr_NoMemory();
    else if (!(capsule = PyCapsule_New(box, CAPSULE, drop)))
        PyMem_Free(box);
    if (capsule) {
        Py_BEGIN_ALLOW_THREADS
        if (row == Py_None)
            run_start(&box->run, &scene, NULL, NULL, NULL, &b);
        else
            run_start(&box->run, &scene, &state, &mode, &known, &b);
        Py_END_ALLOW_THREADS
    }
    close_tables(views, OUTPUTS);
    return capsule ? Py_BuildValue("Nll", capsule, b.sample_count, b.event_count) : NULL;
}

PyDoc_STRVAR(advance_doc, "advance(run, samples, sample_modes, events, event_codes, section) -> (samples, events, section, finished, status)\n\n"
                          "Compute on until a buffer is full, a slice of work is done or the run ends.");

static PyObject *advance(PyObject *Py_UNUSED(self), PyObject *args)
{
    PyObject *capsule, *arrays[OUTPUTS];
    Py_buffer views[OUTPUTS];
    Buffers b;
    Box *box;
    if (!PyArg_ParseTuple(args, "OOOOOO", &capsule, &arrays[0], &arrays[1], &arrays[2], &arrays[3], &arrays[4]))
        return NULL;
    box = box_of(capsule);
    if (!box || open_tables(arrays, views, &b) < 0)
        return NULL;
    box->busy = 1;
    Py_BEGIN_ALLOW_THREADS
    run_advance(&box->run, &b);
    Py_END_ALLOW_THREADS
    box->busy = 0;
    close_tables(views, OUTPUTS);
    return Py_BuildValue("lllii", b.sample_count, b.event_count, b.section_count, box->run.finished, box->run.status);
}

PyDoc_STRVAR(state_at_doc, "state_at(run, t) -> (t, x1, v1, x2, v2, phase, turns, w), or None where a slice of work is done before: call again\n\n"
                           "State before the next event; t ascending from call to call.");

static PyObject *state_at(PyObject *Py_UNUSED(self), PyObject *args)
{
    PyObject *capsule;
    double t;
    Box *box;
    State s;
    int there;
    if (!PyArg_ParseTuple(args, "Od", &capsule, &t))
        return NULL;
    box = box_of(capsule);
    if (!box)
        return NULL;
    box->busy = 1;
    Py_BEGIN_ALLOW_THREADS
    there = run_state_at(&box->run, t, &s);
    Py_END_ALLOW_THREADS
    box->busy = 0;
    if (!there)
        Py_RETURN_NONE;
    return Py_BuildValue("dddddddd", s.t, s.x1, s.v1, s.x2, s.v2, s.phase, s.turns, s.w);
}

PyDoc_STRVAR(tally_doc, "tally(run) -> dict of state, mode, counts and margins");

static PyObject *tally(PyObject *Py_UNUSED(self), PyObject *capsule)
{
    const Box *box = box_of(capsule);
    const Run *r;
    PyObject *counts;
    int i;
    if (!box || !(counts = PyTuple_New(KINDS)))
        return NULL;
    r = &box->run;
    for (i = 0; i < KINDS; i++)
        PyTuple_SET_ITEM(counts, i, PyLong_FromDouble(r->counts[i]));
    return Py_BuildValue("{s(dddddddd)s(iii)sdsNsdsds(dddd)sisds(ddddd)}", "state", r->state.t, r->state.x1, r->state.v1,
                         r->state.x2, r->state.v2, r->state.phase, r->state.turns, r->state.w, "mode", r->mode.contact,
                         r->mode.friction, r->mode.violated, "worked_to", run_worked_to(r), "counts", counts, "steps",
                         r->steps, "evaluations", r->evaluations, "certificate", r->certificate.uncertified,
                         r->certificate.first_doubt, r->certificate.margin, r->certificate.margin_time, "violated_once",
                         r->violated_once, "first_violation", r->first_violation, "ledger", r->energy_start, r->stored,
                         r->work, r->viscous, r->friction_loss);
}

PyDoc_STRVAR(growth_doc, "growth(run) -> (count, complete, rows, rank losses, pieces, volume residual, (tangencies, closest, its time, largest speed))\n\n"
                         "The tangent bundle of a run, as `TangentBundle.entries()` has it; rows as one flat tuple.");

static PyObject *growth(PyObject *Py_UNUSED(self), PyObject *capsule)
{
    const Box *box = box_of(capsule);
    const Tangent *b;
    PyObject *rows;
    int i, k, width;
    if (!box)
        return NULL;
    b = &box->run.tangent;
    width = b->count + 1;
    rows = PyTuple_New(b->row_count * width);
    if (!rows)
        return NULL;
    for (i = 0; i < b->row_count; i++)
        for (k = 0; k < width; k++)
            PyTuple_SET_ITEM(rows, i * width + k, PyFloat_FromDouble(b->rows[i][k]));
    return Py_BuildValue("iiNddd(dddd)", b->count, b->complete, rows, b->losses, b->pieces, b->residual, b->tangencies.count,
                         b->tangencies.closest, b->tangencies.time, b->tangencies.fastest);
}

static PyMethodDef methods[] = {
    {"start", start, METH_VARARGS, start_doc},
    {"advance", advance, METH_VARARGS, advance_doc},
    {"state_at", state_at, METH_VARARGS, state_at_doc},
    {"tally", tally, METH_O, tally_doc},
    {"growth", growth, METH_O, growth_doc},
    {NULL, NULL, 0, NULL},
};

static PyModuleDef_Slot slots[] = {{0, NULL}};

static struct PyModuleDef module = {
    PyModuleDef_HEAD_INIT, "_kernel", "The C engine of vibsim; use vibsim.kernel.", 0, methods, slots, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__kernel(void)
{
    return PyModuleDef_Init(&module);
}
