/* What a run that is only looked through tells of the motion at a state: derivatives of event functions, with bounds of their
 * rounding, and values of formulas.
 */
#include "run_object.h"

/* Expand the motion of a mode at a state; the longest step from there. */
PyObject *Run_look(RunObject *self, PyObject *args)
{
    Run *r = &self->run;
    Py_buffer v;
    int mode;
    PyObject *answer = NULL;
    if (!PyArg_ParseTuple(args, "iy*", &mode, &v))
        return NULL;
    self->looked = 0;
    if (run_is_idle(self) && (self->started || mode < 0 || mode >= r->mode_count)) {
        PyErr_SetString(PyExc_ValueError, "cannot look there");
    } else if (!PyErr_Occurred() && read_state(r, &v, &r->scratch) == 0) {
        r->mode = r->modes[mode];
#ifdef FIXED_SERIES
        r->mode->scales.most = 0; /* what was looked at before has no say */
#endif
        r->hears = 1;
        taylor_look(r, &r->scratch);
        r->hears = 0;
        self->looked = !r->interrupted;
        answer = r->interrupted ? NULL : number_object(r->taylor.h);
        r->interrupted = 0;
    }
    PyBuffer_Release(&v);
    return answer;
}

/* The event function that is asked for, where the motion was looked at and has so many derivatives. */
static const Event *event_of(RunObject *self, int event, int count)
{
    const Run *r = &self->run;
    if (!run_is_idle(self))
        return NULL;
    if (self->looked && event >= 0 && event < r->mode->event_count && count >= 0 && count < r->taylor.order)
        return &r->mode->events[event];
    PyErr_SetString(PyExc_ValueError, "no such derivatives of what was looked at");
    return NULL;
}

PyObject *Run_derivatives(RunObject *self, PyObject *args)
{
    Series series;
    Real factorial = 1.0;
    const Event *e;
    int event, count, n;
    if (!PyArg_ParseTuple(args, "ii", &event, &count) || (e = event_of(self, event, count)) == NULL)
        return NULL;
    taylor_polynomial(&self->run, e, series);
    for (n = 0; n <= count; n++) {
        factorial = n > 0 ? factorial * n : factorial;
        series[n] = series[n] * factorial;
    }
    return list_of(series, count + 1, 1);
}

PyObject *Run_bounds(RunObject *self, PyObject *args)
{
    Series bounds;
    Real span;
    const Event *e;
    int event, count, exact, summed;
    if (!PyArg_ParseTuple(args, "iippO&", &event, &count, &exact, &summed, number_from, &span) || (e = event_of(self, event, count)) == NULL)
        return NULL;
    if (!taylor_bounds(&self->run, e, count, exact, summed, span, bounds))
        return PyErr_NoMemory();
    return list_of(bounds, count + 1, 1);
}

/* Whether a motion was looked at; else an error is set. */
static int has_looked(RunObject *self)
{
    if (run_is_idle(self) && !self->looked)
        PyErr_SetString(PyExc_ValueError, "nothing was looked at");
    return !PyErr_Occurred();
}

PyObject *Run_forces(RunObject *self, PyObject *none)
{
    const Run *r = &self->run;
    Real X = 0.0, V = 0.0;
    (void)none;
    if (!has_looked(self))
        return NULL;
    if (r->has_base)
        base_motion_at(r, r->mode, r->scratch.t, &X, &V);
    return number_object(forces_of(r, r->mode, &r->scratch, X, V));
}

PyObject *Run_formulas(RunObject *self, PyObject *none)
{
    const Run *r = &self->run;
    const Tape *tape;
    PyObject *list;
    int k;
    (void)none;
    if (!has_looked(self))
        return NULL;
    tape = &r->mode->tape;
    list = PyList_New(tape->output_count);
    for (k = 0; list && k < tape->output_count; k++)
        PyList_SET_ITEM(list, k, number_object(*series_along(r->taylor.tapes.series, tape->outputs[k])));
    return list;
}
