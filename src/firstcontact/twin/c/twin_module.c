/* Python functions of the twin's kernels. They check sizes and kinds of all arguments. */
#include <string.h>

#include "arrays.h"
#include "twin.h"

/* Argument of a call: a number, an array, or a tuple. */
typedef struct {
    Py_buffer view; /* view.obj is NULL unless this is an array */
    Py_ssize_t count; /* number of elements */
    void *data;
    double number;
    int64_t whole;
    PyObject *object;
} argument;

static void release(argument *a, Py_ssize_t n)
{
    for (Py_ssize_t i = 0; i < n; i++)
        if (a[i].view.obj != NULL)
            PyBuffer_Release(&a[i].view);
}

/* Get an array. A letter names its kind: d double, z complex, l int64, s int16, u uint16; in upper
   case if the array is written to. */
static bool get_array(PyObject *object, char letter, argument *a)
{
    static const char LETTERS[] = "dzlsu", WRITTEN[] = "DZLSU";
    static const enum kind KINDS[] = {F64, PAIR, I64, I16, U16};
    const char *const read = strchr(LETTERS, letter);
    const enum kind kind = KINDS[read ? read - LETTERS : strchr(WRITTEN, letter) - WRITTEN];
    if (!array_get(object, &a->view, kind, read == NULL))
        return false;
    a->data = a->view.buf;
    a->count = a->view.len / a->view.itemsize;
    return true;
}

/* Get all arguments. A letter of `kinds` stands for each: '.' for a float, '#' for an integer, 't'
   for a tuple, and the letters of get_array for arrays. */
static bool gather(PyObject *const *args, Py_ssize_t n, const char *kinds, argument *a)
{
    const Py_ssize_t wanted = (Py_ssize_t)strlen(kinds);
    if (n != wanted) {
        PyErr_Format(PyExc_TypeError, "%zd arguments are needed, not %zd", wanted, n);
        return false;
    }
    memset(a, 0, sizeof *a * (size_t)n);
    for (Py_ssize_t i = 0; i < n; i++) {
        bool ok = true;
        a[i].object = args[i];
        if (kinds[i] == '.')
            a[i].number = PyFloat_AsDouble(args[i]);
        else if (kinds[i] == '#')
            a[i].whole = PyLong_AsLongLong(args[i]);
        else if (kinds[i] != 't')
            ok = get_array(args[i], kinds[i], a + i);
        if (!ok || PyErr_Occurred()) {
            release(a, n);
            return false;
        }
    }
    return true;
}

/* Copy a named tuple to the struct of its fields, which are doubles. */
static bool fields(const argument *a, void *out, size_t bytes)
{
    const Py_ssize_t n = (Py_ssize_t)(bytes / sizeof(double));
    if (!PyTuple_Check(a->object) || PyTuple_Size(a->object) != n) {
        PyErr_Format(PyExc_ValueError, "a tuple of %zd parameters is needed", n);
        return false;
    }
    for (Py_ssize_t i = 0; i < n; i++)
        ((double *)out)[i] = PyFloat_AsDouble(PyTuple_GetItem(a->object, i));
    return !PyErr_Occurred();
}

static PyObject *misfit(void)
{
    if (!PyErr_Occurred())
        PyErr_SetString(PyExc_ValueError, "the sizes of the arrays do not fit");
    return NULL;
}

/* Release the arguments. Return None, or NULL after an error. */
static PyObject *finish(argument *a, Py_ssize_t n, bool ok)
{
    release(a, n);
    if (!ok)
        return misfit();
    Py_RETURN_NONE;
}

/* Call a kernel without the interpreter's lock if the arguments fit. Release them and return. */
#define RETURN_CALL(a, ok, ...) \
    do { \
        if (ok) { \
            Py_BEGIN_ALLOW_THREADS \
            __VA_ARGS__; \
            Py_END_ALLOW_THREADS \
        } \
        return finish(a, (Py_ssize_t)(sizeof(a) / sizeof *(a)), ok); \
    } while (0)

/* Fields of firstcontact.twin.mechanics.Piece, and their kinds. */
enum {
    INDEX_FINGER, THUMB, TARGET, STIFFNESS, TOUCH, TIMES, NOISE, NOISE_DT, SUBSTEPS, SPEEDS,
    MOTOR_FORCE, BACK_DAMPING, FULL_SPEED, LIMIT, CALM, CALM_STEPS, X, GAP, TOUCHED, OUT,
    PIECE_ARGUMENTS
};
static const char PIECE[PIECE_ARGUMENTS + 1] = "tttdddd.#d.....#DDDD";

static bool get_piece(PyObject *const *args, Py_ssize_t n, argument *a, fc_pinch *q)
{
    if (!gather(args, n, PIECE, a))
        return false;
    q->stiffness = a[STIFFNESS].data;
    q->touch = a[TOUCH].data;
    q->times = a[TIMES].data;
    q->noise = a[NOISE].data;
    q->noise_dt = a[NOISE_DT].number;
    q->substeps = a[SUBSTEPS].whole;
    q->speeds = a[SPEEDS].data;
    q->motor_force = a[MOTOR_FORCE].number;
    q->back_damping = a[BACK_DAMPING].number;
    q->full_speed = a[FULL_SPEED].number;
    q->limit = a[LIMIT].number;
    q->calm = a[CALM].number;
    q->calm_steps = a[CALM_STEPS].whole;
    q->x = a[X].data;
    q->gap = a[GAP].data;
    q->touched = a[TOUCHED].data;
    q->out = a[OUT].data;
    q->samples = a[TIMES].count;
    q->points = a[NOISE].count / 2;
    q->rows = a[SPEEDS].count / 2;
    const bool fits = a[STIFFNESS].count == 2 && a[TOUCH].count == 2 && a[GAP].count == 2
                      && a[TOUCHED].count == 2 && a[X].count == STATES
                      && a[NOISE].count == 2 * q->points && a[SPEEDS].count == 2 * q->rows
                      && a[OUT].count == q->samples * 2 * OUTPUTS && q->samples > 0
                      && q->points > 1 && q->rows > 0 && q->substeps > 0 && q->calm_steps > 0;
    if (fits && fields(a + INDEX_FINGER, &q->finger[0], sizeof q->finger[0])
        && fields(a + THUMB, &q->finger[1], sizeof q->finger[1])
        && fields(a + TARGET, &q->object, sizeof q->object))
        return true;
    release(a, n);
    misfit();
    return false;
}

static PyObject *twin_integrate_all(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    (void)self;
    if (n != 1 || !PyList_Check(args[0])) {
        PyErr_SetString(PyExc_TypeError, "a list of pieces is needed");
        return NULL;
    }
    /* Reading an argument can run code that changes the list. */
    PyObject *const pieces = PyList_AsTuple(args[0]);
    if (pieces == NULL)
        return NULL;
    const Py_ssize_t count = PyTuple_Size(pieces);
    argument(*const a)[PIECE_ARGUMENTS] = PyMem_Calloc((size_t)count + 1, sizeof *a);
    fc_pinch *const pinches = PyMem_Calloc((size_t)count + 1, sizeof *pinches);
    PyObject *out = a == NULL || pinches == NULL || count > INT32_MAX ? PyErr_NoMemory() : PyList_New(count);
    Py_ssize_t done = 0;
    for (bool ok = out != NULL; ok && done < count; done += ok) {
        PyObject *const piece = PyTuple_GetItem(pieces, done);
        PyObject *each[PIECE_ARGUMENTS];
        ok = PyTuple_Check(piece) && PyTuple_Size(piece) == PIECE_ARGUMENTS;
        for (Py_ssize_t k = 0; ok && k < PIECE_ARGUMENTS; k++)
            each[k] = PyTuple_GetItem(piece, k);
        if (!ok)
            PyErr_SetString(PyExc_TypeError, "a piece is not a tuple of all its arguments");
        ok = ok && get_piece(each, PIECE_ARGUMENTS, a[done], pinches + done);
    }
    if (out != NULL && done == count) {
        Py_BEGIN_ALLOW_THREADS
        fc_integrate(pinches, (int32_t)count);
        Py_END_ALLOW_THREADS
        for (Py_ssize_t i = 0; i < count; i++)
            PyList_SetItem(out, i, PyLong_FromLongLong(pinches[i].taken));
    } else
        Py_CLEAR(out);
    for (Py_ssize_t i = 0; i < done; i++)
        release(a[i], PIECE_ARGUMENTS);
    Py_DECREF(pieces);
    PyMem_Free(a);
    PyMem_Free(pinches);
    return out;
}

/* tones(lines, turns, amplitudes, depth, out) */
static PyObject *twin_tones(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    argument a[5];
    (void)self;
    if (!gather(args, n, "ZzddD", a))
        return NULL;
    const Py_ssize_t count = a[2].count;
    const bool ok = count < TONES_MOST && a[0].count == count + 1 && a[1].count == count + 1
                    && a[3].count == count;
    RETURN_CALL(a, ok, fc_tones(a[0].data, a[1].data, a[2].data, a[3].data, (int32_t)count, a[4].data,
                a[4].count));
}

/* filtered(sections, x, out) */
static PyObject *twin_filtered(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    argument a[3];
    (void)self;
    if (!gather(args, n, "ddD", a))
        return NULL;
    const Py_ssize_t count = a[0].count / 6;
    const bool ok = a[0].count == 6 * count && count <= SECTIONS_MOST && a[1].count == a[2].count;
    RETURN_CALL(a, ok, fc_filtered(a[0].data, (int32_t)count, a[1].data, a[2].data, a[1].count));
}

/* piezo_counts(volts, out) */
static PyObject *twin_piezo_counts(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    argument a[2];
    (void)self;
    if (!gather(args, n, "dU", a))
        return NULL;
    const bool ok = a[0].count == a[1].count;
    RETURN_CALL(a, ok, fc_piezo_readings(a[0].data, a[1].data, a[0].count));
}

/* force_counts(force, shares, p, noise, dt, state, first, out) */
static PyObject *twin_force_counts(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    argument a[8];
    VelostatParameters p;
    (void)self;
    if (!gather(args, n, "ddtd.D#U", a))
        return NULL;
    const bool ok = a[1].count == TAXELS && a[3].count == a[0].count && a[5].count == 2 * TAXELS
                    && a[7].count == a[0].count && a[6].whole >= 0 && fields(a + 2, &p, sizeof p);
    RETURN_CALL(a, ok, fc_force_readings(a[0].data, a[1].data, &p, a[3].data, a[4].number, a[5].data,
                a[6].whole % TAXELS, a[7].data, a[0].count));
}

/* filter_scans(scans, place, smoothed, readings, sums, out) */
static PyObject *twin_filter_scans(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    argument a[6];
    (void)self;
    if (!gather(args, n, "uLLLLS", a))
        return NULL;
    const Py_ssize_t samples = a[0].count / SCAN;
    int64_t place = -2;
    if (a[1].count == 1)
        memcpy(&place, a[1].data, sizeof place); /* another thread may change it after the check */
    const bool ok = a[0].count == samples * SCAN && a[2].count == 2
                    && a[3].count == 2 * TAXELS * READINGS && a[4].count == 2 * TAXELS
                    && a[5].count == samples * COLUMNS && place >= -1 && place < TAXELS * READINGS;
    RETURN_CALL(a, ok, fc_filter(a[0].data, samples, &place, a[2].data, a[3].data, a[4].data, a[5].data);
                memcpy(a[1].data, &place, sizeof place));
}

/* smooth(counts, out) */
static PyObject *twin_smooth(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    argument a[2];
    (void)self;
    if (!gather(args, n, "uS", a))
        return NULL;
    const bool ok = a[0].count == a[1].count;
    RETURN_CALL(a, ok, fc_smoothed(a[0].data, a[1].data, a[0].count));
}

/* slide(forces, hanging, mass, friction, dt, slid, out) */
static PyObject *twin_slide(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    argument a[7];
    (void)self;
    if (!gather(args, n, "dd...dD", a))
        return NULL;
    const Py_ssize_t samples = a[1].count;
    const bool ok = a[0].count == 2 * samples && a[5].count == 2 && a[6].count == 2 * samples;
    RETURN_CALL(a, ok, fc_slide(a[0].data, a[1].data, a[2].number, a[3].number, a[4].number, a[5].data,
                a[6].data, samples));
}

/* slide_patches(normal, speed, pull, mass, friction, p, finger, factors, patches, state, out) */
static PyObject *twin_slide_patches(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    enum { NORMAL, SPEED, PULL, MASS, FRICTION, SLIP, FINGER, FACTORS, PATCHES, STATE, HEARD, ALL };
    argument a[ALL];
    SlipParameters p;
    FingerParameters finger;
    (void)self;
    if (!gather(args, n, "ddd..ttdDDD", a))
        return NULL;
    const Py_ssize_t samples = a[NORMAL].count, count = a[PATCHES].count / PATCH_STATES;
    const bool ok = a[SPEED].count == samples && a[PULL].count == samples
                    && a[HEARD].count == samples && a[STATE].count == SLIP_STATES
                    && a[PATCHES].count == PATCH_STATES * count && count > 0 && count < 1 << 16
                    && a[FACTORS].count == count * PLACES && fields(a + SLIP, &p, sizeof p)
                    && fields(a + FINGER, &finger, sizeof finger) && p.patches == (double)count;
    RETURN_CALL(a, ok, fc_slide_patches(a[NORMAL].data, a[SPEED].data, a[PULL].data, a[MASS].number,
                a[FRICTION].number, &p, &finger, a[FACTORS].data, a[PATCHES].data, (int32_t)count,
                a[STATE].data, a[HEARD].data, samples));
}

#define TWIN(name) {#name, (PyCFunction)(void (*)(void))twin_##name, METH_FASTCALL, NULL}

static PyMethodDef methods[] = {
    TWIN(integrate_all), TWIN(tones), TWIN(filtered), TWIN(piezo_counts),
    TWIN(force_counts), TWIN(filter_scans), TWIN(smooth), TWIN(slide), TWIN(slide_patches),
    {NULL, NULL, 0, NULL},
};

COMPILED_MODULE("Kernels of the twin.", methods, NULL)
