/* Elementary functions as functions of the module, on its numbers. */
#include "run_object.h" /* with Python.h, which goes first */

#define FUNCTION(CODE, name, of, sign, text)                                           \
    static PyObject *name##_value(PyObject *self, PyObject *x)                         \
    {                                                                                  \
        Real value;                                                                    \
        (void)self;                                                                    \
        return number_from(x, &value) ? number_object(of(value)) : NULL;               \
    }
ELEMENTARY_FUNCTIONS(FUNCTION)
FUNCTION(EXPM1, expm1, exponential_less_1, 0, )

static PyObject *sine_cosine_value(PyObject *self, PyObject *x)
{
    Real angle, sine, cosine;
    (void)self;
    if (!number_from(x, &angle))
        return NULL;
    sine_cosine(angle, &sine, &cosine);
    return Py_BuildValue("NN", number_object(sine), number_object(cosine));
}

static PyObject *power_value(PyObject *self, PyObject *args)
{
    Real a, p;
    (void)self;
    return PyArg_ParseTuple(args, "O&O&", number_from, &a, number_from, &p) ? number_object(real_power(a, p)) : NULL;
}

#define ENTRY(CODE, name, of, sign, text) {#name, name##_value, METH_O, text},

PyMethodDef elementary_functions[] = {
    ELEMENTARY_FUNCTIONS(ENTRY)
    {"expm1", expm1_value, METH_O, "exp(x) - 1."},
    {"sine_cosine", sine_cosine_value, METH_O, "Sine and cosine of an angle [rad]; of a double beyond a million radians with the error that n eps in it makes."},
    {"power", power_value, METH_VARARGS, "power(a, p): a**p for a >= 0, nan of a below 0; 1 for p = 0."},
    {NULL, NULL, 0, NULL},
};
