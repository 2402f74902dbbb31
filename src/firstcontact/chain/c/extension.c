/* Python module of the chain, with images, and the functions that a detector needs for its training. */
#include "extension.h"

#include <string.h>

/* Memory for work, one call at a time. Threads of musl have a stack of only 128 KB. */
static double room[FC_WINDOW_MOST];

static void free_image(PyObject *capsule)
{
    PyMem_Free(PyCapsule_GetPointer(capsule, IMAGE));
}

/* image(bytes): check an image. ValueError says what is wrong with it. */
static PyObject *make_image(PyObject *self, PyObject *object)
{
    char *bytes;
    Py_ssize_t n;
    (void)self;
    if (PyBytes_AsStringAndSize(object, &bytes, &n) < 0)
        return NULL;
    held_image *const held = PyMem_Malloc(sizeof *held + (size_t)n + sizeof(double));
    if (held == NULL)
        return PyErr_NoMemory();
    memcpy(held->bytes, bytes, (size_t)n);
    const char *const fault = fc_image_read((const uint8_t *)held->bytes, (size_t)n, &held->image);
    PyObject *const capsule = fault == NULL ? PyCapsule_New(held, IMAGE, free_image) : refuse(fault);
    if (capsule == NULL)
        PyMem_Free(held);
    return capsule;
}

/* memory(image, channels): bytes of work memory of a chain */
static PyObject *memory(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    (void)self;
    if (!has(n, 2))
        return NULL;
    const held_image *const held = PyCapsule_GetPointer(args[0], IMAGE);
    const fc_stream stream = {.channels = (int32_t)PyLong_AsLong(args[1])};
    return PyErr_Occurred() ? NULL : PyLong_FromSize_t(fc_chain_bytes(&held->image, &stream));
}

/* fit_predictions(quiet, samples, out): quiet (n, samples), in sigmas. out (n, FC_ORDER + 1). */
static PyObject *fit_predictions(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    Py_buffer v[2];
    (void)self;
    if (!has(n, 3) || !array_get(args[0], v, F64, false))
        return NULL;
    const long samples = PyLong_AsLong(args[1]);
    const Py_ssize_t rows = samples > 0 ? v[0].len / 8 / samples : 0;
    if (samples <= 2 * FC_ORDER || samples > FC_WINDOW_MOST
        || !array_take(args[2], v + 1, rows * (FC_ORDER + 1), F64, true)) {
        release(v, 1);
        return refuse("a steady state has 25 to 16384 samples");
    }
    for (Py_ssize_t i = 0; i < rows; i++)
        fc_fit_prediction((const double *)v[0].buf + i * samples, (int32_t)samples, room,
                          (double *)v[1].buf + i * (FC_ORDER + 1));
    release(v, 2);
    Py_RETURN_NONE;
}

/* look_features(looks, samples, weights, lengths, floor, out): looks (n, samples), in sigmas,
   weights (n, FC_ORDER + 1), lengths (FC_PARTS + 1,). out (n, 2 * FC_LEVELS). */
static PyObject *look_features(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    Py_buffer v[4];
    fc_detector_constants k = {0};
    int held = 0;
    bool is_right = false;
    (void)self;
    if (!has(n, 6))
        return NULL;
    const long samples = PyLong_AsLong(args[1]);
    k.floor = PyFloat_AsDouble(args[4]);
    if (PyErr_Occurred())
        return NULL;
    if (samples > 0 && samples <= FC_WINDOW_MOST && array_get(args[0], v, F64, false)) {
        const Py_ssize_t rows = v[0].len / 8 / samples;
        held = 1;
        is_right = array_take(args[2], v + 1, rows * (FC_ORDER + 1), F64, false) && ++held
                   && array_take(args[3], v + 2, FC_PARTS + 1, I32, false) && ++held
                   && array_take(args[5], v + 3, rows * 2 * FC_LEVELS, F64, true) && ++held;
    }
    for (int32_t p = 0; is_right && p <= FC_PARTS; p++) {
        k.lengths[p] = ((const int32_t *)v[2].buf)[p];
        is_right = k.lengths[p] > (p > 0 ? k.lengths[p - 1] : 0);
    }
    is_right = is_right && samples > k.lengths[FC_PARTS] + FC_ORDER;
    for (Py_ssize_t i = 0; is_right && i < v[0].len / 8 / samples; i++)
        fc_look_features(&k, (const double *)v[0].buf + i * samples, (int32_t)samples,
                         (const double *)v[1].buf + i * (FC_ORDER + 1), room,
                         (double *)v[3].buf + i * 2 * FC_LEVELS);
    release(v, held);
    if (!is_right)
        return refuse("the arrays of the looks do not fit together");
    Py_RETURN_NONE;
}

static PyMethodDef OWN_FUNCTIONS[] = {
    {"image", make_image, METH_O, "Check and hold an image of a model."},
    {"memory", FAST(memory), METH_FASTCALL, "Return the bytes of work memory of a chain."},
    {"fit_predictions", FAST(fit_predictions), METH_FASTCALL, "Write linear predictions."},
    {"look_features", FAST(look_features), METH_FASTCALL, "Write the features of looks."},
    {NULL, NULL, 0, NULL},
};

static int add_functions(PyObject *module)
{
    return PyModule_AddFunctions(module, STREAM_FUNCTIONS)
           || PyModule_AddFunctions(module, TOUCH_FUNCTIONS) ? -1 : 0;
}

static PyModuleDef_Slot SLOTS[] = {{Py_mod_exec, (void *)add_functions}, {0, NULL}};

COMPILED_MODULE("The chain: samples in, events out.", OWN_FUNCTIONS, SLOTS)
