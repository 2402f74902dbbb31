/* Python module of the kernels. Arrays come as contiguous buffers, whose sizes are checked here. */
#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030B0000
#include <Python.h>

#include <string.h>

#include "arrays.h"
#include "frames.h"
#include "kernels.h"
#include "twin_module.h"

static const char DETECTOR[] = "firstcontact.detector";

static void release(Py_buffer *views, int n)
{
    while (n--)
        PyBuffer_Release(views + n);
}

static void destroy(PyObject *capsule)
{
    PyMem_Free(PyCapsule_GetPointer(capsule, PyCapsule_GetName(capsule)));
}

static PyObject *capsule(void *pointer, const char *name)
{
    PyObject *const out = PyCapsule_New(pointer, name, destroy);
    if (out == NULL)
        PyMem_Free(pointer);
    return out;
}

static int32_t number(PyObject *object)
{
    const long value = PyLong_AsLong(object);
    if (value == -1 && PyErr_Occurred())
        return -1;
    return value < 0 || value > (1 << 24) ? -1 : (int32_t)value;
}

/* Return true if the call has this many arguments, else set TypeError. */
static int has(Py_ssize_t n, Py_ssize_t wanted)
{
    if (n == wanted)
        return 1;
    PyErr_Format(PyExc_TypeError, "%zd arguments are needed, not %zd", wanted, n);
    return 0;
}

static PyObject *wrong(const char *what)
{
    if (!PyErr_Occurred())
        PyErr_SetString(PyExc_ValueError, what);
    return NULL;
}

/* detector(window, step, looks, search, awake, floor, lengths, line) */
static PyObject *detector(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    Py_buffer views[2];
    (void)self;
    if (!has(n, 8))
        return NULL;
    fc_detector d = {0};
    d.window = number(args[0]);
    d.step = number(args[1]);
    d.looks = number(args[2]);
    d.search = number(args[3]);
    d.awake = PyFloat_AsDouble(args[4]);
    d.floor = PyFloat_AsDouble(args[5]);
    if (PyErr_Occurred() || !array_take(args[6], views, PARTS + 1, I32, false))
        return NULL;
    memcpy(d.lengths, views[0].buf, sizeof d.lengths);
    PyBuffer_Release(views);
    if (!array_take(args[7], views, 2 * EACH + 1, F64, false))
        return NULL;
    memcpy(d.line, views[0].buf, sizeof d.line);
    PyBuffer_Release(views);
    int ok = d.looks > 0 && d.looks <= LOOKS_MOST && d.window <= WINDOW_MOST && d.step > 0
             && d.step <= d.window && d.search >= 0 && d.lengths[0] > 0;
    const int32_t look = ok ? d.window - (d.looks - 1) * d.step : 0;
    ok = ok && look - d.lengths[PARTS] > ORDER;
    for (int k = 0; k < PARTS; k++)
        ok = ok && d.lengths[k] < d.lengths[k + 1];
    if (!ok)
        return wrong("the lengths of the detector do not fit");
    fc_detector *const copy = PyMem_Malloc(sizeof d);
    if (copy == NULL)
        return PyErr_NoMemory();
    *copy = d;
    return capsule(copy, DETECTOR);
}

/* judge(detector, past, first, end, count, mean, sigma, weights, is_judged, memory, onsets) */
static PyObject *judge(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    Py_buffer views[7];
    int held = 0;
    (void)self;
    if (!has(n, 11))
        return NULL;
    const fc_detector *const d = PyCapsule_GetPointer(args[0], DETECTOR);
    const long long first = PyLong_AsLongLong(args[2]);
    const int32_t end = number(args[3]), count = number(args[4]);
    if (d == NULL || PyErr_Occurred())
        return NULL;
    if (!array_get(args[8], views + held, FLAG, false))
        return NULL;
    const Py_ssize_t fingers = views[held++].len;
    if (!array_take(args[5], views + held, fingers, F64, false))
        goto failed;
    held++;
    if (!array_take(args[6], views + held, fingers, F64, false))
        goto failed;
    held++;
    if (!array_take(args[7], views + held, fingers * (ORDER + 1), F64, false))
        goto failed;
    held++;
    if (!array_take(args[9], views + held, fingers * LOOKS_MOST * 2, F64, true))
        goto failed;
    held++;
    if (!array_take(args[10], views + held, count * fingers, I32, true))
        goto failed;
    held++;
    if (!array_get(args[1], views + held, F64, false))
        goto failed;
    held++;
    const Py_ssize_t samples = fingers ? views[6].len / (fingers * (Py_ssize_t)sizeof(double)) : 0;
    if (count < 1 || end < d->window || end + (Py_ssize_t)(count - 1) * d->step > samples) {
        wrong("a window lies outside the samples");
        goto failed;
    }
    const fc_closing c = {
        (int32_t)fingers, views[1].buf, views[2].buf, views[3].buf, views[0].buf, views[4].buf,
    };
    fc_judge(d, &c, views[6].buf, first, end, count, views[5].buf);
    release(views, held);
    Py_RETURN_NONE;
failed:
    release(views, held);
    return NULL;
}

/* quiet_steps(volts, width, fingers, step, sums, known, limit, is_quiet) */
static PyObject *quiet_steps(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    Py_buffer views[4];
    int held = 0;
    (void)self;
    if (!has(n, 8))
        return NULL;
    const int32_t width = number(args[1]), fingers = number(args[2]), step = number(args[3]);
    const long long known = PyLong_AsLongLong(args[5]);
    if (fingers < 1 || width < fingers || width > WIDTH_MOST || step < 1 || step > STEP_MOST
        || PyErr_Occurred())
        return wrong("the sizes of the steps do not fit");
    if (!array_get(args[7], views, FLAG, true))
        return NULL;
    held++;
    const Py_ssize_t steps = views[0].len;
    if (steps > INT32_MAX) {
        wrong("there are too many steps");
        goto failed;
    }
    if (!array_take(args[0], views + held, steps * step * width, F64, false))
        goto failed;
    held++;
    if (!array_take(args[4], views + held, STEPS * 2 * fingers, F64, true))
        goto failed;
    held++;
    if (!array_take(args[6], views + held, fingers, F64, false))
        goto failed;
    held++;
    fc_quiet_steps(views[1].buf, width, fingers, step, (int32_t)steps, views[2].buf, known,
                   views[3].buf, views[0].buf);
    release(views, held);
    Py_RETURN_NONE;
failed:
    release(views, held);
    return NULL;
}

#define FUNCTION(name, function) {name, (PyCFunction)(void (*)(void))function, METH_FASTCALL, NULL}
#define METHOD(name) FUNCTION(#name, name)
#define TWIN(name) FUNCTION(#name, twin_##name)

static PyMethodDef methods[] = {
    METHOD(detector), METHOD(judge), METHOD(quiet_steps), METHOD(decode_samples),
    TWIN(integrate_all), TWIN(tones), TWIN(filtered), TWIN(piezo_counts),
    TWIN(force_counts), TWIN(filter_scans), TWIN(smooth), TWIN(slide), TWIN(slide_patches),
    {NULL, NULL, 0, NULL},
};

static PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "_compiled", "Kernels of live detection and the twin.", 0, methods,
    NULL, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__compiled(void)
{
    return PyModuleDef_Init(&definition);
}
