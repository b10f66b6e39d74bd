/* First roots of polynomials for Python: functions of the module, to be tested without a run. */
#include "run_object.h" /* with Python.h, which goes first */

#include "certificate.h"
#include "first_root.h"

PyObject *root_first(PyObject *module, PyObject *args)
{
    Certificate c;
    Py_buffer coefficients;
    double t0, h, end = 0.0;
    int known, keep_margin, outcome;
    Py_ssize_t count;
    (void)module;
    if (!PyArg_ParseTuple(args, "y*iddp", &coefficients, &known, &t0, &h, &keep_margin))
        return NULL;
    count = coefficients.len / (Py_ssize_t)sizeof(double);
    if (count < 1 || count > SERIES || known < 0) {
        PyBuffer_Release(&coefficients);
        return PyErr_Format(PyExc_ValueError, "a polynomial has 1 to %d coefficients", SERIES);
    }
    certificate_open(&c);
    outcome = polynomial_first_root(&c, (const double *)coefficients.buf, (int)count, known, t0, h, keep_margin, 0, &end);
    PyBuffer_Release(&coefficients);
    return Py_BuildValue("idldd", outcome, end, (long)c.uncertified, c.margin, c.margin_time);
}

PyObject *root_safe_step(PyObject *module, PyObject *args)
{
    double value, slope, bound;
    (void)module;
    return PyArg_ParseTuple(args, "ddd", &value, &slope, &bound) ? PyFloat_FromDouble(safe_step(value, slope, bound)) : NULL;
}

PyObject *root_deflated_step(PyObject *module, PyObject *args)
{
    double leading, following, bound;
    int order;
    (void)module;
    if (!PyArg_ParseTuple(args, "iddd", &order, &leading, &following, &bound))
        return NULL;
    if (order < 0 || order + 2 >= (int)(sizeof FACTORIALS / sizeof *FACTORIALS))
        return PyErr_Format(PyExc_ValueError, "no zero of order %d", order);
    return PyFloat_FromDouble(deflated_step(order, leading, following, bound));
}
