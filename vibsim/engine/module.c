/* The Python face of the C engine: the type Run. The GIL is released while it computes, and not needed elsewhere. */
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
    int started, busy, view_count;
} RunObject;

static int reader_of(const Py_buffer *ints, const Py_buffer *doubles, Reader *in)
{
    memset(in, 0, sizeof *in);
    if (ints->len % (Py_ssize_t)sizeof(int) || doubles->len % (Py_ssize_t)sizeof(double)) {
        PyErr_SetString(PyExc_ValueError, "packed numbers of the wrong size");
        return -1;
    }
    in->ints = ints->buf;
    in->doubles = doubles->buf;
    in->int_count = (long)(ints->len / (Py_ssize_t)sizeof(int));
    in->double_count = (long)(doubles->len / (Py_ssize_t)sizeof(double));
    return 0;
}

static PyObject *Run_new(PyTypeObject *type, PyObject *args, PyObject *named)
{
    Py_buffer v[2];
    Reader in;
    RunObject *self = NULL;
    (void)named;
    if (!PyArg_ParseTuple(args, "y*y*", &v[0], &v[1]))
        return NULL;
    if (reader_of(&v[0], &v[1], &in) == 0 && (self = (RunObject *)type->tp_alloc(type, 0)) != NULL && !scene_read(&self->run, &in)) {
        Py_CLEAR(self);
        PyErr_SetString(PyExc_ValueError, "the packed numbers are no scene");
    }
    PyBuffer_Release(&v[0]);
    PyBuffer_Release(&v[1]);
    return (PyObject *)self;
}

static void release(Py_buffer *views, int count)
{
    int i;
    for (i = 0; i < count; i++)
        PyBuffer_Release(&views[i]);
}

static void Run_dealloc(RunObject *self)
{
    run_free(&self->run);
    release(self->views, self->view_count);
    Py_TYPE(self)->tp_free((PyObject *)self);
}

static int idle(RunObject *self)
{
    if (self->busy)
        PyErr_SetString(PyExc_RuntimeError, "the run is being computed by another thread");
    return !self->busy;
}

static PyObject *add_mode(RunObject *self, PyObject *args)
{
    Py_buffer v[2];
    Reader in;
    PyObject *result = NULL;
    if (!PyArg_ParseTuple(args, "y*y*", &v[0], &v[1]))
        return NULL;
    if (idle(self) && reader_of(&v[0], &v[1], &in) == 0) {
        Mode *m = mode_read(&self->run, &in);
        int number = -1;
        if (m && !read_through(&in))
            PyErr_SetString(PyExc_ValueError, "the packed numbers are no mode");
        else if (!m || (number = mode_add(&self->run, m)) < 0)
            PyErr_NoMemory();
        if (number < 0)
            mode_free(m);
        else
            result = PyLong_FromLong(number);
    }
    PyBuffer_Release(&v[0]);
    PyBuffer_Release(&v[1]);
    return result;
}

/* A mode with other numbers in rows of the same form: what follows its events stays. */
static PyObject *renew_mode(RunObject *self, PyObject *args)
{
    Py_buffer v[2];
    Reader in;
    int number, renewed = 0;
    if (!PyArg_ParseTuple(args, "iy*y*", &number, &v[0], &v[1]))
        return NULL;
    if (idle(self) && reader_of(&v[0], &v[1], &in) == 0) {
        Mode *m = number >= 0 && number < self->run.mode_count ? mode_read(&self->run, &in) : NULL;
        renewed = m && read_through(&in) && mode_renew(&self->run, number, m);
        if (!renewed) {
            mode_free(m);
            PyErr_SetString(PyExc_ValueError, "the packed numbers are none of that mode");
        }
    }
    self->started = 0;
    PyBuffer_Release(&v[0]);
    PyBuffer_Release(&v[1]);
    if (!renewed)
        return NULL;
    Py_RETURN_NONE;
}

/* Ledgers and section have to be told of before the start. */
static PyObject *keep_ledger(RunObject *self, PyObject *args)
{
    Py_buffer v[2];
    Reader in;
    int kept = 0;
    if (!PyArg_ParseTuple(args, "y*y*", &v[0], &v[1]))
        return NULL;
    if (self->started || self->run.ledger.entries)
        PyErr_SetString(PyExc_ValueError, "too late for a ledger");
    else if (reader_of(&v[0], &v[1], &in) == 0 && !(kept = ledger_read(&self->run, &in)))
        PyErr_SetString(PyExc_ValueError, "the packed numbers are no ledger");
    PyBuffer_Release(&v[0]);
    PyBuffer_Release(&v[1]);
    if (!kept)
        return NULL;
    Py_RETURN_NONE;
}

static PyObject *set_meters(RunObject *self, PyObject *args)
{
    Py_buffer v[2];
    Reader in;
    int mode, kept = 0;
    if (!PyArg_ParseTuple(args, "iy*y*", &mode, &v[0], &v[1]))
        return NULL;
    if (!idle(self))
        kept = 0;
    else if (!self->run.ledger.wanted || mode < 0 || mode >= self->run.mode_count || self->run.modes[mode]->meters.meters)
        PyErr_SetString(PyExc_ValueError, "no mode that waits for meters");
    else if (reader_of(&v[0], &v[1], &in) == 0 && !(kept = meters_read(&self->run, self->run.modes[mode], &in)))
        PyErr_SetString(PyExc_ValueError, "the packed numbers are no meters");
    PyBuffer_Release(&v[0]);
    PyBuffer_Release(&v[1]);
    if (!kept)
        return NULL;
    Py_RETURN_NONE;
}

/* Small disturbances to carry along; before the start. */
static PyObject *keep_tangent(RunObject *self, PyObject *args)
{
    Py_buffer v[2];
    Reader in;
    int kept = 0;
    if (!PyArg_ParseTuple(args, "y*y*", &v[0], &v[1]))
        return NULL;
    if (self->started || self->run.tangent)
        PyErr_SetString(PyExc_ValueError, "too late for disturbances");
    else if (reader_of(&v[0], &v[1], &in) == 0 && !(kept = tangent_read(&self->run, &in))) {
        tangent_free(self->run.tangent);
        self->run.tangent = NULL;
        PyErr_SetString(PyExc_ValueError, "the packed numbers are no disturbances");
    }
    PyBuffer_Release(&v[0]);
    PyBuffer_Release(&v[1]);
    if (!kept)
        return NULL;
    Py_RETURN_NONE;
}

static PyObject *keep_extremes(RunObject *self, PyObject *args)
{
    Py_buffer v[2];
    Reader in;
    int kept = 0;
    if (!PyArg_ParseTuple(args, "y*y*", &v[0], &v[1]))
        return NULL;
    if (self->started || self->view_count || self->run.extremes.numbers)
        PyErr_SetString(PyExc_ValueError, "too late for extremes");
    else if (reader_of(&v[0], &v[1], &in) == 0 && !(kept = extremes_read(&self->run, &in)))
        PyErr_SetString(PyExc_ValueError, "the packed numbers are no extremes");
    PyBuffer_Release(&v[0]);
    PyBuffer_Release(&v[1]);
    if (!kept)
        return NULL;
    Py_RETURN_NONE;
}

/* Rigid stops whose blows C may take, in place of those told before; before the start. */
static PyObject *keep_blows(RunObject *self, PyObject *args)
{
    Py_buffer v[2];
    Reader in;
    int kept = 0;
    if (!PyArg_ParseTuple(args, "y*y*", &v[0], &v[1]))
        return NULL;
    if (self->started)
        PyErr_SetString(PyExc_ValueError, "too late for rigid stops");
    else if (reader_of(&v[0], &v[1], &in) == 0 && !(kept = blows_read(&self->run, &in)))
        PyErr_SetString(PyExc_ValueError, "the packed numbers are no rigid stops");
    PyBuffer_Release(&v[0]);
    PyBuffer_Release(&v[1]);
    if (!kept)
        return NULL;
    Py_RETURN_NONE;
}

static PyObject *keep_section(RunObject *self, PyObject *args)
{
    Section *s = &self->run.section;
    if (!PyArg_ParseTuple(args, "ddd", &s->cycles, &s->cycles_lo, &s->turns))
        return NULL;
    Py_RETURN_NONE;
}

static PyObject *set_rule(RunObject *self, PyObject *args)
{
    Run *r = &self->run;
    Event *e;
    int mode, event, v[8];
    if (!PyArg_ParseTuple(args, "ii(iiiiiiii)", &mode, &event, &v[0], &v[1], &v[2], &v[3], &v[4], &v[5], &v[6], &v[7]) || !idle(self))
        return NULL;
    if (mode < 0 || mode >= r->mode_count || event < 0 || event >= r->modes[mode]->event_count || v[0] < ASK || v[0] > BEAR ||
        v[1] < 0 || v[1] >= r->mode_count || v[2] < 0 || v[2] >= r->mode_count || v[4] < 0 || v[4] >= KINDS || v[6] < 0 ||
        v[6] >= r->key_count || v[7] < 0 || v[7] > JET_ORDER) {
        PyErr_SetString(PyExc_ValueError, "no such rule");
        return NULL;
    }
    e = &r->modes[mode]->events[event];
    e->rule = v[0];
    e->target = v[1];
    e->other = v[2];
    e->hold = v[3];
    e->event = v[4];
    e->event_part = v[5];
    e->event_key = v[6];
    e->order = v[7];
    Py_RETURN_NONE;
}

static int buffers_of(const Run *r, Py_buffer *views, Buffers *b)
{
    Py_ssize_t state = 3 + 2 * r->bodies, row = (Py_ssize_t)sizeof(double), section = state + 2 * r->extremes.count;
    memset(b, 0, sizeof *b);
    b->samples = views[0].buf;
    b->sample_modes = views[1].buf;
    b->events = views[2].buf;
    b->event_codes = views[3].buf;
    b->section = views[4].buf;
    b->sample_room = (long)(views[0].len / (state * row));
    b->event_room = (long)(views[2].len / ((state + 2 + r->bodies) * row));
    b->section_room = (long)(views[4].len / (section * row));
    if (b->sample_room < 1 || b->event_room < 8 + 3 * r->parts || views[0].len != b->sample_room * state * row ||
        views[2].len != b->event_room * (state + 2 + r->bodies) * row || views[1].len != (Py_ssize_t)b->sample_room * r->parts ||
        views[3].len != (Py_ssize_t)b->event_room * (2 + r->parts) || views[4].len != b->section_room * section * row ||
        b->section_room == 1) {
        PyErr_SetString(PyExc_ValueError, "buffers do not fit together");
        return -1;
    }
    return 0;
}

static PyObject *fill(RunObject *self, PyObject *args)
{
    Py_buffer v[BUFFERS];
    Buffers b;
    if (!PyArg_ParseTuple(args, "w*w*w*w*w*", &v[0], &v[1], &v[2], &v[3], &v[4]))
        return NULL;
    if (!idle(self) || buffers_of(&self->run, v, &b) != 0) {
        release(v, BUFFERS);
        return NULL;
    }
    release(self->views, self->view_count);
    memcpy(self->views, v, sizeof v);
    self->view_count = BUFFERS;
    self->buffers = b;
    Py_RETURN_NONE;
}

/* What is in the buffers by now, and what became of the run. */
static PyObject *progress(const RunObject *self)
{
    const Buffers *b = &self->buffers;
    return Py_BuildValue("lllii", b->sample_count, b->event_count, b->section_count, self->run.finished, self->run.status);
}

/* Packed state: t, x of each body, v of each body, phase, turns, w. */
static int read_state(const Run *r, const Py_buffer *view, State *s)
{
    const double *row = view->buf;
    int c;
    if (view->len != (Py_ssize_t)((4 + 2 * r->bodies) * (int)sizeof(double))) {
        PyErr_SetString(PyExc_ValueError, "not a packed state");
        return -1;
    }
    s->t = row[0];
    for (c = 0; c < r->bodies; c++) {
        s->x[c] = row[1 + c];
        s->v[c] = row[1 + r->bodies + c];
    }
    row += 1 + 2 * r->bodies;
    s->phase = row[0];
    s->turns = row[1];
    s->w = row[2];
    return 0;
}

static PyObject *state_tuple(const Run *r, const State *s)
{
    PyObject *x = PyList_New(r->bodies), *v = PyList_New(r->bodies);
    int c;
    if (!x || !v) {
        Py_XDECREF(x);
        Py_XDECREF(v);
        return NULL;
    }
    for (c = 0; c < r->bodies; c++) {
        PyList_SET_ITEM(x, c, PyFloat_FromDouble(s->x[c]));
        PyList_SET_ITEM(v, c, PyFloat_FromDouble(s->v[c]));
    }
    return Py_BuildValue("dNNddd", s->t, x, v, s->phase, s->turns, s->w);
}

/* Orders of known zeros by key, as bytes of int; there may be more of them than this run has met. */
static int read_known(const Run *r, const Py_buffer *view, int *known)
{
    const int *values = view->buf;
    Py_ssize_t count = view->len / (Py_ssize_t)sizeof(int), k;
    if (count < r->key_count) {
        PyErr_SetString(PyExc_ValueError, "not the orders of the known zeros");
        return -1;
    }
    for (k = 0; k < r->key_count; k++)
        known[k] = values[k] < -1 ? -1 : values[k] > JET_ORDER ? JET_ORDER : values[k];
    return 0;
}

static PyObject *start(RunObject *self, PyObject *args)
{
    Run *r = &self->run;
    Py_buffer v[2];
    int mode, k;
    PyObject *result = NULL;
    if (!PyArg_ParseTuple(args, "iy*y*", &mode, &v[0], &v[1]))
        return NULL;
    if (!idle(self) || self->started || !self->view_count || mode < 0 || mode >= r->mode_count) {
        if (!PyErr_Occurred())
            PyErr_SetString(PyExc_ValueError, "cannot start here");
    } else if (read_state(r, &v[0], &r->state) == 0 && read_known(r, &v[1], r->known) == 0) {
        for (k = 0; k < r->key_count; k++)
            r->known[k] = r->known[k] < 0 ? 0 : r->known[k];
        self->started = 1;
        self->buffers.sample_count = self->buffers.event_count = self->buffers.section_count = 0;
        run_start(r, mode, &self->buffers);
        result = progress(self);
    }
    release(v, 2);
    return result;
}

static PyObject *rewind_run(RunObject *self, PyObject *args)
{
    double t_end;
    if (!PyArg_ParseTuple(args, "d", &t_end) || !idle(self))
        return NULL;
    run_rewind(&self->run, t_end);
    self->started = 0;
    Py_RETURN_NONE;
}

/* The doubles of a scene of the same shape, whose modes are renewed where rows hold others; a start has to follow. */
static PyObject *retune(RunObject *self, PyObject *args)
{
    Py_buffer v[2] = {{0}};
    Reader in;
    int done = 0;
    if (!PyArg_ParseTuple(args, "y*", &v[1]))
        return NULL;
    if (idle(self) && reader_of(&v[0], &v[1], &in) == 0 && !(done = scene_retune(&self->run, &in)))
        PyErr_SetString(PyExc_ValueError, "not the numbers of a scene of that shape");
    self->started = 0;
    PyBuffer_Release(&v[1]);
    if (!done)
        return NULL;
    Py_RETURN_NONE;
}

static int ready(RunObject *self)
{
    if (!self->started)
        PyErr_SetString(PyExc_ValueError, "the run has not been started");
    return self->started && idle(self);
}

static PyObject *advance(RunObject *self, PyObject *none)
{
    (void)none;
    if (!ready(self))
        return NULL;
    self->busy = 1;
    Py_BEGIN_ALLOW_THREADS
    run_advance(&self->run, &self->buffers);
    Py_END_ALLOW_THREADS
    self->busy = 0;
    return progress(self);
}

/* Order of the zero of the pending event's function that the stretch began with. */
static int pending_order(const Run *r)
{
    const Event *e = r->pending_event == NOTHING ? NULL : &r->mode->events[r->pending_event];
    return e == NULL || (e->kind != STRIKE && r->pending_tau != 0) ? 0 : r->known[e->key];
}

static PyObject *pending(RunObject *self, PyObject *none)
{
    (void)none;
    if (!ready(self))
        return NULL;
    return Py_BuildValue("iiiN", self->run.mode_number, self->run.pending_event, pending_order(&self->run),
                         state_tuple(&self->run, &self->run.next));
}

static PyObject *take(RunObject *self, PyObject *args)
{
    Run *r = &self->run;
    Py_buffer v[4];
    int mode;
    PyObject *result = NULL;
    if (!PyArg_ParseTuple(args, "iy*y*y*y*", &mode, &v[0], &v[1], &v[2], &v[3]))
        return NULL;
    if (ready(self) && r->status == UNDECIDED && mode >= 0 && mode < r->mode_count && v[2].len == v[3].len &&
        read_state(r, &v[0], &r->next) == 0 && read_known(r, &v[1], r->behind) == 0) {
        int count = (int)(v[2].len / (Py_ssize_t)sizeof(int)), i, fits = count <= 3 * r->parts + 2;
        for (i = 0; fits && i < count; i++)
            fits = ((const int *)v[2].buf)[i] >= START && ((const int *)v[2].buf)[i] < KINDS;
        if (fits) {
            r->status = OK;
            run_take(r, &self->buffers, mode, count, v[2].buf, v[3].buf);
            result = progress(self);
        }
    }
    if (!result && !PyErr_Occurred())
        PyErr_SetString(PyExc_ValueError, "not what can follow the pending event");
    release(v, 4);
    return result;
}

static PyObject *add_entry(RunObject *self, PyObject *args)
{
    Ledger *l = &self->run.ledger;
    double value;
    int entry;
    if (!PyArg_ParseTuple(args, "id", &entry, &value) || !idle(self))
        return NULL;
    if (!l->wanted || entry < 0 || entry >= l->count) {
        PyErr_SetString(PyExc_ValueError, "no such entry of the ledger");
        return NULL;
    }
    l->entries[entry] = l->entries[entry] + value;
    Py_RETURN_NONE;
}

static PyObject *doubt_here(RunObject *self, PyObject *args)
{
    Certificate *c = &self->run.certificate;
    double anchor;
    if (!PyArg_ParseTuple(args, "d", &anchor))
        return NULL;
    if (anchor != c->doubted) {
        if (c->uncertified == 0)
            c->first_doubt = anchor;
        c->uncertified += 1;
        c->doubted = anchor;
    }
    Py_RETURN_NONE;
}

static PyObject *state_at(RunObject *self, PyObject *args)
{
    Run *r = &self->run;
    double t;
    int done;
    if (!PyArg_ParseTuple(args, "d", &t) || !ready(self))
        return NULL;
    self->busy = 1;
    Py_BEGIN_ALLOW_THREADS
    done = run_state_at(r, t, &r->scratch);
    Py_END_ALLOW_THREADS
    self->busy = 0;
    if (!done)
        Py_RETURN_NONE;
    if (done < 0)
        Py_RETURN_FALSE;
    return state_tuple(r, &r->scratch);
}

static PyObject *tally(RunObject *self, PyObject *none)
{
    const Run *r = &self->run;
    PyObject *counts, *entries;
    int i;
    (void)none;
    if (!ready(self) || (counts = PyTuple_New(KINDS)) == NULL)
        return NULL;
    if ((entries = PyTuple_New(r->ledger.count)) == NULL) {
        Py_DECREF(counts);
        return NULL;
    }
    for (i = 0; i < r->ledger.count; i++)
        PyTuple_SET_ITEM(entries, i, PyFloat_FromDouble(r->ledger.entries[i]));
    for (i = 0; i < KINDS; i++)
        PyTuple_SET_ITEM(counts, i, PyLong_FromDouble(r->counts[i]));
    return Py_BuildValue("{sNsNsNsdsdsds(dddd)sisdsi}", "state", state_tuple(r, &r->state), "counts", counts, "entries", entries, "worked_to", run_worked_to(r), "steps", r->steps,
                         "evaluations", r->evaluations, "certificate", r->certificate.uncertified, r->certificate.first_doubt,
                         r->certificate.margin, r->certificate.margin_time, "violated_once", r->violated_once,
                         "first_violation", r->first_violation, "mode", r->mode_number);
}

static PyObject *list_of(const double *values, int count, int stride)
{
    PyObject *list = PyList_New(count);
    int i;
    for (i = 0; list && i < count; i++)
        PyList_SET_ITEM(list, i, PyFloat_FromDouble(values[i * stride]));
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
static PyObject *table_of(const double *values, int count, int width, int step, int stride)
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

static PyObject *extremes(RunObject *self, PyObject *none)
{
    const Extremes *e = &self->run.extremes;
    (void)none;
    if (!ready(self))
        return NULL;
    return Py_BuildValue("NNN", list_of(e->least, e->count, 1), list_of(e->greatest, e->count, 1), list_of(e->margins, e->gap_count, 1));
}

static PyObject *disturbances(RunObject *self, PyObject *none)
{
    const Tangent *b = self->run.tangent;
    (void)none;
    if (!ready(self))
        return NULL;
    if (!b) {
        PyErr_SetString(PyExc_ValueError, "the run carries no disturbances");
        return NULL;
    }
    return Py_BuildValue("{sOsNsNsNsNsisdsds(Ldd)sNs(Ld)}", "complete", b->complete ? Py_True : Py_False, "rows",
                         table_of(b->rows, b->row_count, 1 + b->count, 1 + b->count, 1), "vectors",
                         table_of(b->vectors, b->possible, b->size, 1, b->stride), "columns", list_of_ints(b->columns, b->count), "lost",
                         list_of_ints(b->lost, b->count), "losses", b->losses, "pieces", b->pieces, "residual", b->residual, "near",
                         b->tangencies.count, b->tangencies.closest, b->tangencies.closest_time, "fastest",
                         list_of(b->tangencies.fastest, b->stop_count, 1), "undefined", b->tangencies.undefined,
                         b->tangencies.undefined_time);
}

/* Fills `out` with what a motion with disturbances has come to: doubts, margin, number of the mode, events without a derivative and
 * when the first was; t, x and v of each body, phase, turns, w; rates of x, v, phi, w where there is a motor; disturbances, one
 * after the other. Rates and disturbances are left out where none were carried. How many numbers there are.
 */
static PyObject *outcome(RunObject *self, PyObject *args)
{
    const Run *r = &self->run;
    const Tangent *b = r->tangent;
    const State *s = &r->state;
    Py_buffer view;
    double *at;
    int n = r->bodies, i, k;
    Py_ssize_t count = 5 + 4 + 2 * n + (b ? (1 + b->possible) * b->size : 0);
    if (!ready(self) || !PyArg_ParseTuple(args, "w*", &view))
        return NULL;
    if (view.len < count * (Py_ssize_t)sizeof(double)) {
        PyBuffer_Release(&view);
        PyErr_SetString(PyExc_ValueError, "no room for the outcome");
        return NULL;
    }
    at = view.buf;
    *at++ = r->certificate.uncertified;
    *at++ = r->certificate.margin;
    *at++ = r->mode_number;
    *at++ = b ? (double)b->tangencies.undefined : 0.0;
    *at++ = b ? b->tangencies.undefined_time : 0.0;
    *at++ = s->t;
    memcpy(at, s->x, (size_t)n * sizeof(double));
    memcpy(at + n, s->v, (size_t)n * sizeof(double));
    at += 2 * n;
    *at++ = s->phase;
    *at++ = s->turns;
    *at++ = s->w;
    if (b) {
        double rotor = accelerations(r, r->mode, s, b->accelerations);
        memcpy(at, s->v, (size_t)n * sizeof(double));
        memcpy(at + n, b->accelerations, (size_t)n * sizeof(double));
        at += 2 * n;
        if (r->has_motor) {
            *at++ = s->w;
            *at++ = rotor;
        }
        for (i = 0; i < b->possible; i++)
            for (k = 0; k < b->size; k++)
                *at++ = b->vectors[k * b->stride + i];
    }
    PyBuffer_Release(&view);
    return PyLong_FromSsize_t(count);
}

/* What the pending event does to the disturbances, where Python takes it: those that it left, and whether it moved them. */
static PyObject *hand_jump(RunObject *self, PyObject *args)
{
    Tangent *b = self->run.tangent;
    Py_buffer v;
    Handed h = {1, 0, 0, 0, 1.0, 1.0};
    int i, k, fits;
    if (!PyArg_ParseTuple(args, "pdidpy*", &h.jumps, &h.determinant, &h.tangencies, &h.closest, &h.undefined, &v))
        return NULL;
    fits = ready(self) && b && self->run.status == UNDECIDED && v.len == (Py_ssize_t)sizeof(double) * b->possible * b->size;
    for (i = 0; fits && i < b->possible; i++)
        for (k = 0; k < b->size; k++)
            b->vectors[k * b->stride + i] = ((const double *)v.buf)[i * b->size + k];
    PyBuffer_Release(&v);
    if (!fits) {
        if (!PyErr_Occurred())
            PyErr_SetString(PyExc_ValueError, "no event that waits for its jump");
        return NULL;
    }
    b->handed = h;
    Py_RETURN_NONE;
}

/* Without the GIL two threads may call one Run: each call holds it, and while it computes `busy` turns others away. */
#if PY_VERSION_HEX < 0x030D0000
#define Py_BEGIN_CRITICAL_SECTION(object) {
#define Py_END_CRITICAL_SECTION() }
#endif
#define ALONE(method)                                                                                                 \
    static PyObject *method##_alone(RunObject *self, PyObject *args)                                                  \
    {                                                                                                                 \
        PyObject *answer;                                                                                             \
        Py_BEGIN_CRITICAL_SECTION(self);                                                                              \
        answer = method(self, args);                                                                                  \
        Py_END_CRITICAL_SECTION();                                                                                    \
        return answer;                                                                                                \
    }
ALONE(add_mode)
ALONE(renew_mode)
ALONE(keep_ledger)
ALONE(set_meters)
ALONE(keep_tangent)
ALONE(keep_extremes)
ALONE(keep_blows)
ALONE(keep_section)
ALONE(set_rule)
ALONE(fill)
ALONE(start)
ALONE(rewind_run)
ALONE(retune)
ALONE(advance)
ALONE(pending)
ALONE(take)
ALONE(add_entry)
ALONE(doubt_here)
ALONE(state_at)
ALONE(extremes)
ALONE(disturbances)
ALONE(outcome)
ALONE(hand_jump)
ALONE(tally)

static PyMethodDef methods[] = {
    {"add_mode", (PyCFunction)add_mode_alone, METH_VARARGS, "add_mode(ints, doubles) -> its number"},
    {"renew_mode", (PyCFunction)renew_mode_alone, METH_VARARGS,
     "renew_mode(mode, ints, doubles): other numbers in rows of the same form; `rewind` and `start` have to follow"},
    {"keep_ledger", (PyCFunction)keep_ledger_alone, METH_VARARGS, "keep_ledger(ints, doubles): before the start"},
    {"set_meters", (PyCFunction)set_meters_alone, METH_VARARGS, "set_meters(mode, ints, doubles): what the ledger integrates there"},
    {"keep_tangent", (PyCFunction)keep_tangent_alone, METH_VARARGS, "keep_tangent(ints, doubles): before the start"},
    {"keep_extremes", (PyCFunction)keep_extremes_alone, METH_VARARGS, "keep_extremes(ints, doubles): before the start and `fill`"},
    {"keep_blows", (PyCFunction)keep_blows_alone, METH_VARARGS, "keep_blows(ints, doubles): before the start"},
    {"keep_section", (PyCFunction)keep_section_alone, METH_VARARGS,
     "keep_section(cycles, cycles_lo, turns): the period; before the start"},
    {"set_rule", (PyCFunction)set_rule_alone, METH_VARARGS,
     "set_rule(mode, event, (rule, target, other, hold, kind, part, key, order)): what follows the event"},
    {"fill", (PyCFunction)fill_alone, METH_VARARGS,
     "fill(samples, sample_modes, events, event_codes, section): arrays that take what is computed from now on, from their start"},
    {"start", (PyCFunction)start_alone, METH_VARARGS, "start(mode, state, known) -> as advance"},
    {"rewind", (PyCFunction)rewind_run_alone, METH_VARARGS,
     "rewind(t_end): as before the start, without disturbances; modes and rules are kept"},
    {"retune", (PyCFunction)retune_alone, METH_VARARGS,
     "retune(doubles): the numbers of another scene of the same modes; `rewind` and `start` have to follow"},
    {"advance", (PyCFunction)advance_alone, METH_NOARGS,
     "advance() -> (samples, events, section, finished, status): how many the arrays hold\n\n"
     "Compute on until an array is full, a slice of work is done, Python has to decide or the run ends."},
    {"pending", (PyCFunction)pending_alone, METH_NOARGS, "pending() -> (mode, event, order of its zero at the start of the stretch, state) that Python has to decide"},
    {"take", (PyCFunction)take_alone, METH_VARARGS,
     "take(mode, state, known, kinds, parts) -> as advance\n\n"
     "Go on behind the pending event; known: order by key, -1 where nothing is said."},
    {"add_entry", (PyCFunction)add_entry_alone, METH_VARARGS, "add_entry(entry, value): to the ledger, what an event adds"},
    {"doubt", (PyCFunction)doubt_here_alone, METH_VARARGS, "doubt(t): count what happened at t as not proved"},
    {"state_at", (PyCFunction)state_at_alone, METH_VARARGS,
     "state_at(t) -> state before the next event, None where more work is to do, False where an event comes before t; "
     "t ascending from call to call"},
    {"extremes", (PyCFunction)extremes_alone, METH_NOARGS, "extremes() -> lists of the least, the greatest, the smallest gaps"},
    {"disturbances", (PyCFunction)disturbances_alone, METH_NOARGS, "disturbances() -> dict of what a TangentBundle tells"},
    {"outcome", (PyCFunction)outcome_alone, METH_VARARGS,
     "outcome(out) -> how many numbers: fills `out` with what a motion that carries disturbances has come to"},
    {"hand_jump", (PyCFunction)hand_jump_alone, METH_VARARGS,
     "hand_jump(jumps, determinant, tangencies, closest, undefined, vectors): what the pending event, which Python takes, did to disturbances"},
    {"tally", (PyCFunction)tally_alone, METH_NOARGS, "tally() -> dict of state, counts and margins"},
    {NULL, NULL, 0, NULL},
};

static PyTypeObject run_type = {
    PyVarObject_HEAD_INIT(NULL, 0).tp_name = "vibsim.engine._engine.Run",
    .tp_doc = "Run(ints, doubles): a run of a packed scene.",
    .tp_basicsize = sizeof(RunObject),
    .tp_flags = Py_TPFLAGS_DEFAULT,
    .tp_new = Run_new,
    .tp_dealloc = (destructor)Run_dealloc,
    .tp_methods = methods,
};

static struct PyModuleDef module = {
    PyModuleDef_HEAD_INIT, "_engine", "The C engine of vibsim; use vibsim.engine.", -1, NULL, NULL, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__engine(void)
{
    PyObject *made;
    if (PyType_Ready(&run_type) < 0 || (made = PyModule_Create(&module)) == NULL)
        return NULL;
    keep_freed_memory();
#ifdef Py_GIL_DISABLED
    PyUnstable_Module_SetGIL(made, Py_MOD_GIL_NOT_USED);
#endif
    Py_INCREF(&run_type);
    if (PyModule_AddObject(made, "Run", (PyObject *)&run_type) < 0) {
        Py_DECREF(&run_type);
        Py_DECREF(made);
        return NULL;
    }
    return made;
}
