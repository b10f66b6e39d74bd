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
    memset(b, 0, sizeof *b);
    b->samples = (Real *)views[0].buf;
    b->sample_modes = (signed char *)views[1].buf;
    b->events = (Real *)views[2].buf;
    b->event_codes = (signed char *)views[3].buf;
    b->section = (Real *)views[4].buf;
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

static PyObject *start(RunObject *self, PyObject *args)
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

static PyObject *rewind_run(RunObject *self, PyObject *args)
{
    Real t_end;
    if (!PyArg_ParseTuple(args, "O&", number_from, &t_end) || !run_is_idle(self))
        return NULL;
    run_rewind(&self->run, t_end);
    self->started = 0;
    Py_RETURN_NONE;
}

/* The doubles of a scene of the same shape, whose modes are renewed where rows hold others; a start has to follow. */
static PyObject *retune(RunObject *self, PyObject *args)
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

static PyObject *advance(RunObject *self, PyObject *args)
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

static PyObject *pending(RunObject *self, PyObject *none)
{
    (void)none;
    if (!run_is_ready(self))
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

static PyObject *add_entry(RunObject *self, PyObject *args)
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

static PyObject *doubt_here(RunObject *self, PyObject *args)
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
static PyObject *states_at(RunObject *self, PyObject *args)
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

#define ALONE(method)                                                                                                 \
    static PyObject *method##_alone(RunObject *self, PyObject *args)                                                  \
    {                                                                                                                 \
        PyObject *answer;                                                                                             \
        Py_BEGIN_CRITICAL_SECTION(self);                                                                              \
        answer = method(self, args);                                                                                  \
        Py_END_CRITICAL_SECTION();                                                                                    \
        return answer;                                                                                                \
    }
ALONE(run_add_mode)
ALONE(run_forget_modes)
ALONE(run_renew_mode)
ALONE(run_keep_ledger)
ALONE(run_set_integrals)
ALONE(run_set_slopes)
ALONE(run_keep_tangent)
ALONE(run_keep_extremes)
ALONE(run_keep_impacts)
ALONE(run_keep_section)
ALONE(run_record_from)
ALONE(run_pause_at)
ALONE(run_dither)
ALONE(run_kick)
ALONE(run_set_rule)
ALONE(fill)
ALONE(start)
ALONE(rewind_run)
ALONE(retune)
ALONE(advance)
ALONE(pending)
ALONE(take)
ALONE(add_entry)
ALONE(doubt_here)
ALONE(run_doubts)
ALONE(states_at)
ALONE(run_at_begin)
ALONE(run_extremes)
ALONE(run_disturbances)
ALONE(run_outcome)
ALONE(run_hand_jump)
ALONE(run_tally)
ALONE(run_look)
ALONE(run_derivatives)
ALONE(run_bounds)
ALONE(run_formulas)

static PyMethodDef methods[] = {
    {"add_mode", (PyCFunction)run_add_mode_alone, METH_VARARGS, "add_mode(ints, doubles) -> its number"},
    {"forget_modes", (PyCFunction)run_forget_modes_alone, METH_NOARGS,
     "forget_modes() -> the number that the mode of now had: it is 0 then, the only one, and has no rules"},
    {"renew_mode", (PyCFunction)run_renew_mode_alone, METH_VARARGS,
     "renew_mode(mode, ints, doubles): other numbers in rows of the same form; `rewind` and `start` have to follow"},
    {"keep_ledger", (PyCFunction)run_keep_ledger_alone, METH_VARARGS, "keep_ledger(ints, doubles): before the start"},
    {"set_integrals", (PyCFunction)run_set_integrals_alone, METH_VARARGS, "set_integrals(mode, ints, doubles): what the ledger integrates there"},
    {"set_slopes", (PyCFunction)run_set_slopes_alone, METH_VARARGS, "set_slopes(mode, ints, doubles): derivatives of its formulas"},
    {"keep_tangent", (PyCFunction)run_keep_tangent_alone, METH_VARARGS, "keep_tangent(ints, doubles): before the start"},
    {"keep_extremes", (PyCFunction)run_keep_extremes_alone, METH_VARARGS, "keep_extremes(ints, doubles): before the start and `fill`"},
    {"keep_impacts", (PyCFunction)run_keep_impacts_alone, METH_VARARGS, "keep_impacts(ints, doubles): before the start"},
    {"keep_section", (PyCFunction)run_keep_section_alone, METH_VARARGS,
     "keep_section(cycles, cycles_lo, turns, rotor): the period, or the rotor whose turns it is, else -1; before the start"},
    {"record_from", (PyCFunction)run_record_from_alone, METH_VARARGS,
     "record_from(samples, section): times [s] before which they are left out; before the start"},
    {"pause_at", (PyCFunction)run_pause_at_alone, METH_VARARGS, "pause_at(t): where `advance` ends, behind the stretch that reaches t"},
    {"dither", (PyCFunction)run_dither_alone, METH_VARARGS, "dither(which): how the times of events are moved; before the start"},
    {"kick", (PyCFunction)run_kick_alone, METH_VARARGS,
     "kick(seed): have states moved as doubles round, from the next start on; 0: not"},
    {"set_rule", (PyCFunction)run_set_rule_alone, METH_VARARGS,
     "set_rule(mode, event, (rule, target, other, hold, kind, part, key, order)): what follows the event"},
    {"fill", (PyCFunction)fill_alone, METH_VARARGS,
     "fill(samples, sample_modes, events, event_codes, section): arrays that take what is computed from now on, from their start"},
    {"start", (PyCFunction)start_alone, METH_VARARGS, "start(mode, state, known) -> as advance\n\n"
     "known: order by key; below zero that of a zero to be looked at once more."},
    {"rewind", (PyCFunction)rewind_run_alone, METH_VARARGS,
     "rewind(t_end): as before the start, without disturbances; modes and rules are kept"},
    {"retune", (PyCFunction)retune_alone, METH_VARARGS,
     "retune(doubles): the numbers of another scene of the same modes; `rewind` and `start` have to follow"},
    {"advance", (PyCFunction)advance_alone, METH_VARARGS,
     "advance(work) -> (samples, events, section, finished, status): how many the arrays hold\n\n"
     "Compute on until an array is full, a slice of work is done, Python has to decide or the run ends.\n"
     "work: 1 ends the slice behind one stretch, 0 behind an event that has its rule now; a slice of its own without it."},
    {"pending", (PyCFunction)pending_alone, METH_NOARGS, "pending() -> (mode, event, order of its zero at the start of the stretch, state) that Python has to decide"},
    {"take", (PyCFunction)take_alone, METH_VARARGS,
     "take(mode, state, known, kinds, parts) -> as advance\n\n"
     "Go on behind the pending event; known: order by key, -1 where nothing is said."},
    {"add_entry", (PyCFunction)add_entry_alone, METH_VARARGS, "add_entry(entry, value): to the ledger, what an event adds"},
    {"doubt", (PyCFunction)doubt_here_alone, METH_VARARGS, "doubt(t) -> its number among the doubts that are described: count what happened at t as not proved; -1 where it is counted already or they are enough"},
    {"doubts", (PyCFunction)run_doubts_alone, METH_NOARGS, "doubts() -> the first of them: (time, reason, mode, event, other)"},
    {"states_at", (PyCFunction)states_at_alone, METH_VARARGS,
     "states_at(times, states, codes, made) -> how many there are now: call again for more; what became of the run"},
    {"at_begin", (PyCFunction)run_at_begin_alone, METH_VARARGS, "at_begin(out): fills a column with the state at the time from which samples are recorded"},
    {"extremes", (PyCFunction)run_extremes_alone, METH_NOARGS, "extremes() -> lists of the least, the greatest, the smallest gaps"},
    {"disturbances", (PyCFunction)run_disturbances_alone, METH_NOARGS, "disturbances() -> disturbances and how close events were to tangency"},
    {"outcome", (PyCFunction)run_outcome_alone, METH_VARARGS,
     "outcome(out) -> how many numbers: fills `out` with what a motion that carries disturbances has come to"},
    {"hand_jump", (PyCFunction)run_hand_jump_alone, METH_VARARGS,
     "hand_jump(jumps, determinant, tangencies, closest, undefined, vectors): what the pending event, which Python takes, did to disturbances"},
    {"look", (PyCFunction)run_look_alone, METH_VARARGS,
     "look(mode, state) -> length of a step: expand the motion there; of a run that is not started"},
    {"derivatives", (PyCFunction)run_derivatives_alone, METH_VARARGS,
     "derivatives(event, count) -> those of order 0 to `count` of an event function where the motion was looked at"},
    {"bounds", (PyCFunction)run_bounds_alone, METH_VARARGS,
     "bounds(event, count, exact, summed, span) -> of the rounding of derivatives, see `taylor_bounds` in engine.h"},
    {"formulas", (PyCFunction)run_formulas_alone, METH_NOARGS, "formulas() -> values of the outputs of the mode's tape there"},
    {"tally", (PyCFunction)run_tally_alone, METH_NOARGS, "tally() -> dict of state, counts and margins"},
    {NULL, NULL, 0, NULL},
};

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
