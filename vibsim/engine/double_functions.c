/* The table of the functions of the module of doubles alone, and sines of arrays. */
#include "run_object.h" /* with Python.h, which goes first */

PyObject *sines_cosines(PyObject *self, PyObject *args)
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

#define ENTRY(name, function, text) {#name, function, METH_VARARGS, text},
PyMethodDef double_functions[] = {DOUBLE_FUNCTIONS(ENTRY){NULL, NULL, 0, NULL}};
