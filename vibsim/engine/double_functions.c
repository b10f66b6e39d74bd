/* The functions of the module of doubles alone: of arrays, matrices, roots, runs side by side. */
#include "run_object.h" /* with Python.h, which goes first */

static PyObject *sines_cosines(PyObject *self, PyObject *args)
{
    Py_buffer v[3];
    Py_ssize_t i, count;
    (void)self;
    if (!PyArg_ParseTuple(args, "y*w*w*", &v[0], &v[1], &v[2]))
        return NULL;
    count = v[0].len / (Py_ssize_t)sizeof(double);
    for (i = 0; v[1].len == v[0].len && v[2].len == v[0].len && i < count; i++)
        sine_cosine(((const double *)v[0].buf)[i], (double *)v[1].buf + i, (double *)v[2].buf + i);
    for (i = 0; i < 3; i++)
        PyBuffer_Release(&v[i]);
    if (v[1].len == v[0].len && v[2].len == v[0].len)
        Py_RETURN_NONE;
    PyErr_SetString(PyExc_ValueError, "three arrays of one size are needed");
    return NULL;
}

PyMethodDef double_functions[] = {
    {"advance_together", advance_together, METH_VARARGS,
     "advance_together(runs, widest) -> list of what `advance()` gives of each of up to 64 runs in a tuple, computed side by side;\n"
     "None of a run that waits for the next call, because another one has stopped.\n"
     "widest: lanes in a vector at most, where fewer than the processor has are wanted; 0: none."},
    {"sines_cosines", sines_cosines, METH_VARARGS, "sines_cosines(angles, sines, cosines): of arrays of doubles, the last two to be filled."},
    {"product", matrix_product, METH_VARARGS, "product(a, b, out): matrix product; vectors are a row a, a column b"},
    {"dot", matrix_dot, METH_VARARGS, "dot(a, b) -> sum of the products of two vectors"},
    {"solved", matrix_solved, METH_VARARGS, "solved(a, b, x) -> smallest pivot, 0 where a is singular: x with a x = b"},
    {"determinant", matrix_determinant, METH_VARARGS, "determinant(a)"},
    {"singular", matrix_singular, METH_VARARGS, "singular(a, out) -> whether a is finite; out: values, V and W of a (m, n), n (1 + n + m) doubles"},
    {"first_root", root_first, METH_VARARGS,
     "first_root(coefficients, known, t0, h, keep_margin) -> (0: positive on the whole step, 1: a zero, 2: unproved behind it; "
     "time, doubts, margin and when), see events/roots/polynomial_root.c"},
    {"safe_step", root_safe_step, METH_VARARGS, "safe_step(value, slope, bound of the curvature): a step that passes no zero"},
    {"deflated_step", root_deflated_step, METH_VARARGS, "deflated_step(order, leading, following, bound): one behind a zero"},
    {"eigenvalues", matrix_eigenvalues, METH_VARARGS, "eigenvalues(a, out) -> whether they were found; out (n, 2)"},
    {NULL, NULL, 0, NULL},
};
