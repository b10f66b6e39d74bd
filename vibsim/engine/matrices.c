/* Matrices of doubles in one order of operations: what follows from them has the same bits on every machine.
 *
 * A LAPACK or BLAS shares sums out by the vector units and threads of a machine, and fuses products where it can. Here sums go by
 * ascending index, and each operation is rounded by itself. Linear equations by Gaussian elimination with partial pivoting; singular
 * values by one-sided Jacobi rotations (Hestenes 1958; Golub and Van Loan, section 8.6.3); eigenvalues by balancing, Hessenberg form
 * and the QR method with double shifts (Martin, Peters and Wilkinson 1970; `hqr` of EISPACK). Matrices come and go as buffers of
 * doubles in rows, of one or two dimensions.
 */
#include "run_object.h" /* with Python.h, which goes first */

#include <float.h>

/* SWEEPS: of rotations, and of balancing: both converge within ten. STEPS: of the QR method to one eigenvalue; more than 30 have
 * not been seen.
 */
enum { SWEEPS = 60, STEPS = 60 };
#define WORTH 0.95 /* of the size of a row and its column: what balancing must gain */

typedef struct {
    Py_buffer view;
    Py_ssize_t rows, columns;
} Table;

static double *row_of(double *values, int columns, int row)
{
    return values + (size_t)columns * (size_t)row;
}

/* A table from an object: 0, or -1 with an exception. A vector is a row, or with `upright` a column. */
static int table_of(PyObject *object, int flags, int upright, Table *t)
{
    if (PyObject_GetBuffer(object, &t->view, PyBUF_C_CONTIGUOUS | PyBUF_FORMAT | flags) != 0)
        return -1;
    if (strcmp(t->view.format, "d") != 0 || t->view.ndim < 1 || t->view.ndim > 2) {
        PyErr_SetString(PyExc_ValueError, "not a vector or matrix of doubles");
        PyBuffer_Release(&t->view);
        return -1;
    }
    t->rows = t->view.shape[0];
    t->columns = t->view.ndim == 2 ? t->view.shape[1] : 1;
    if (t->view.ndim == 1 && !upright) {
        t->columns = t->rows;
        t->rows = 1;
    }
    if (t->rows > 30000 || t->columns > 30000) {
        PyErr_SetString(PyExc_ValueError, "the matrix is too large");
        PyBuffer_Release(&t->view);
        return -1;
    }
    return 0;
}

/* Tables from some arguments: 0, or -1 with an exception and none of them held. */
static int tables_of(PyObject *args, const char *format, Table *t, int count, const int *flags, const int *upright)
{
    PyObject *objects[3] = {NULL, NULL, NULL};
    int k;
    if (!PyArg_ParseTuple(args, format, &objects[0], &objects[1], &objects[2]))
        return -1;
    for (k = 0; k < count; k++)
        if (table_of(objects[k], flags[k], upright[k], &t[k]) != 0) {
            while (k-- > 0)
                PyBuffer_Release(&t[k].view);
            return -1;
        }
    return 0;
}

static PyObject *released(Table *t, int count, PyObject *answer)
{
    while (count-- > 0)
        PyBuffer_Release(&t[count].view);
    return answer;
}

static PyObject *misfit(Table *t, int count)
{
    PyErr_SetString(PyExc_ValueError, "matrices do not fit together");
    return released(t, count, NULL);
}

/* Matrix product (m, n) of A (m, k) and B (k, n), k > 0, into a buffer. */
PyObject *matrix_product(PyObject *module, PyObject *args)
{
    static const int flags[] = {0, 0, PyBUF_WRITABLE}, upright[] = {0, 1, 0};
    Table t[3];
    const double *a, *b;
    double *out;
    Py_ssize_t i, j, k, m, n, inner;
    (void)module;
    if (tables_of(args, "OOO", t, 3, flags, upright) != 0)
        return NULL;
    m = t[0].rows, inner = t[0].columns, n = t[1].columns;
    if (inner != t[1].rows || inner < 1 || t[2].view.len != m * n * (Py_ssize_t)sizeof(double))
        return misfit(t, 3);
    a = t[0].view.buf, b = t[1].view.buf, out = t[2].view.buf;
    for (i = 0; i < m; i++) {
        for (j = 0; j < n; j++)
            out[i * n + j] = a[i * inner] * b[j];
        for (k = 1; k < inner; k++)
            for (j = 0; j < n; j++)
                out[i * n + j] = out[i * n + j] + a[i * inner + k] * b[k * n + j];
    }
    Py_INCREF(Py_None);
    return released(t, 3, Py_None);
}

static double dot(const double *a, const double *b, int n)
{
    double total = 0.0;
    int i;
    for (i = 0; i < n; i++)
        total = total + a[i] * b[i];
    return total;
}

PyObject *matrix_dot(PyObject *module, PyObject *args)
{
    static const int flags[] = {0, 0}, upright[] = {0, 0};
    Table t[2];
    Py_ssize_t count;
    (void)module;
    if (tables_of(args, "OO", t, 2, flags, upright) != 0)
        return NULL;
    count = t[0].view.len / (Py_ssize_t)sizeof(double);
    if (t[0].view.len != t[1].view.len)
        return misfit(t, 2);
    return released(t, 2, PyFloat_FromDouble(dot(t[0].view.buf, t[1].view.buf, (int)count)));
}

static void exchange(double *one, double *other, int n)
{
    int i;
    for (i = 0; i < n; i++) {
        double kept = one[i];
        one[i] = other[i];
        other[i] = kept;
    }
}

/* Gaussian elimination in place of n rows of some width, the largest pivot of each column first: the sign of exchanges of rows, 0
 * where a pivot is 0.
 */
static double eliminate(double *rows, int n, int width)
{
    double sign = 1.0;
    int i, j, k;
    for (k = 0; k < n; k++) {
        double *pivot = row_of(rows, width, k), largest = fabs(pivot[k]);
        int place = k;
        for (i = k + 1; i < n; i++)
            if (fabs(row_of(rows, width, i)[k]) > largest) {
                place = i;
                largest = fabs(row_of(rows, width, i)[k]);
            }
        if (largest == 0.0)
            return 0.0;
        if (place != k) {
            exchange(pivot, row_of(rows, width, place), width);
            sign = -sign;
        }
        for (i = k + 1; i < n; i++) {
            double *row = row_of(rows, width, i), share = row[k] / pivot[k];
            for (j = k + 1; j < width; j++)
                row[j] = row[j] - share * pivot[j];
        }
    }
    return sign;
}

static double *room_for(size_t count)
{
    double *room = PyMem_Malloc((count ? count : 1) * sizeof(double));
    if (room == NULL)
        PyErr_NoMemory();
    return room;
}

/* x of A x = b, A (n, n), into a buffer; returns the smallest pivot, 0 where A is singular to the bit: x is 0 then. */
PyObject *matrix_solved(PyObject *module, PyObject *args)
{
    static const int flags[] = {0, 0, PyBUF_WRITABLE}, upright[] = {0, 1, 1};
    Table t[3];
    const double *a, *b;
    double *x, *rows, smallest = INFINITY;
    int i, k, n;
    (void)module;
    if (tables_of(args, "OOO", t, 3, flags, upright) != 0)
        return NULL;
    n = (int)t[0].rows;
    if (t[0].columns != n || t[1].rows != n || t[1].columns != 1 || t[2].view.len != t[1].view.len)
        return misfit(t, 3);
    a = t[0].view.buf, b = t[1].view.buf, x = t[2].view.buf;
    if ((rows = room_for((size_t)n * ((size_t)n + 1))) == NULL)
        return released(t, 3, NULL);
    for (i = 0; i < n; i++) {
        memcpy(row_of(rows, n + 1, i), a + (size_t)n * (size_t)i, (size_t)n * sizeof(double));
        row_of(rows, n + 1, i)[n] = b[i];
    }
    if (eliminate(rows, n, n + 1) == 0.0) {
        smallest = 0.0;
        for (k = 0; k < n; k++)
            x[k] = 0.0;
    } else {
        for (k = n - 1; k >= 0; k--) {
            const double *row = row_of(rows, n + 1, k);
            double rest = row[n];
            for (i = k + 1; i < n; i++)
                rest = rest - row[i] * x[i];
            x[k] = rest / row[k];
        }
        for (k = 0; k < n; k++) {
            double pivot = fabs(row_of(rows, n + 1, k)[k]);
            if (k == 0 || pivot < smallest)
                smallest = pivot;
        }
    }
    PyMem_Free(rows);
    return released(t, 3, PyFloat_FromDouble(smallest));
}

/* Determinant of A (n, n), the product of the pivots. */
PyObject *matrix_determinant(PyObject *module, PyObject *args)
{
    static const int flags[] = {0}, upright[] = {0};
    Table t[1];
    double *rows, value;
    int k, n;
    (void)module;
    if (tables_of(args, "O", t, 1, flags, upright) != 0)
        return NULL;
    n = (int)t[0].rows;
    if (t[0].columns != n)
        return misfit(t, 1);
    if ((rows = room_for((size_t)n * (size_t)n)) == NULL)
        return released(t, 1, NULL);
    memcpy(rows, t[0].view.buf, (size_t)t[0].view.len);
    value = eliminate(rows, n, n);
    for (k = 0; k < n; k++)
        value = value * row_of(rows, n, k)[k];
    PyMem_Free(rows);
    return released(t, 1, PyFloat_FromDouble(value));
}

/* Binary exponent of the largest of some numbers; 0 returned where one is not finite. */
static int exponent_of(const double *values, Py_ssize_t count, int *exponent)
{
    double largest = 0.0;
    Py_ssize_t i;
    for (i = 0; i < count; i++) {
        if (!isfinite(values[i]))
            return 0;
        if (fabs(values[i]) > largest)
            largest = fabs(values[i]);
    }
    frexp(largest, exponent);
    return 1;
}

/* Turn two rows into each other by an angle of cosine c and sine s. */
static void rotate(double *one, double *other, int n, double c, double s)
{
    int i;
    for (i = 0; i < n; i++) {
        double x = one[i], y = other[i];
        one[i] = c * x - s * y;
        other[i] = s * x + c * y;
    }
}

/* Turn rows p and q of W (n, m) and V (n, n) until those of W are orthogonal; whether they were not. */
static int turned(double *W, double *V, int n, int m, int p, int q, double least)
{
    double *one = row_of(W, m, p), *other = row_of(W, m, q);
    double a = dot(one, one, m), b = dot(other, other, m), across = dot(one, other, m), slope, t, c, s;
    if (a <= least || b <= least || fabs(across) <= DBL_EPSILON * sqrt(a * b))
        return 0;
    slope = (b - a) / (2.0 * across);
    t = copysign(1.0, slope) / (fabs(slope) + sqrt(1.0 + slope * slope));
    c = 1.0 / sqrt(1.0 + t * t);
    s = c * t;
    rotate(one, other, m, c, s);
    rotate(row_of(V, n, p), row_of(V, n, q), n, c, s);
    return 1;
}

/* Singular values squared of n rows of W (m each), the largest first, which turns W and V; both sorted alike. Rows are turned in
 * pairs until all are orthogonal but for rounding of the largest. A row of the size of that rounding belongs to the kernel, and is
 * left.
 */
static void singular_rows(double *W, double *V, double *values, int n, int m)
{
    double least = 0.0;
    int sweep, p, q, again = 1;
    memset(V, 0, (size_t)n * (size_t)n * sizeof(double));
    for (p = 0; p < n; p++) {
        row_of(V, n, p)[p] = 1.0;
        least = least + dot(row_of(W, m, p), row_of(W, m, p), m);
    }
    least = (n * DBL_EPSILON) * (n * DBL_EPSILON) * least;
    for (sweep = 0; sweep < SWEEPS && again; sweep++)
        for (p = again = 0; p < n - 1; p++)
            for (q = p + 1; q < n; q++)
                again |= turned(W, V, n, m, p, q, least);
    for (p = 0; p < n; p++)
        values[p] = dot(row_of(W, m, p), row_of(W, m, p), m);
    for (p = 1; p < n; p++) /* by insertion, which leaves equal ones in their order */
        for (q = p; q > 0 && values[q] > values[q - 1]; q--) {
            exchange(&values[q], &values[q - 1], 1);
            exchange(row_of(W, m, q), row_of(W, m, q - 1), m);
            exchange(row_of(V, n, q), row_of(V, n, q - 1), n);
        }
}

/* Singular values (n, ), the largest first (those beyond m are rounding), right singular vectors as the rows of V (n, n), and A
 * times each as the rows of W (n, m), of A (m, n): in one buffer of n (1 + n + m) doubles. False where A is not finite.
 */
PyObject *matrix_singular(PyObject *module, PyObject *args)
{
    static const int flags[] = {0, PyBUF_WRITABLE}, upright[] = {0, 0};
    Table t[2];
    const double *a;
    double *values, *V, *W;
    int i, j, m, n, exponent = 0;
    (void)module;
    if (tables_of(args, "OO", t, 2, flags, upright) != 0)
        return NULL;
    m = (int)t[0].rows, n = (int)t[0].columns;
    if (t[1].view.len != (Py_ssize_t)sizeof(double) * n * (1 + n + (Py_ssize_t)m))
        return misfit(t, 2);
    a = t[0].view.buf, values = t[1].view.buf, V = values + n, W = V + (size_t)n * (size_t)n;
    if (!exponent_of(a, (Py_ssize_t)m * n, &exponent))
        return released(t, 2, PyBool_FromLong(0));
    for (j = 0; j < n; j++)
        for (i = 0; i < m; i++)
            row_of(W, m, j)[i] = ldexp(a[(size_t)i * (size_t)n + (size_t)j], -exponent);
    singular_rows(W, V, values, n, m);
    for (j = 0; j < n; j++) {
        values[j] = ldexp(sqrt(values[j]), exponent);
        for (i = 0; i < m; i++)
            row_of(W, m, j)[i] = ldexp(row_of(W, m, j)[i], exponent);
    }
    return released(t, 2, PyBool_FromLong(1));
}

/* The first of `count` rows and columns of A of which one has nothing but its diagonal entry among them; -1. */
static int isolated(const double *a, int n, const int *places, int count)
{
    int i, j;
    for (i = 0; i < count; i++) {
        int row = 0, column = 0;
        for (j = 0; j < count; j++)
            if (j != i) {
                row |= a[(size_t)n * (size_t)places[i] + (size_t)places[j]] != 0.0;
                column |= a[(size_t)n * (size_t)places[j] + (size_t)places[i]] != 0.0;
            }
        if (!row || !column)
            return i;
    }
    return -1;
}

#define H(i, j) h[(size_t)(i) * (size_t)n + (size_t)(j)]

/* Scale rows and columns by powers of two until each row is about as large as its column. */
static void balance(double *h, int n)
{
    int sweep, i, j, settled = 0;
    for (sweep = 0; sweep < SWEEPS && !settled; sweep++)
        for (i = 0, settled = 1; i < n; i++) {
            double column = 0.0, row = 0.0, factor = 1.0, both;
            for (j = 0; j < n; j++)
                if (j != i) {
                    column = column + fabs(H(j, i));
                    row = row + fabs(H(i, j));
                }
            if (column == 0.0 || row == 0.0)
                continue;
            both = column + row;
            while (column < row / 2.0 && factor < ldexp(1.0, 200)) {
                factor = factor * 2.0;
                column = column * 2.0;
                row = row / 2.0;
            }
            while (column > row * 2.0 && factor > ldexp(1.0, -200)) {
                factor = factor / 2.0;
                column = column / 2.0;
                row = row * 2.0;
            }
            if (column + row < WORTH * both) {
                settled = 0;
                for (j = 0; j < n; j++)
                    H(i, j) = H(i, j) / factor;
                for (j = 0; j < n; j++)
                    H(j, i) = H(j, i) * factor;
            }
        }
}

/* Elimination with pivots to zeros below the first subdiagonal. */
static void to_hessenberg(double *h, int n)
{
    int m, i, j;
    for (m = 1; m < n - 1; m++) {
        int place = m;
        double largest = fabs(H(m, m - 1));
        for (i = m + 1; i < n; i++)
            if (fabs(H(i, m - 1)) > largest) {
                place = i;
                largest = fabs(H(i, m - 1));
            }
        if (largest == 0.0)
            continue;
        if (place != m) {
            exchange(row_of(h, n, m), row_of(h, n, place), n);
            for (j = 0; j < n; j++)
                exchange(&H(j, m), &H(j, place), 1);
        }
        for (i = m + 1; i < n; i++) {
            double share = H(i, m - 1) / H(m, m - 1);
            H(i, m - 1) = 0.0;
            for (j = m; j < n; j++)
                H(i, j) = H(i, j) - share * H(m, j);
            for (j = 0; j < n; j++)
                H(j, m) = H(j, m) + share * H(j, i);
        }
    }
}

/* The first row of the block that ends at row `last`, whose subdiagonal entries are more than rounding. */
static int start_of_block(double *h, int n, int last, double size)
{
    int i;
    for (i = last; i > 0; i--) {
        double near = fabs(H(i - 1, i - 1)) + fabs(H(i, i));
        if (near == 0.0)
            near = size;
        if (fabs(H(i, i - 1)) + near == near) {
            H(i, i - 1) = 0.0;
            return i;
        }
    }
    return 0;
}

/* Both eigenvalues (re, im) of the block of two rows that ends at row `last`. */
static void of_pair(const double *h, int n, int last, double shifted, double *out)
{
    double x = H(last, last), y = H(last - 1, last - 1), w = H(last, last - 1) * H(last - 1, last);
    double p = 0.5 * (y - x), q = p * p + w, z = sqrt(fabs(q));
    x = x + shifted;
    if (q < 0.0) {
        out[0] = out[2] = x + p;
        out[1] = z;
        out[3] = -z;
        return;
    }
    z = p + copysign(z, p);
    out[0] = x + z;
    out[2] = z != 0.0 ? x - w / z : x + z;
    out[1] = out[3] = 0.0;
}

/* Reflections of three rows and columns each, down the block: the double step of Francis. */
static void chase(double *h, int n, int first, int m, int last, double p, double q, double r)
{
    double x = 0.0, y, z, s;
    int i, j, k;
    for (k = m; k < last; k++) {
        int three = k + 1 != last, end = last < k + 3 ? last : k + 3;
        if (k != m) {
            p = H(k, k - 1);
            q = H(k + 1, k - 1);
            r = three ? H(k + 2, k - 1) : 0.0;
            x = fabs(p) + fabs(q) + fabs(r);
            if (x == 0.0)
                continue;
            p = p / x;
            q = q / x;
            r = r / x;
        }
        s = copysign(sqrt(p * p + q * q + r * r), p);
        if (k != m)
            H(k, k - 1) = -s * x;
        else if (first != m)
            H(k, k - 1) = -H(k, k - 1);
        p = p + s;
        x = p / s;
        y = q / s;
        z = r / s;
        q = q / p;
        r = r / p;
        for (j = k; j <= last; j++) {
            p = H(k, j) + q * H(k + 1, j);
            if (three) {
                p = p + r * H(k + 2, j);
                H(k + 2, j) = H(k + 2, j) - p * z;
            }
            H(k + 1, j) = H(k + 1, j) - p * y;
            H(k, j) = H(k, j) - p * x;
        }
        for (i = first; i <= end; i++) {
            p = x * H(i, k) + y * H(i, k + 1);
            if (three) {
                p = p + z * H(i, k + 2);
                H(i, k + 2) = H(i, k + 2) - p * r;
            }
            H(i, k + 1) = H(i, k + 1) - p * q;
            H(i, k) = H(i, k) - p;
        }
    }
}

/* One step of the QR method with two shifts on a block, from where two subdiagonal entries in a row are small; returns what is
 * taken off the diagonal so far. Steps 10, 20 and 40 take other shifts, where the usual ones go round in circles.
 */
static double qr_step(double *h, int n, int first, int last, int step, double shifted)
{
    double x = H(last, last), y = H(last - 1, last - 1), w = H(last, last - 1) * H(last - 1, last);
    double p, q, r, s, z, u, v;
    int i, m;
    if (step == 10 || step == 20 || step == 40) {
        shifted = shifted + x;
        for (i = 0; i <= last; i++)
            H(i, i) = H(i, i) - x;
        s = fabs(H(last, last - 1)) + fabs(H(last - 1, last - 2));
        x = y = 0.75 * s;
        w = -0.4375 * s * s;
    }
    for (m = last - 2;; m--) {
        z = H(m, m);
        r = x - z;
        s = y - z;
        p = (r * s - w) / H(m + 1, m) + H(m, m + 1);
        q = H(m + 1, m + 1) - z - r - s;
        r = H(m + 2, m + 1);
        s = fabs(p) + fabs(q) + fabs(r);
        p = p / s;
        q = q / s;
        r = r / s;
        if (m == first)
            break;
        u = fabs(H(m, m - 1)) * (fabs(q) + fabs(r));
        v = fabs(p) * (fabs(H(m - 1, m - 1)) + fabs(z) + fabs(H(m + 1, m + 1)));
        if (u + v == v)
            break;
    }
    for (i = m; i < last - 1; i++) {
        H(i + 2, i) = 0.0;
        if (i != m)
            H(i + 2, i - 1) = 0.0;
    }
    chase(h, n, first, m, last, p, q, r);
    return shifted;
}

/* (re, im) of the eigenvalues of a Hessenberg matrix, which is used up; whether the QR method converged. */
static int of_hessenberg(double *h, int n, double *out)
{
    double size = 0.0, shifted = 0.0;
    int i, j, last = n - 1, step = 0;
    for (i = 0; i < n; i++)
        for (j = i > 0 ? i - 1 : 0; j < n; j++)
            size = size + fabs(H(i, j));
    while (last >= 0) {
        int first = start_of_block(h, n, last, size);
        if (first == last) {
            *out++ = H(last, last) + shifted;
            *out++ = 0.0;
            last -= 1, step = 0;
        } else if (first == last - 1) {
            of_pair(h, n, last, shifted, out);
            out += 4;
            last -= 2, step = 0;
        } else if (step == STEPS)
            return 0;
        else {
            step += 1;
            shifted = qr_step(h, n, first, last, step, shifted);
        }
    }
    return 1;
}

/* Eigenvalues (re, im) of A (n, n) into a buffer, with exact conjugates; those that zeros of a row or column isolate are exact.
 * False where A is not finite, or the QR method does not converge.
 */
PyObject *matrix_eigenvalues(PyObject *module, PyObject *args)
{
    static const int flags[] = {0, PyBUF_WRITABLE}, upright[] = {0, 0};
    Table t[2];
    const double *a;
    double *out, *h;
    int i, j, n, whole, count, found, exponent = 0, *places;
    (void)module;
    if (tables_of(args, "OO", t, 2, flags, upright) != 0)
        return NULL;
    whole = n = (int)t[0].rows;
    if (t[0].columns != n || t[1].view.len != (Py_ssize_t)sizeof(double) * 2 * n)
        return misfit(t, 2);
    a = t[0].view.buf, out = t[1].view.buf;
    if (!exponent_of(a, (Py_ssize_t)n * n, &exponent))
        return released(t, 2, PyBool_FromLong(0));
    if ((h = room_for((size_t)n * ((size_t)n + 1))) == NULL)
        return released(t, 2, NULL);
    places = (int *)(h + (size_t)n * (size_t)n);
    for (i = 0; i < n; i++)
        places[i] = i;
    for (count = n; (i = isolated(a, n, places, count)) >= 0; count--) {
        *out++ = a[(size_t)(n + 1) * (size_t)places[i]];
        *out++ = 0.0;
        memmove(places + i, places + i + 1, (size_t)(count - 1 - i) * sizeof *places);
    }
    n = count;
    for (i = 0; i < n; i++)
        for (j = 0; j < n; j++)
            H(i, j) = ldexp(a[(size_t)whole * (size_t)places[i] + (size_t)places[j]], -exponent);
    balance(h, n);
    to_hessenberg(h, n);
    found = of_hessenberg(h, n, out);
    for (i = 0; found && i < 2 * n; i++)
        out[i] = ldexp(out[i], exponent);
    PyMem_Free(h);
    return released(t, 2, PyBool_FromLong(found));
}
