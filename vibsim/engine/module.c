/* The Python face of the C engine: the type Run. The GIL is released while it computes, and not needed elsewhere. */
#include "run_object.h" /* with Python.h, which goes first */

#include "certificate.h"
#include "lanes.h"

#include <string.h>

#define JOINED(a, b) a##b
#define NAMED(a, b) JOINED(a, b)
#define QUOTED(text) #text
#define TEXT(of) QUOTED(of)
#ifdef WORDS_BY_RUN
#define MODULE "_engine_words"
#define INIT PyInit__engine_words
#elif defined(LIMBS)
#define MODULE "_engine_" TEXT(LIMBS)
#define INIT NAMED(PyInit__engine_, LIMBS)
#else
#define MODULE "_engine"
#define INIT PyInit__engine
#endif

#ifdef WORDS_BY_RUN
#define MOST_UNHEARD 1e8 /* products of words between two looks for signals: some 0.1 s */

int is_interrupted(Run *r, int n)
{
    return hears_signal(r, r->columns + (3.0 + r->mode->tape.op_count + 3 * r->rotors.count) * n);
}

int hears_signal(Run *r, double products)
{
    const int bits = 1 - unit_roundoff.exponent;
    PyGILState_STATE gil;
    if (!r->hears)
        return 0;
    r->unheard += (double)WORDS * WORDS * products;
    if (r->interrupted || r->unheard < MOST_UNHEARD)
        return r->interrupted;
    r->unheard = 0;
    gil = PyGILState_Ensure();
    r->interrupted = PyErr_CheckSignals() < 0 ? FLOW : 0;
    set_precision(bits); /* who is called by a signal may have computed with other numbers */
    PyGILState_Release(gil);
    return r->interrupted;
}
#endif

#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wmissing-field-initializers" /* what is not said of a type is 0 */
#endif
static PyTypeObject run_type = {PyVarObject_HEAD_INIT(NULL, 0)};

static PyObject *Run_new(PyTypeObject *type, PyObject *args, PyObject *named)
{
    Py_buffer v[2];
    Reader in;
    RunObject *self = NULL;
    int bits = 53;
    (void)named;
#ifdef LIMBS
    if (!PyArg_ParseTuple(args, "y*y*i", &v[0], &v[1], &bits))
        return NULL;
    if (!bits_fit(bits)) {
        PyBuffer_Release(&v[0]);
        PyBuffer_Release(&v[1]);
        return NULL;
    }
    set_precision(bits);
#else
    if (!PyArg_ParseTuple(args, "y*y*", &v[0], &v[1]))
        return NULL;
#endif
    if (reader_of(&v[0], &v[1], &in) == 0 && (self = (RunObject *)type->tp_alloc(type, 0)) != NULL && !scene_read(&self->run, &in)) {
        Py_CLEAR(self);
        PyErr_SetString(PyExc_ValueError, "the packed numbers are no scene");
    }
    if (self)
        self->bits = bits;
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

static int buffers_of(const Run *r, Py_buffer *views, Buffers *b)
{
    Py_ssize_t state = 3 + 2 * r->bodies, row = (Py_ssize_t)sizeof(Real), section = state + 2 * r->extremes.pairs;
    Py_ssize_t event = state + 2 + r->bodies + r->switches;
    memset(b, 0, sizeof *b);
    b->samples = (Real *)views[0].buf;
    b->sample_modes = (signed char *)views[1].buf;
    b->events = (Real *)views[2].buf;
    b->event_codes = (signed char *)views[3].buf;
    b->section = (Real *)views[4].buf;
    b->sample_room = (long)(views[0].len / (state * row));
    b->event_room = (long)(views[2].len / (event * row));
    b->section_room = (long)(views[4].len / (section * row));
    if (b->sample_room < 1 || b->event_room < 8 + 3 * r->parts || views[0].len != b->sample_room * state * row ||
        views[2].len != b->event_room * event * row || views[1].len != (Py_ssize_t)b->sample_room * r->parts ||
        views[3].len != (Py_ssize_t)b->event_room * (2 + r->parts) || views[4].len != b->section_room * section * row ||
        b->section_room == 1) {
        PyErr_SetString(PyExc_ValueError, "buffers do not fit together");
        return -1;
    }
    return 0;
}

PyObject *Run_fill(RunObject *self, PyObject *args)
{
    Py_buffer v[BUFFERS];
    Buffers b;
    if (!PyArg_ParseTuple(args, "w*w*w*w*w*", &v[0], &v[1], &v[2], &v[3], &v[4]))
        return NULL;
    if (!run_is_idle(self) || buffers_of(&self->run, v, &b) != 0) {
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
int read_state(const Run *r, const Py_buffer *view, State *s)
{
    const Real *row = (const Real *)view->buf;
    int c;
    if (view->len != (Py_ssize_t)((4 + 2 * r->bodies) * (int)sizeof(Real))) {
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

/* Orders of known zeros by key, as bytes of int; there may be more of them than this run has met. */
static int read_known(const Run *r, const Py_buffer *view, int *known)
{
    const int *values = (const int *)view->buf;
    Py_ssize_t count = view->len / (Py_ssize_t)sizeof(int), k;
    if (count < r->key_count) {
        PyErr_SetString(PyExc_ValueError, "not the orders of the known zeros");
        return -1;
    }
    for (k = 0; k < r->key_count; k++)
        known[k] = values[k] < -MAX_ORDER ? -MAX_ORDER : values[k];
    return 0;
}

PyObject *Run_start(RunObject *self, PyObject *args)
{
    Run *r = &self->run;
    Py_buffer v[2];
    int mode, k;
    PyObject *result = NULL;
    if (!PyArg_ParseTuple(args, "iy*y*", &mode, &v[0], &v[1]))
        return NULL;
    if (!run_is_idle(self) || self->started || !self->view_count || mode < 0 || mode >= r->mode_count) {
        if (!PyErr_Occurred())
            PyErr_SetString(PyExc_ValueError, "cannot start here");
    } else if (read_state(r, &v[0], &r->state) == 0 && read_known(r, &v[1], r->known) == 0) {
        for (k = 0; k < r->key_count; k++) {
            r->behind[k] = r->known[k] < 0 ? NOTHING : 0;
            r->known[k] = r->known[k] < 0 ? -r->known[k] : r->known[k];
        }
        self->started = 1;
        self->looked = 0;
        self->buffers.sample_count = self->buffers.event_count = self->buffers.section_count = 0;
        run_start(r, mode, &self->buffers);
        self->started = !r->interrupted;
        result = r->interrupted ? NULL : progress(self);
        r->interrupted = 0;
    }
    release(v, 2);
    return result;
}

PyObject *Run_rewind(RunObject *self, PyObject *args)
{
    Real t_end;
    if (!PyArg_ParseTuple(args, "O&", number_from, &t_end) || !run_is_idle(self))
        return NULL;
    run_rewind(&self->run, t_end);
    self->started = 0;
    Py_RETURN_NONE;
}

/* The doubles of a scene of the same shape, whose modes are renewed where rows hold others; a start has to follow. */
PyObject *Run_retune(RunObject *self, PyObject *args)
{
    Py_buffer v[2];
    Reader in;
    int done = 0;
    memset(v, 0, sizeof v);
    if (!PyArg_ParseTuple(args, "y*", &v[1]))
        return NULL;
    if (run_is_idle(self) && reader_of(&v[0], &v[1], &in) == 0 && !(done = scene_retune(&self->run, &in)))
        PyErr_SetString(PyExc_ValueError, "not the numbers of a scene of that shape");
    self->started = self->looked = 0;
    PyBuffer_Release(&v[1]);
    if (!done)
        return NULL;
    Py_RETURN_NONE;
}

PyObject *Run_advance(RunObject *self, PyObject *args)
{
    const double whole = self->run.work_at_once;
    double work = whole;
    if (!PyArg_ParseTuple(args, "|d", &work) || !run_is_ready(self))
        return NULL;
    self->busy = 1;
    self->run.work_at_once = work;
    Py_BEGIN_ALLOW_THREADS
    run_advance(&self->run, &self->buffers);
    Py_END_ALLOW_THREADS
    self->run.work_at_once = whole;
    self->busy = 0;
    return self->run.interrupted ? NULL : progress(self);
}

/* Without the GIL two threads may call one Run: each call holds it, and while it computes `busy` turns others away. */
#if PY_VERSION_HEX < 0x030D0000
#define Py_BEGIN_CRITICAL_SECTION(object) {
#define Py_END_CRITICAL_SECTION() }
#endif

#ifndef LIMBS
/* Several runs, each as by `advance`: their steps are taken side by side. */
PyObject *advance_together(PyObject *module, PyObject *args)
{
    enum { MOST = 64 }; /* see SIDE_BY_SIDE in vibsim/sweeps/points.py */
    PyObject *tuple, *answer = NULL;
    int widest = MOST;
    Run *runs[MOST];
    Buffers *buffers[MOST];
    Py_ssize_t count, held, i;
    (void)module;
    if (!PyArg_ParseTuple(args, "O!|i", &PyTuple_Type, &tuple, &widest))
        return NULL;
    count = PyTuple_GET_SIZE(tuple);
    for (held = 0; held < count && held < MOST; held++) {
        RunObject *one = (RunObject *)PyTuple_GET_ITEM(tuple, held);
        int ready;
        if (Py_TYPE(one) != &run_type)
            break;
        Py_BEGIN_CRITICAL_SECTION(one);
        ready = run_is_ready(one);
        one->busy = ready || one->busy;
        Py_END_CRITICAL_SECTION();
        if (!ready)
            break;
        runs[held] = &one->run;
        buffers[held] = &one->buffers;
    }
    if (held == count) {
        Py_BEGIN_ALLOW_THREADS
        runs_advance(runs, buffers, (int)count, widest);
        Py_END_ALLOW_THREADS
        answer = PyList_New(count);
    } else if (!PyErr_Occurred()) {
        PyErr_SetString(PyExc_ValueError, "up to 64 runs that have been started are needed");
    }
    for (i = 0; i < held; i++) {
        RunObject *one = (RunObject *)PyTuple_GET_ITEM(tuple, i);
        PyObject *of = answer == NULL ? NULL : one->run.waits ? Py_NewRef(Py_None) : progress(one);
        if (of)
            PyList_SET_ITEM(answer, i, of);
        else
            Py_CLEAR(answer);
        Py_BEGIN_CRITICAL_SECTION(one);
        one->busy = 0;
        Py_END_CRITICAL_SECTION();
    }
    return answer;
}
#endif

/* Order of the zero of the pending event's function that the stretch began with. */
static int pending_order(const Run *r)
{
    const Event *e = r->pending_event == NOTHING ? NULL : &r->mode->events[r->pending_event];
    return e == NULL || (e->kind != STRIKE && r->pending_tau != 0) ? 0 : r->known[e->key];
}

PyObject *Run_pending(RunObject *self, PyObject *none)
{
    (void)none;
    if (!run_is_ready(self))
        return NULL;
    return Py_BuildValue("iiiN", self->run.mode_number, self->run.pending_event, pending_order(&self->run),
                         state_tuple(&self->run, &self->run.next));
}

PyObject *Run_take(RunObject *self, PyObject *args)
{
    Run *r = &self->run;
    Py_buffer v[4];
    int mode;
    PyObject *result = NULL;
    if (!PyArg_ParseTuple(args, "iy*y*y*y*", &mode, &v[0], &v[1], &v[2], &v[3]))
        return NULL;
    if (run_is_ready(self) && r->status == UNDECIDED && mode >= 0 && mode < r->mode_count && v[2].len == v[3].len &&
        read_state(r, &v[0], &r->next) == 0 && read_known(r, &v[1], r->behind) == 0) {
        int count = (int)(v[2].len / (Py_ssize_t)sizeof(int)), i, fits = count <= 3 * r->parts + 2;
        for (i = 0; fits && i < count; i++)
            fits = ((const int *)v[2].buf)[i] >= START && ((const int *)v[2].buf)[i] < KINDS;
        if (fits) {
            r->status = OK;
            run_take(r, &self->buffers, mode, count, (const int *)v[2].buf, (const int *)v[3].buf);
            result = r->interrupted ? NULL : progress(self);
        }
    }
    if (!result && !PyErr_Occurred())
        PyErr_SetString(PyExc_ValueError, "not what can follow the pending event");
    release(v, 4);
    return result;
}

PyObject *Run_add_entry(RunObject *self, PyObject *args)
{
    Ledger *l = &self->run.ledger;
    Real value;
    int entry;
    if (!PyArg_ParseTuple(args, "iO&", &entry, number_from, &value) || !run_is_idle(self))
        return NULL;
    if (!l->wanted || entry < 0 || entry >= l->count) {
        PyErr_SetString(PyExc_ValueError, "no such entry of the ledger");
        return NULL;
    }
    l->entries[entry] = l->entries[entry] + value;
    Py_RETURN_NONE;
}

PyObject *Run_doubt(RunObject *self, PyObject *args)
{
    Certificate *c = &self->run.certificate;
    Real t;
    int count;
    if (!PyArg_ParseTuple(args, "O&", number_from, &t))
        return NULL;
    count = described(c);
    return PyLong_FromLong(doubt(c, t, t, DECISION, NOTHING, NOTHING) && count < MOST_DOUBTS ? count : NOTHING);
}

/* States at ascending times and what each part does then, into their columns, from the time with the index `made` on. Events on
 * the way are recorded nowhere.
 */
PyObject *Run_states_at(RunObject *self, PyObject *args)
{
    Run *r = &self->run;
    Py_buffer v[3];
    PyObject *answer = NULL;
    Py_ssize_t made, count;
    if (!PyArg_ParseTuple(args, "y*w*w*n", &v[0], &v[1], &v[2], &made))
        return NULL;
    count = v[0].len / (Py_ssize_t)sizeof(Real);
    if (made < 0 || made > count || v[1].len != (3 + 2 * r->bodies) * count * (Py_ssize_t)sizeof(Real) || v[2].len != count * r->parts) {
        PyErr_SetString(PyExc_ValueError, "no room for the states at these times");
    } else if (run_is_ready(self)) {
        const Real *times = (const Real *)v[0].buf;
        Real *states = (Real *)v[1].buf;
        signed char *codes = (signed char *)v[2].buf;
        self->busy = 1;
        Py_BEGIN_ALLOW_THREADS
        r->spent = 0;
        self->buffers.event_count = 0;
        while (made < count && r->spent <= r->work_at_once && run_state_at(r, &self->buffers, times[made], &r->scratch) > 0) {
            write_state(r, states + made, (long)count, &r->scratch);
            write_codes(r, codes + made, (long)count, 1);
            made += 1;
            r->spent += 1;
        }
        Py_END_ALLOW_THREADS
        self->busy = 0;
        answer = r->interrupted ? NULL : Py_BuildValue("ni", made, r->status);
    }
    release(v, 3);
    return answer;
}

#define ALONE(name, flags, text)                                                                                      \
    static PyObject *name##_alone(RunObject *self, PyObject *args)                                                    \
    {                                                                                                                 \
        PyObject *answer;                                                                                             \
        Py_BEGIN_CRITICAL_SECTION(self);                                                                              \
        answer = Run_##name(self, args);                                                                              \
        Py_END_CRITICAL_SECTION();                                                                                    \
        return answer;                                                                                                \
    }
RUN_METHODS(ALONE)

#define ENTRY(name, flags, text) {#name, (PyCFunction)name##_alone, flags, text},
static PyMethodDef methods[] = {RUN_METHODS(ENTRY){NULL, NULL, 0, NULL}};

static void describe_type(void)
{
    run_type.tp_name = "vibsim.engine." MODULE ".Run";
    run_type.tp_doc = "Run(ints, doubles): a run of a packed scene.";
    run_type.tp_basicsize = sizeof(RunObject);
    run_type.tp_flags = Py_TPFLAGS_DEFAULT;
    run_type.tp_new = Run_new;
    run_type.tp_dealloc = (destructor)Run_dealloc;
    run_type.tp_methods = methods;
}

#ifndef LIMBS
#define NAME(CODE, name, of, sign, text) #name " "
#define FUNCTIONS double_functions
#else
#define FUNCTIONS number_functions
#endif

static struct PyModuleDef module = {
    PyModuleDef_HEAD_INIT, MODULE, "The C engine of vibsim; use vibsim.engine.", -1, FUNCTIONS, NULL, NULL, NULL, NULL,
};

PyMODINIT_FUNC INIT(void)
{
    PyObject *made;
    describe_type();
    if (PyType_Ready(&run_type) < 0 || (made = PyModule_Create(&module)) == NULL)
        return NULL;
    if (PyModule_AddFunctions(made, elementary_functions) < 0)
        return NULL;
#ifdef LIMBS
    if (numbers_ready() < 0)
        return NULL;
#else
    keep_freed_memory();
    if (PyModule_AddStringConstant(made, "FUNCTIONS", ELEMENTARY_FUNCTIONS(NAME)) < 0 ||
        PyModule_AddIntConstant(made, "LANES", lanes_in_a_vector(RUNS_AT_ONCE)) < 0)
        return NULL;
#endif
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
