/* What a run has come to, as objects of Python. */
#include "run_object.h"

#include "certificate.h"

#include <string.h>

int run_is_ready(RunObject *self)
{
    if (!self->started)
        PyErr_SetString(PyExc_ValueError, "the run has not been started");
    return self->started && run_is_idle(self);
}

PyObject *state_tuple(const Run *r, const State *s)
{
    return Py_BuildValue("NNNNNN", number_object(s->t), list_of(s->x, r->bodies, 1), list_of(s->v, r->bodies, 1), number_object(s->phase),
                         number_object(s->turns), number_object(s->w));
}

PyObject *Run_tally(RunObject *self, PyObject *none)
{
    const Run *r = &self->run;
    PyObject *counts, *entries;
    int i;
    (void)none;
    if (!run_is_ready(self) || (counts = PyTuple_New(KINDS)) == NULL)
        return NULL;
    entries = list_of(r->ledger.entries, r->ledger.count, 1);
    for (i = 0; i < KINDS; i++)
        PyTuple_SET_ITEM(counts, i, PyLong_FromDouble((double)r->counts[i]));
    return Py_BuildValue("{sNsNsNsNsdsdsds(dNNN)sisNsisi}", "state", state_tuple(r, &r->state), "counts", counts, "entries", entries, "worked_to", number_object(run_worked_to(r)), "steps", r->steps, "steps_beside", r->steps_beside,
                         "evaluations", r->evaluations, "certificate", r->certificate.uncertified, number_object(r->certificate.first_doubt),
                         number_object(r->certificate.margin), number_object(r->certificate.margin_time), "violated_once", r->violated_once,
                         "first_violation", number_object(r->first_violation), "mode", r->mode_number, "singular", r->singular);
}

PyObject *Run_doubts(RunObject *self, PyObject *none)
{
    const Certificate *c = &self->run.certificate;
    const int count = described(c);
    PyObject *list;
    int i;
    (void)none;
    if (!run_is_idle(self))
        return NULL;
    list = PyList_New(count);
    for (i = 0; list && i < count; i++) {
        const Doubt *d = &c->doubts[i];
        PyObject *one = Py_BuildValue("Niiii", number_object(d->at), d->reason, d->mode, d->event, d->other);
        if (!one) {
            Py_CLEAR(list);
            break;
        }
        PyList_SET_ITEM(list, i, one);
    }
    return list;
}

/* The state where samples begin, into the column `out` as samples are written; not before the run has come there. */
PyObject *Run_at_begin(RunObject *self, PyObject *args)
{
    const Run *r = &self->run;
    Py_buffer view;
    int fits;
    if (!run_is_ready(self) || !PyArg_ParseTuple(args, "w*", &view))
        return NULL;
    fits = r->at_begin.t >= 0 && view.len == (Py_ssize_t)((3 + 2 * r->bodies) * (int)sizeof(Real));
    if (fits)
        write_state(r, (Real *)view.buf, 1, &r->at_begin);
    PyBuffer_Release(&view);
    if (fits)
        Py_RETURN_NONE;
    PyErr_SetString(PyExc_ValueError, "the run has not come so far, or no room for its state");
    return NULL;
}

PyObject *list_of(const Real *values, int count, int stride)
{
    PyObject *list = PyList_New(count);
    int i;
    for (i = 0; list && i < count; i++)
        PyList_SET_ITEM(list, i, number_object(values[i * stride]));
    return list;
}

static PyObject *list_of_ints(const int *values, int count)
{
    PyObject *list = PyList_New(count);
    int i;
    for (i = 0; list && i < count; i++)
        PyList_SET_ITEM(list, i, PyLong_FromLong(values[i]));
    return list;
}

/* Lists of `width` numbers, `stride` apart: the first begin `step` apart. */
static PyObject *table_of(const Real *values, int count, int width, int step, int stride)
{
    PyObject *list = PyList_New(count);
    int i;
    for (i = 0; list && i < count; i++) {
        PyObject *row = list_of(values + i * step, width, stride);
        if (!row) {
            Py_CLEAR(list);
            break;
        }
        PyList_SET_ITEM(list, i, row);
    }
    return list;
}

PyObject *Run_extremes(RunObject *self, PyObject *none)
{
    const Extremes *e = &self->run.extremes;
    (void)none;
    if (!run_is_ready(self))
        return NULL;
    return Py_BuildValue("NNN", list_of(e->least, e->count, 1), list_of(e->greatest, e->count, 1), list_of(e->margins, e->gap_count, 1));
}

PyObject *Run_disturbances(RunObject *self, PyObject *none)
{
    const Tangent *b = self->run.tangent;
    (void)none;
    if (!run_is_ready(self))
        return NULL;
    if (!b) {
        PyErr_SetString(PyExc_ValueError, "the run carries no disturbances");
        return NULL;
    }
    return Py_BuildValue("{sOsNsNsNsNsisdsNs(LNN)sNsNs(LN)}", "complete", b->complete ? Py_True : Py_False, "rows",
                         table_of(b->rows, b->row_count, 1 + b->count, 1 + b->count, 1), "vectors",
                         table_of(b->vectors, b->possible, b->size, 1, b->stride), "columns", list_of_ints(b->columns, b->count), "lost",
                         list_of_ints(b->lost, b->count), "losses", b->losses, "pieces", b->pieces, "residual", number_object(b->residual), "near",
                         b->tangencies.count, number_object(b->tangencies.closest), number_object(b->tangencies.closest_time), "fastest",
                         list_of(b->tangencies.fastest, b->stop_count, 1), "since", list_of(b->tangencies.since, b->stop_count, 1),
                         "undefined", b->tangencies.undefined,
                         number_object(b->tangencies.undefined_time));
}

/* Fills `out` with what a motion with disturbances has come to: doubts, margin, number of the mode, events without a derivative and
 * when the first was; t, x and v of each body, phase, turns, w; rates of x, v, phi, w where there is a motor; disturbances, one
 * after the other. Rates and disturbances are left out where none were carried. How many numbers there are.
 */
PyObject *Run_outcome(RunObject *self, PyObject *args)
{
    const Run *r = &self->run;
    const Tangent *b = r->tangent;
    const State *s = &r->state;
    Py_buffer view;
    Real *at;
    int n = r->bodies, i;
    Py_ssize_t count = 5 + 4 + 2 * n + (b ? (1 + b->possible) * b->size : 0);
    if (!run_is_ready(self) || !PyArg_ParseTuple(args, "w*", &view))
        return NULL;
    if (view.len < count * (Py_ssize_t)sizeof(Real)) {
        PyBuffer_Release(&view);
        PyErr_SetString(PyExc_ValueError, "no room for the outcome");
        return NULL;
    }
    at = (Real *)view.buf;
    *at++ = r->certificate.uncertified;
    *at++ = r->certificate.margin;
    *at++ = r->mode_number;
    *at++ = b ? (Real)b->tangencies.undefined : 0.0;
    *at++ = b ? b->tangencies.undefined_time : 0.0;
    *at++ = s->t;
    memcpy(at, s->x, (size_t)n * sizeof(Real));
    memcpy(at + n, s->v, (size_t)n * sizeof(Real));
    at += 2 * n;
    *at++ = s->phase;
    *at++ = s->turns;
    *at++ = s->w;
    if (b) {
        Real rotor = accelerations(r, r->mode, s, b->accelerations);
        memcpy(at, s->v, (size_t)n * sizeof(Real));
        memcpy(at + n, b->accelerations, (size_t)n * sizeof(Real));
        at += 2 * n;
        if (r->has_motor) {
            *at++ = s->w;
            *at++ = rotor;
        }
        for (i = 0; i < b->possible; i++, at += b->size)
            take_vector(b, i, at);
    }
    PyBuffer_Release(&view);
    return PyLong_FromSsize_t(count);
}
