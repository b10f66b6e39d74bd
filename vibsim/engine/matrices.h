/* Matrices of doubles for Python: functions of the module, see matrices.c. */
#ifndef MATRICES_H
#define MATRICES_H

#include <Python.h>

PyObject *matrix_product(PyObject *module, PyObject *args);
PyObject *matrix_dot(PyObject *module, PyObject *args);
PyObject *matrix_solved(PyObject *module, PyObject *args);
PyObject *matrix_determinant(PyObject *module, PyObject *args);
PyObject *matrix_singular(PyObject *module, PyObject *args);
PyObject *matrix_eigenvalues(PyObject *module, PyObject *args);

#endif
