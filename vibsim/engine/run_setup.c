/* What a run is told of: modes, rules, ledgers, disturbances, impacts, section. */
#include "run_object.h"

#include <string.h>

int reader_of(const Py_buffer *ints, const Py_buffer *doubles, Reader *in)
{
    memset(in, 0, sizeof *in);
    if (ints->len % (Py_ssize_t)sizeof(int) || doubles->len % (Py_ssize_t)sizeof(Real)) {
        PyErr_SetString(PyExc_ValueError, "packed numbers of the wrong size");
        return -1;
    }
    in->ints = (const int *)ints->buf;
    in->doubles = (const Real *)doubles->buf;
    in->int_count = (long)(ints->len / (Py_ssize_t)sizeof(int));
    in->double_count = (long)(doubles->len / (Py_ssize_t)sizeof(Real));
    return 0;
}

static void take_precision(const RunObject *self)
{
#ifdef LIMBS
    set_precision(self->bits);
#else
    (void)self;
#endif
}

int run_is_idle(RunObject *self)
{
    if (self->busy)
        PyErr_SetString(PyExc_RuntimeError, "the run is being computed by another thread");
    take_precision(self);
    return !self->busy;
}

PyObject *Run_add_mode(RunObject *self, PyObject *args)
{
    Py_buffer v[2];
    Reader in;
    PyObject *result = NULL;
    if (!PyArg_ParseTuple(args, "y*y*", &v[0], &v[1]))
        return NULL;
    if (run_is_idle(self) && reader_of(&v[0], &v[1], &in) == 0) {
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

/* Forget all modes but that of a run under way, which becomes number 0 and loses the rules of its events. */
PyObject *Run_forget_modes(RunObject *self, PyObject *args)
{
    (void)args;
    if (!run_is_ready(self))
        return NULL;
    return PyLong_FromLong(modes_forget(&self->run));
}

/* A mode with other numbers in rows of the same form: what follows its events stays. */
PyObject *Run_renew_mode(RunObject *self, PyObject *args)
{
    Py_buffer v[2];
    Reader in;
    int number, renewed = 0;
    if (!PyArg_ParseTuple(args, "iy*y*", &number, &v[0], &v[1]))
        return NULL;
    if (run_is_idle(self) && reader_of(&v[0], &v[1], &in) == 0) {
        Mode *m = number >= 0 && number < self->run.mode_count ? mode_read(&self->run, &in) : NULL;
        renewed = m && read_through(&in) && mode_renew(&self->run, number, m);
        if (!renewed) {
            mode_free(m);
            PyErr_SetString(PyExc_ValueError, "the packed numbers are none of that mode");
        }
    }
    self->started = self->looked = 0;
    PyBuffer_Release(&v[0]);
    PyBuffer_Release(&v[1]);
    if (!renewed)
        return NULL;
    Py_RETURN_NONE;
}

/* Have `read` keep packed numbers before the start; an error says that it is too late for them, or that they are no such
   numbers, and `undo` drops what was read of those. */
static PyObject *keep_before_start(RunObject *self, PyObject *args, int late, int (*read)(Run *, Reader *), void (*undo)(Run *),
                                   const char *article, const char *what)
{
    Py_buffer v[2];
    Reader in;
    int kept = 0;
    if (!PyArg_ParseTuple(args, "y*y*", &v[0], &v[1]))
        return NULL;
    take_precision(self);
    if (late)
        PyErr_Format(PyExc_ValueError, "too late for %s%s", article, what);
    else if (reader_of(&v[0], &v[1], &in) == 0 && !(kept = read(&self->run, &in))) {
        if (undo)
            undo(&self->run);
        PyErr_Format(PyExc_ValueError, "the packed numbers are no %s", what);
    }
    PyBuffer_Release(&v[0]);
    PyBuffer_Release(&v[1]);
    if (!kept)
        return NULL;
    Py_RETURN_NONE;
}

PyObject *Run_keep_ledger(RunObject *self, PyObject *args)
{
    return keep_before_start(self, args, self->started || self->run.ledger.entries, ledger_read, NULL, "a ", "ledger");
}

/* Have `read` read packed numbers for a mode; an error says that the mode does not wait for them, or that they are no such numbers. */
static PyObject *set_of_mode(RunObject *self, PyObject *args, int (*waits)(const Run *, const Mode *), int (*read)(Run *, Mode *, Reader *),
                             const char *what)
{
    Py_buffer v[2];
    Reader in;
    int mode, kept = 0;
    if (!PyArg_ParseTuple(args, "iy*y*", &mode, &v[0], &v[1]))
        return NULL;
    if (run_is_idle(self)) {
        Mode *m = mode >= 0 && mode < self->run.mode_count ? self->run.modes[mode] : NULL;
        if (!m || !waits(&self->run, m))
            PyErr_Format(PyExc_ValueError, "no mode that waits for %s", what);
        else if (reader_of(&v[0], &v[1], &in) == 0 && !(kept = read(&self->run, m, &in)))
            PyErr_Format(PyExc_ValueError, "the packed numbers are no %s", what);
    }
    PyBuffer_Release(&v[0]);
    PyBuffer_Release(&v[1]);
    if (!kept)
        return NULL;
    Py_RETURN_NONE;
}

static int waits_for_integrals(const Run *r, const Mode *m)
{
    return r->ledger.wanted && !m->integrals.integrals;
}

PyObject *Run_set_integrals(RunObject *self, PyObject *args)
{
    return set_of_mode(self, args, waits_for_integrals, integrals_read, "integrals");
}

static int waits_for_slopes(const Run *r, const Mode *m)
{
    (void)r;
    return !m->formula_slopes.tape.ops;
}

/* Derivatives of the formulas of a mode, where disturbances are carried. */
PyObject *Run_set_slopes(RunObject *self, PyObject *args)
{
    return set_of_mode(self, args, waits_for_slopes, slopes_read, "derivatives");
}

static void drop_tangent(Run *r)
{
    tangent_free(r->tangent);
    r->tangent = NULL;
}

/* Small disturbances to carry along. */
PyObject *Run_keep_tangent(RunObject *self, PyObject *args)
{
    return keep_before_start(self, args, self->started || self->run.tangent, tangent_read, drop_tangent, "", "disturbances");
}

PyObject *Run_keep_extremes(RunObject *self, PyObject *args)
{
    int late = self->started || self->view_count || self->run.extremes.numbers;
    return keep_before_start(self, args, late, extremes_read, NULL, "", "extremes");
}

/* Rigid stops whose impacts C may take, in place of those kept before. */
PyObject *Run_keep_impacts(RunObject *self, PyObject *args)
{
    return keep_before_start(self, args, self->started, impacts_read, NULL, "", "rigid stops");
}

PyObject *Run_keep_section(RunObject *self, PyObject *args)
{
    Section *s = &self->run.section;
    int rotor;
    if (!PyArg_ParseTuple(args, "O&O&O&i", number_from, &s->cycles, number_from, &s->cycles_lo, number_from, &s->turns, &rotor))
        return NULL;
    if (rotor < -1 || rotor >= self->run.bodies)
        return PyErr_Format(PyExc_ValueError, "rotor must be the number of a body or -1, got %d", rotor);
    s->rotor = rotor + 1;
    Py_RETURN_NONE;
}

/* Times before which samples and section are not recorded. */
PyObject *Run_record_from(RunObject *self, PyObject *args)
{
    if (!PyArg_ParseTuple(args, "O&O&", number_from, &self->run.samples_from, number_from, &self->run.section_from))
        return NULL;
    Py_RETURN_NONE;
}

PyObject *Run_pause_at(RunObject *self, PyObject *args)
{
    if (!PyArg_ParseTuple(args, "O&", number_from, &self->run.pause))
        return NULL;
    Py_RETURN_NONE;
}

PyObject *Run_dither(RunObject *self, PyObject *args)
{
    int dither;
    if (!PyArg_ParseTuple(args, "i", &dither))
        return NULL;
    if (dither < 0 || dither > 31)
        return PyErr_Format(PyExc_ValueError, "dither must be 0 to 31, got %d", dither);
    self->run.dither = dither;
    Py_RETURN_NONE;
}

PyObject *Run_kick(RunObject *self, PyObject *args)
{
    if (!PyArg_ParseTuple(args, "K", &self->run.kicks))
        return NULL;
    Py_RETURN_NONE;
}

PyObject *Run_set_rule(RunObject *self, PyObject *args)
{
    Run *r = &self->run;
    Rule rule;
    int mode, event;
    if (!PyArg_ParseTuple(args, "ii(iiiiiiii)", &mode, &event, &rule.kind, &rule.target, &rule.other, &rule.hold, &rule.event, &rule.part,
                          &rule.key, &rule.order) ||
        !run_is_idle(self))
        return NULL;
    if (mode < 0 || mode >= r->mode_count || event < 0 || event >= r->modes[mode]->event_count || rule.kind < DECIDE_IN_PYTHON ||
        rule.kind > CROSS_IF_TIES_HOLD || rule.target < 0 || rule.target >= r->mode_count || rule.other < 0 || rule.other >= r->mode_count ||
        rule.event < NOTHING || rule.event >= KINDS || rule.key < 0 || rule.key >= r->key_count || rule.order < 0 || rule.order > MAX_ORDER) {
        PyErr_SetString(PyExc_ValueError, "no such rule");
        return NULL;
    }
    r->modes[mode]->events[event].rule = rule;
    Py_RETURN_NONE;
}

/* What the pending event does to the disturbances, where Python takes it, and those that it left. */
PyObject *Run_hand_jump(RunObject *self, PyObject *args)
{
    Tangent *b = self->run.tangent;
    Py_buffer v;
    Handed h = {1, SAME, 0, 0, 1.0, 1.0};
    int i, fits;
    if (!PyArg_ParseTuple(args, "iO&iO&py*", &h.kind, number_from, &h.determinant, &h.tangencies, number_from, &h.closest, &h.undefined, &v))
        return NULL;
    fits = run_is_ready(self) && b && self->run.status == UNDECIDED && h.kind >= SAME && h.kind <= JOINED &&
           v.len == (Py_ssize_t)sizeof(Real) * b->possible * b->size;
    for (i = 0; fits && i < b->possible; i++)
        put_vector(b, i, (const Real *)v.buf + i * b->size);
    PyBuffer_Release(&v);
    if (!fits) {
        if (!PyErr_Occurred())
            PyErr_SetString(PyExc_ValueError, "no event that waits for its jump");
        return NULL;
    }
    b->handed = h;
    Py_RETURN_NONE;
}
