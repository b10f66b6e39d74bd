/* First roots of polynomials for Python: functions of the module, see roots_alone.c. */
#ifndef ROOTS_ALONE_H
#define ROOTS_ALONE_H

#include <Python.h>

PyObject *root_first(PyObject *module, PyObject *args);
PyObject *root_safe_step(PyObject *module, PyObject *args);
PyObject *root_deflated_step(PyObject *module, PyObject *args);

#endif
