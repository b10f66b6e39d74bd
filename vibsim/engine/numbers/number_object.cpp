/* Numbers of words as objects of Python, with arithmetic and functions: those that Python decides events with. They compute with the
 * precision that this thread has set last.
 */
#include "run_object.h"
#include "words.h"

typedef struct {
    PyObject_HEAD
    Real value;
} NumberObject;

#ifdef __clang__
#pragma clang diagnostic ignored "-Wmissing-field-initializers" /* what is not named here is 0 */
#endif
static PyTypeObject number_type = {PyVarObject_HEAD_INIT(NULL, 0)};

PyObject *number_object(const Real &x)
{
    NumberObject *self = PyObject_New(NumberObject, &number_type);
    if (self) {
        memset(&self->value, 0, sizeof self->value); /* words that are not in use too */
        self->value = x;
    }
    return (PyObject *)self;
}

/* A number, a float or a whole number as a Real: 1; 0 where it is none of these, -1 where an error is set. */
static int converted(PyObject *object, Real *out)
{
    int beyond;
    long long whole;
    if (Py_TYPE(object) == &number_type) {
        *out = ((NumberObject *)object)->value;
        return 1;
    }
    if (PyFloat_Check(object)) {
        *out = PyFloat_AS_DOUBLE(object);
        return 1;
    }
    if (!PyLong_Check(object))
        return 0;
    whole = PyLong_AsLongLongAndOverflow(object, &beyond);
    if (beyond)
        PyErr_SetString(PyExc_OverflowError, "a whole number beyond 64 bits has to be made a number first");
    if (PyErr_Occurred())
        return -1;
    *out = whole;
    return 1;
}

int number_from(PyObject *object, void *out)
{
    const int answer = converted(object, (Real *)out);
    if (answer == 0)
        PyErr_Format(PyExc_TypeError, "a number of words is needed, got %.80s", Py_TYPE(object)->tp_name);
    return answer == 1;
}

typedef Real (*OfOne)(const Real &);
typedef Real (*OfTwo)(const Real &, const Real &);

/* Two operands, as `converted`. */
static int converted_both(PyObject *a, PyObject *b, Real *x, Real *y)
{
    const int one = converted(a, x);
    return one == 1 ? converted(b, y) : one;
}

static PyObject *of_two(PyObject *a, PyObject *b, OfTwo of)
{
    Real x, y;
    const int answer = converted_both(a, b, &x, &y);
    if (answer == 0)
        Py_RETURN_NOTIMPLEMENTED;
    return answer < 0 ? NULL : number_object(of(x, y));
}

#define OF_TWO(name, value)                                                                    \
    static PyObject *name(PyObject *a, PyObject *b)                                            \
    {                                                                                          \
        return of_two(a, b, [](const Real &x, const Real &y) -> Real { return value; });       \
    }
OF_TWO(sum, x + y)
OF_TWO(difference, x - y)
OF_TWO(product, x * y)
OF_TWO(quotient, x / y)
#undef OF_TWO

/* a**b: of a whole b by products, else of a >= 0. */
static PyObject *power(PyObject *a, PyObject *b, PyObject *modulus)
{
    Real x, total = 1;
    long whole, left;
    if (modulus != Py_None || !PyLong_Check(b) || Py_TYPE(a) != &number_type)
        return modulus == Py_None ? of_two(a, b, real_power) : Py_NewRef(Py_NotImplemented);
    whole = PyLong_AsLong(b);
    if (whole == -1 && PyErr_Occurred())
        return NULL;
    x = ((NumberObject *)a)->value;
    for (left = labs(whole); left > 0; left >>= 1) {
        if (left & 1)
            total = total * x;
        x = x * x;
    }
    return number_object(whole < 0 ? 1 / total : total);
}

static const Real &value_of(PyObject *self) { return ((NumberObject *)self)->value; }
static PyObject *negative(PyObject *self) { return number_object(-value_of(self)); }
static PyObject *size(PyObject *self) { return number_object(fabs(value_of(self))); }
static PyObject *itself(PyObject *self) { return Py_NewRef(self); }
static int is_not_zero(PyObject *self) { return (bool)value_of(self); }
static PyObject *as_float(PyObject *self) { return PyFloat_FromDouble((double)value_of(self)); }

static PyObject *compared(PyObject *a, PyObject *b, int how)
{
    Real x, y;
    bool answer;
    const int known = converted_both(a, b, &x, &y);
    if (known < 0)
        return NULL;
    if (known == 0)
        Py_RETURN_NOTIMPLEMENTED;
    switch (how) {
    case Py_LT: answer = x < y; break;
    case Py_LE: answer = x <= y; break;
    case Py_EQ: answer = x == y; break;
    case Py_NE: answer = x != y; break;
    case Py_GT: answer = x > y; break;
    default: answer = x >= y;
    }
    return PyBool_FromLong(answer);
}

/* As that of a double that is equal to it. */
static Py_hash_t hashed(PyObject *self)
{
    const Real &x = value_of(self);
    PyObject *rounded = PyFloat_FromDouble((double)x);
    Py_hash_t code = rounded ? PyObject_Hash(rounded) : -1;
    Py_XDECREF(rounded);
    if (code != -1 && Real((double)x) != x)
        for (int i = 0; i < WORDS; i++)
            code = (Py_hash_t)((Py_uhash_t)code * 1000003u ^ (Py_uhash_t)x.words()[i]);
    return code == -1 && !PyErr_Occurred() ? -2 : code;
}

static PyObject *shown(PyObject *self)
{
    PyObject *rounded = as_float(self), *text = rounded ? PyUnicode_FromFormat("number(%R)", rounded) : NULL;
    Py_XDECREF(rounded);
    return text;
}

static PyObject *parts(PyObject *self, PyObject *none)
{
    const Real &x = value_of(self);
    PyObject *whole, *signed_whole;
    (void)none;
    if (!isfinite(x)) {
        PyErr_SetString(PyExc_ValueError, "an infinite number, or none, has no parts");
        return NULL;
    }
    if (x.sign == 0)
        return Py_BuildValue("ii", 0, 0);
    whole = PyObject_CallMethod((PyObject *)&PyLong_Type, "from_bytes", "y#s", (const char *)x.words(), (Py_ssize_t)(WORDS * 8), "little");
    signed_whole = whole && x.sign < 0 ? PyNumber_Negative(whole) : Py_XNewRef(whole);
    Py_XDECREF(whole);
    return signed_whole ? Py_BuildValue("Ni", signed_whole, (int)(x.exponent - LIMB_BITS)) : NULL;
}

static PyNumberMethods arithmetic;
static PyMethodDef methods[] = {
    {"parts", parts, METH_NOARGS, "Whole numbers m, e with m 2**e."},
    {NULL, NULL, 0, NULL},
};

int numbers_ready(void)
{
    arithmetic.nb_add = sum;
    arithmetic.nb_subtract = difference;
    arithmetic.nb_multiply = product;
    arithmetic.nb_true_divide = quotient;
    arithmetic.nb_power = power;
    arithmetic.nb_negative = negative;
    arithmetic.nb_positive = itself;
    arithmetic.nb_absolute = size;
    arithmetic.nb_bool = is_not_zero;
    arithmetic.nb_float = as_float;
    number_type.tp_name = "vibsim.engine.Number";
    number_type.tp_doc = "A number of words; `number` makes them.";
    number_type.tp_basicsize = sizeof(NumberObject);
    number_type.tp_flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION;
    number_type.tp_as_number = &arithmetic;
    number_type.tp_richcompare = compared;
    number_type.tp_hash = hashed;
    number_type.tp_repr = shown;
    number_type.tp_methods = methods;
    return PyType_Ready(&number_type);
}

/* Whether numbers of so many bits can be had; an error is set where they cannot. */
int bits_fit(int bits)
{
    if (bits < 1 || bits > MOST_BITS) {
        PyErr_Format(PyExc_ValueError, "these numbers have up to %d bits, got %d", (int)MOST_BITS, bits);
        return 0;
    }
    return 1;
}

static PyObject *precision(PyObject *self, PyObject *args)
{
    int bits;
    (void)self;
    if (!PyArg_ParseTuple(args, "i", &bits) || !bits_fit(bits))
        return NULL;
    set_precision(bits);
    Py_RETURN_NONE;
}

/* The number m 2**e, of a whole number m of no more bits than the words have. */
static PyObject *number(PyObject *self, PyObject *args)
{
    uint64_t w[LIMBS];
    PyObject *whole, *positive, *bytes, *zero, *made = NULL;
    int exponent, negative;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!i", &PyLong_Type, &whole, &exponent) || (zero = PyLong_FromLong(0)) == NULL)
        return NULL;
    negative = PyObject_RichCompareBool(whole, zero, Py_LT);
    positive = PyNumber_Absolute(whole);
    bytes = positive ? PyObject_CallMethod(positive, "to_bytes", "is", (int)(WORDS * 8), "little") : NULL;
    if (bytes) {
        memcpy(w, PyBytes_AS_STRING(bytes), (size_t)WORDS * 8);
        made = number_object(normal(w, WORDS, exponent + (long)LIMB_BITS, negative ? -1 : 1));
    }
    Py_XDECREF(bytes);
    Py_XDECREF(positive);
    Py_DECREF(zero);
    return made;
}

static PyObject *half_turn(PyObject *self, PyObject *none)
{
    (void)self;
    (void)none;
    return number_object(HALF_TURN);
}

/* 0 of what rounding has left below 0. */
static PyObject *root(PyObject *self, PyObject *x)
{
    Real value;
    (void)self;
    if (!number_from(x, &value))
        return NULL;
    return number_object(value > 0 ? sqrt(value) : is_no_number(value) ? value : Real(0));
}

static PyObject *floor_value(PyObject *self, PyObject *x)
{
    Real value;
    (void)self;
    return number_from(x, &value) ? number_object(floor(value)) : NULL;
}

static PyObject *next_after(PyObject *self, PyObject *args)
{
    Real t, towards;
    (void)self;
    return PyArg_ParseTuple(args, "O&O&", number_from, &t, number_from, &towards) ? number_object(nextafter(t, towards)) : NULL;
}

/* Numbers as the bytes that C takes, and back. */
static PyObject *packed(PyObject *self, PyObject *values)
{
    PyObject *list = PySequence_Fast(values, "a sequence of numbers is needed"), *bytes;
    Py_ssize_t count = list ? PySequence_Fast_GET_SIZE(list) : 0, i;
    (void)self;
    bytes = list ? PyBytes_FromStringAndSize(NULL, count * (Py_ssize_t)sizeof(Real)) : NULL;
    for (i = 0; bytes && i < count; i++) {
        Real x;
        if (!number_from(PySequence_Fast_GET_ITEM(list, i), &x)) {
            Py_CLEAR(bytes);
            break;
        }
        memset(x.m, 0, sizeof *x.m * (size_t)(LIMBS - WORDS));
        memcpy(PyBytes_AS_STRING(bytes) + i * (Py_ssize_t)sizeof x, (const void *)&x, sizeof x);
    }
    Py_XDECREF(list);
    return bytes;
}

static PyObject *unpacked(PyObject *self, PyObject *args)
{
    Py_buffer v;
    PyObject *list = NULL;
    (void)self;
    if (!PyArg_ParseTuple(args, "y*", &v))
        return NULL;
    if (v.len % (Py_ssize_t)sizeof(Real))
        PyErr_SetString(PyExc_ValueError, "no numbers of words");
    else
        list = list_of((const Real *)v.buf, (int)(v.len / (Py_ssize_t)sizeof(Real)), 1);
    PyBuffer_Release(&v);
    return list;
}

static PyObject *texts(PyObject *self, PyObject *args)
{
    Py_buffer v;
    int digits, width;
    PyObject *made = NULL;
    (void)self;
    if (!PyArg_ParseTuple(args, "y*ii", &v, &digits, &width))
        return NULL;
    if (digits < 2 || digits > MOST_DECIMALS || width < digits + 8 || width > 2 * MOST_DECIMALS || v.len % (Py_ssize_t)sizeof(Real) != 0) {
        PyErr_SetString(PyExc_ValueError, "no numbers of words, or more digits than they have");
    } else {
        const long count = (long)(v.len / (Py_ssize_t)sizeof(Real));
        made = PyBytes_FromStringAndSize(NULL, (Py_ssize_t)count * width);
        if (made && !decimal_texts((const Real *)v.buf, count, digits, width, PyBytes_AS_STRING(made))) {
            Py_DECREF(made);
            made = Py_NewRef(Py_None);
        }
    }
    PyBuffer_Release(&v);
    return made;
}

PyMethodDef number_functions[] = {
    {"precision", precision, METH_VARARGS, "precision(bits): of what this thread computes from now on"},
    {"number", number, METH_VARARGS, "number(m, e) -> m 2**e; m of no more bits than the words have"},
    {"pi", half_turn, METH_NOARGS, "pi() -> half a turn [rad]"},
    {"sqrt", root, METH_O, "Square root; 0 of what rounding has left below 0."},
    {"floor", floor_value, METH_O, "The largest whole number not above x."},
    {"next_after", next_after, METH_VARARGS, "next_after(t, towards): the next larger time, a unit round-off on."},
    {"packed", packed, METH_O, "packed(numbers) -> the bytes that C takes"},
    {"unpacked", unpacked, METH_VARARGS, "unpacked(bytes) -> list of numbers"},
    {"texts", texts, METH_VARARGS, "texts(bytes, digits, width) -> decimal texts of so many characters; None where a number is beyond them"},
    {NULL, NULL, 0, NULL},
};
