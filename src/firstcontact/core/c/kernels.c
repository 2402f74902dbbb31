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
static const char NETWORK[] = "firstcontact.network", RIG[] = "firstcontact.rig";
static const char EAR[] = "firstcontact.ear";

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

/* Array of a network: where it goes, how many numbers it has, and their kind. */
typedef struct {
    const void **to;
    Py_ssize_t count;
    enum kind kind;
} array;

/* Copy arrays into one block behind a head, because neighbours are read one after the other. */
static char *packed(PyObject *from, const array *arrays, Py_ssize_t n, size_t head)
{
    if (PyTuple_Size(from) != n)
        return (char *)wrong("an array is missing");
    head = (head + 63) / 64 * 64;
    size_t bytes = head;
    for (Py_ssize_t k = 0; k < n; k++)
        bytes += (size_t)(arrays[k].count * array_size(arrays[k].kind) + 63) / 64 * 64;
    char *const block = PyMem_Malloc(bytes);
    if (block == NULL)
        return (char *)PyErr_NoMemory();
    char *at = block + head;
    for (Py_ssize_t k = 0; k < n; k++) {
        const Py_ssize_t length = arrays[k].count * array_size(arrays[k].kind);
        Py_buffer view;
        if (!array_take(PyTuple_GetItem(from, k), &view, arrays[k].count, arrays[k].kind, false)) {
            PyMem_Free(block);
            return NULL;
        }
        memcpy(at, view.buf, (size_t)length);
        PyBuffer_Release(&view);
        memcpy((void *)arrays[k].to, &at, sizeof at);
        at += (length + 63) / 64 * 64;
    }
    return block;
}

static int sizes(PyObject *from, int32_t *size, Py_ssize_t n)
{
    if (PyTuple_Size(from) != n)
        return 0;
    for (Py_ssize_t k = 0; k < n; k++)
        if ((size[k] = number(PyTuple_GetItem(from, k))) < 0)
            return 0;
    return 1;
}

static int set_layer(fc_layer *layer, int32_t inputs, int32_t outputs)
{
    layer->inputs = inputs;
    layer->outputs = outputs;
    return inputs > 0 && inputs <= 2 * UNITS_MOST && outputs > 0 && outputs <= UNITS_MOST;
}

#define TO(field) (const void **)&(field)

/* network(sizes, arrays): sizes (stages, query1, query2, found, body1, body2, body3), and the arrays
   in the order below. */
static PyObject *network(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    enum { ARRAYS = 19 };
    int32_t size[7];
    fc_network net;
    (void)self;
    if (!has(n, 2))
        return NULL;
    memset(&net, 0, sizeof net);
    if (!sizes(args[0], size, 7))
        return wrong("a size of the network is out of range");
    const int32_t stages = net.stages = size[0];
    const int fits = set_layer(&net.query1, INPUTS, size[1])
                     && set_layer(&net.query2, size[1], size[2])
                     && set_layer(&net.body1, size[1] + size[3], size[4])
                     && set_layer(&net.body2, size[4], size[5])
                     && set_layer(&net.body3, size[5], size[6])
                     && set_layer(&net.answer, size[6], 3 * COMPONENTS);
    if (!fits || stages < 1 || stages > 100 || size[2] % HEADS || size[3] % HEADS || !size[3])
        return wrong("the network is too large");
    array arrays[ARRAYS] = {
        {TO(net.mean), INPUTS, F32},
        {TO(net.sd), INPUTS, F32},
        {TO(net.usual), stages * TRAITS, F64},
        {TO(net.whitening), stages * TRAITS * TRAITS, F64},
        {TO(net.limit), stages, F64},
        {TO(net.gain), TRAITS, F64},
        {TO(net.factors), stages, F64},
    };
    fc_layer *const layers[] = {&net.query1, &net.query2, &net.body1,
                                &net.body2, &net.body3, &net.answer};
    for (int k = 0; k < 6; k++) {
        const fc_layer *const l = layers[k];
        arrays[7 + 2 * k] = (array){TO(layers[k]->weight), (Py_ssize_t)l->inputs * l->outputs, F32};
        arrays[8 + 2 * k] = (array){TO(layers[k]->bias), l->outputs, F32};
    }
    char *const block = packed(args[1], arrays, ARRAYS, sizeof net);
    if (block == NULL)
        return NULL;
    fc_network_prepare(&net);
    memcpy(block, &net, sizeof net);
    return capsule(block, NETWORK);
}

/* rig(network, sizes, numbers, arrays): sizes (levels, pinches of the regression or 0), numbers
   (level, sign, centre, unit), and the arrays in the order below. */
static PyObject *rig(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    enum { ARRAYS = 10 };
    int32_t size[2];
    double numbers[4];
    fc_rig out;
    (void)self;
    if (!has(n, 4))
        return NULL;
    memset(&out, 0, sizeof out);
    const fc_network *const net = PyCapsule_GetPointer(args[0], NETWORK);
    if (net == NULL)
        return NULL;
    if (!sizes(args[1], size, 2) || size[0] > LEVELS_MOST || size[1] > KNOWN_MOST)
        return wrong("the rig is too large");
    if (PyTuple_Size(args[2]) != 4)
        return wrong("a number is missing");
    for (int k = 0; k < 4; k++)
        numbers[k] = PyFloat_AsDouble(PyTuple_GetItem(args[2], k));
    if (PyErr_Occurred())
        return NULL;
    const int32_t stages = net->stages, levels = out.levels = size[0], known = size[1];
    fc_regression *const r = &out.regression;
    out.network = net;
    out.level = numbers[0];
    out.sign = numbers[1];
    r->n = known;
    r->centre = numbers[2];
    r->unit = numbers[3];
    const array arrays[ARRAYS] = {
        {TO(out.along), stages * net->body1.outputs, F32},
        {TO(out.keys), stages * levels * net->query2.outputs, F32},
        {TO(out.values), stages * levels * (net->body1.inputs - net->query1.outputs), F32},
        {TO(r->mean), known ? stages * KNOWN : 0, F64},
        {TO(r->sd), known ? stages * KNOWN : 0, F64},
        {TO(r->known), (Py_ssize_t)stages * KNOWN * known, F64},
        {TO(r->squares), stages * known, F64},
        {TO(r->weights), stages * known, F64},
        {TO(r->inverse), (Py_ssize_t)stages * known * known, F64},
        {TO(r->scale), known ? stages : 0, F64},
    };
    char *const block = packed(args[3], arrays, ARRAYS, sizeof out);
    if (block == NULL)
        return NULL;
    memcpy(block, &out, sizeof out);
    return capsule(block, RIG);
}

/* predict(network, rig, signal, valid, stage, beside, noise): value, low, high, half width, and a flag;
   None if they are not finite. */
static PyObject *predict(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    Py_buffer signal, beside;
    fc_estimate e;
    (void)self;
    if (!has(n, 7))
        return NULL;
    const fc_network *const net = PyCapsule_GetPointer(args[0], NETWORK);
    const fc_rig *const r = PyCapsule_GetPointer(args[1], RIG);
    const int32_t valid = number(args[3]), stage = number(args[4]);
    const double noise = PyFloat_AsDouble(args[6]);
    if (net == NULL || r == NULL || PyErr_Occurred())
        return NULL;
    if (valid < 2 || valid > POINTS || stage < 0 || stage >= net->stages)
        return wrong("the number of samples is out of range");
    if (r->network != net)
        return wrong("the rig was made for another network");
    if (!array_take(args[2], &signal, POINTS, F32, false))
        return NULL;
    if (!array_take(args[5], &beside, BESIDE, F64, false)) {
        PyBuffer_Release(&signal);
        return NULL;
    }
    fc_predict(net, r, signal.buf, valid, stage, beside.buf, noise, &e);
    PyBuffer_Release(&beside);
    PyBuffer_Release(&signal);
    if (!e.is_finite)
        Py_RETURN_NONE;
    return Py_BuildValue("ddddO", e.value, e.low, e.high, e.half_width,
                         e.is_out_of_range ? Py_True : Py_False);
}

/* ear(fade, cell, part, turn) */
static PyObject *ear(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    Py_buffer view;
    (void)self;
    if (!has(n, 4))
        return NULL;
    fc_ear *const e = PyMem_Calloc(1, sizeof *e);
    if (e == NULL)
        return PyErr_NoMemory();
    if (!array_get(args[0], &view, F64, false))
        goto failed;
    e->heard = (int32_t)(view.len / (Py_ssize_t)sizeof(double));
    if (e->heard < 1 || view.len > (Py_ssize_t)sizeof e->fade) {
        PyBuffer_Release(&view);
        wrong("too many samples before a contact");
        goto failed;
    }
    memcpy(e->fade, view.buf, (size_t)view.len);
    PyBuffer_Release(&view);
    void *const to[] = {e->cell, e->part, e->turn};
    const Py_ssize_t counts[] = {LINES, LINES, 2 * HALF + HALF / 2};
    const enum kind kinds[] = {I32, F64, F64};
    for (int k = 0; k < 3; k++) {
        if (!array_take(args[k + 1], &view, counts[k], kinds[k], false))
            goto failed;
        memcpy(to[k], view.buf, (size_t)view.len);
        PyBuffer_Release(&view);
    }
    for (int k = 0; k < LINES; k++)
        if (e->cell[k] < 0 || e->cell[k] >= HALF) {
            wrong("a line lies outside the spectrum");
            goto failed;
        }
    return capsule(e, EAR);
failed:
    PyMem_Free(e);
    return NULL;
}

/* listen(ear, reference, signal): shift in points, and correlation. The signal begins with
   the samples that are heard. */
static PyObject *listen(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    Py_buffer reference, signal;
    int32_t shift;
    double alike;
    (void)self;
    if (!has(n, 3))
        return NULL;
    const fc_ear *const e = PyCapsule_GetPointer(args[0], EAR);
    if (e == NULL || !array_take(args[1], &reference, LINES, F64, false))
        return NULL;
    if (!array_take(args[2], &signal, e->heard, F32, false)) {
        PyBuffer_Release(&reference);
        return NULL;
    }
    fc_listen(e, reference.buf, signal.buf, &shift, &alike);
    PyBuffer_Release(&signal);
    PyBuffer_Release(&reference);
    return Py_BuildValue("id", (int)shift, alike);
}

#define FUNCTION(name, function) {name, (PyCFunction)(void (*)(void))function, METH_FASTCALL, NULL}
#define METHOD(name) FUNCTION(#name, name)
#define TWIN(name) FUNCTION(#name, twin_##name)

static PyMethodDef methods[] = {
    METHOD(detector), METHOD(judge), METHOD(quiet_steps), METHOD(network), METHOD(rig), METHOD(predict),
    METHOD(ear), METHOD(listen), METHOD(decode_samples),
    TWIN(integrate_all), TWIN(tones), TWIN(filtered), TWIN(piezo_counts),
    TWIN(force_counts), TWIN(filter_scans), TWIN(smooth), TWIN(slide), TWIN(slide_patches),
    {NULL, NULL, 0, NULL},
};

static PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "_compiled", "Kernels of live detection, estimation and the twin.", 0, methods,
    NULL, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__compiled(void)
{
    return PyModuleDef_Init(&definition);
}
