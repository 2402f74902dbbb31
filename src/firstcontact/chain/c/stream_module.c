/* Chains of the Python module: samples in, events out. */
#include "extension.h"

#include <math.h>
#include <string.h>

static const char STREAM[] = "firstcontact.chain";

/* The Python functions that a chain calls, in the order of their tuple. */
enum { SETTLED, JUDGE, PREDICT, CONTACT, FUNCTIONS };

/* Chain with its image and its columns. The garbage collector cannot look into a capsule. So the
   functions, which refer to the owner of the chain, come with each call. */
typedef struct {
    fc_chain chain;
    PyObject *image;        /* capsule */
    PyObject *functions[FUNCTIONS]; /* of the call in progress, borrowed */
    PyObject *events, *windows; /* lists of the call in progress; windows is NULL without a trace */
    bool is_traced;
    Py_ssize_t width;
    int32_t columns[FC_CHANNELS_MOST + FC_TAXELS_MOST];
    double offset[FC_CHANNELS_MOST + FC_TAXELS_MOST], scale[FC_CHANNELS_MOST + FC_TAXELS_MOST];
    long long epoch;
    double memory[];
} held_chain;

static void append(PyObject *list, PyObject *item)
{
    if (item != NULL && list != NULL)
        PyList_Append(list, item);
    Py_XDECREF(item);
}

/* Take (speed, error, radius) from a Python function's result. */
static bool read_hints(PyObject *object, fc_hints *hints)
{
    return object != NULL && PyArg_ParseTuple(object, "ddd", &hints->speed, &hints->error, &hints->radius);
}

static void on_event(void *context, const fc_event *e)
{
    held_chain *const h = context;
    const fc_estimate *const s = &e->estimate;
    if (PyErr_Occurred())
        return;
    append(h->events,
           Py_BuildValue("(iiiiLLifffff)", e->kind, e->reason, e->flags, e->channel,
                         (long long)e->sample, (long long)e->known, e->samples, s->value, s->low,
                         s->high, s->half_width, s->spread));
    if (h->functions[CONTACT] != Py_None && e->kind == FC_CONTACT_FOUND && (e->flags & FC_IS_FIRST)) {
        fc_hints hints;
        PyObject *const out = PyObject_CallFunction(h->functions[CONTACT], "L", (long long)e->sample);
        if (read_hints(out, &hints))
            fc_chain_hint(&h->chain, &hints);
        Py_XDECREF(out);
    }
}

static void on_window(void *context, int64_t end, const int64_t *onsets)
{
    held_chain *const h = context;
    if (PyErr_Occurred())
        return;
    const Py_ssize_t channels = h->chain.stream.channels;
    PyObject *const row = PyTuple_New(channels + 1);
    if (row == NULL)
        return;
    PyTuple_SetItem(row, 0, PyLong_FromLongLong(end - 1));
    for (Py_ssize_t k = 0; k < channels; k++)
        PyTuple_SetItem(row, k + 1, PyLong_FromLongLong(onsets[k]));
    append(h->windows, row);
}

static PyObject *doubles_of(const double *x, Py_ssize_t n)
{
    return PyMemoryView_FromMemory((char *)(uintptr_t)x, n * (Py_ssize_t)sizeof *x, PyBUF_READ);
}

static void on_settled(void *context, const double *quiet)
{
    held_chain *const h = context;
    const Py_ssize_t n = (Py_ssize_t)h->chain.detector.constants->steady * h->chain.stream.channels;
    PyObject *const view = PyErr_Occurred() ? NULL : doubles_of(quiet, n);
    if (view != NULL)
        Py_XDECREF(PyObject_CallFunctionObjArgs(h->functions[SETTLED], view, NULL));
    Py_XDECREF(view);
}

static void on_judge(void *context, const double *windows, uint8_t *fired)
{
    held_chain *const h = context;
    const int32_t channels = h->chain.stream.channels;
    const Py_ssize_t n = (Py_ssize_t)h->chain.detector.constants->window * channels;
    PyObject *const view = PyErr_Occurred() ? NULL : doubles_of(windows, n);
    PyObject *const mask = view == NULL ? NULL : PyObject_CallFunctionObjArgs(h->functions[JUDGE], view, NULL);
    const long bits = mask == NULL ? 0 : PyLong_AsLong(mask);
    for (int32_t k = 0; k < channels; k++)
        fired[k] = bits > 0 && (bits >> k) & 1;
    Py_XDECREF(mask);
    Py_XDECREF(view);
}

/* Call the function with the signal of a contact. It returns numbers, or None for an unusable signal. */
static int32_t on_predict(void *context, const fc_chain *c, int32_t lead, int32_t samples,
                          fc_estimate *out)
{
    held_chain *const h = context;
    const fc_hints *const hints = &c->hints;
    int is_out = 0;
    if (PyErr_Occurred())
        return FC_NOT_FINITE;
    PyObject *const signal
        = PyBytes_FromStringAndSize(NULL, (lead + samples) * (Py_ssize_t)sizeof(double));
    if (signal == NULL)
        return FC_NOT_FINITE;
    char *const bytes = PyBytes_AsString(signal);
    for (int32_t k = 0; k < lead + samples; k++) {
        const double volts = fc_past_at(&c->past, c->channel, c->first - lead + k);
        memcpy(bytes + (size_t)k * sizeof volts, &volts, sizeof volts);
    }
    PyObject *const result = PyObject_CallFunction(
        h->functions[PREDICT], "Oiiiddd", signal, lead, samples - c->image->model.sizes->lookahead,
        (int)c->stream.finger[c->channel], hints->speed, hints->error, hints->radius);
    Py_DECREF(signal);
    if (result == NULL || result == Py_None) {
        Py_XDECREF(result);
        return FC_NO_SIGNAL;
    }
    const bool is_right = PyArg_ParseTuple(result, "fffffp", &out->value, &out->low, &out->high,
                                           &out->half_width, &out->spread, &is_out);
    out->is_out_of_range = is_out != 0;
    Py_DECREF(result);
    const bool is_finite = isfinite(out->value) && isfinite(out->low) && isfinite(out->high);
    return is_right && is_finite ? FC_DONE : FC_NOT_FINITE;
}

static void free_chain(PyObject *capsule)
{
    held_chain *const h = PyCapsule_GetPointer(capsule, STREAM);
    Py_XDECREF(h->image);
    PyMem_Free(h);
}

/* Fetch the functions from a tuple of functions or None. */
static bool fetch_functions(PyObject *tuple, PyObject **functions)
{
    if (PyTuple_Size(tuple) != FUNCTIONS)
        return refuse("a chain takes four functions") != NULL;
    for (Py_ssize_t k = 0; k < FUNCTIONS; k++)
        functions[k] = PyTuple_GetItem(tuple, k);
    return true;
}

/* The arrays that a chain is made from. */
enum { FINGERS, ALPHA, FLOORS, COLUMNS, OFFSET, SCALE, ARRAYS };

/* Return NULL, or why the arrays do not fit together. */
static const char *misfit(const fc_image *image, PyObject *const *functions, const Py_buffer *of,
                          Py_ssize_t width)
{
    const Py_ssize_t channels = of[FINGERS].len / 4, floors = of[FLOORS].len / 8;
    const Py_ssize_t columns = of[COLUMNS].len / 4;
    const int32_t *const column = of[COLUMNS].buf;
    if (channels < 1 || channels > FC_CHANNELS_MOST)
        return "a chain has 1 to 6 vibration channels";
    bool fits = columns >= channels && columns - channels <= FC_TAXELS_MOST
                && (floors == 0 || floors == channels);
    for (Py_ssize_t k = 0; k < columns; k++)
        fits = fits && column[k] >= 0 && column[k] < width;
    if (image->model.kind == FC_MODEL_PROGRAM)
        fits = fits && functions[PREDICT] != Py_None;
    if (image->detector->kind == FC_DETECTOR_PROGRAM)
        fits = fits && functions[SETTLED] != Py_None && functions[JUDGE] != Py_None;
    return fits ? NULL : "the columns of the chain do not fit together";
}

/* Return a capsule with a new chain. */
static PyObject *new_chain(PyObject *capsule, const fc_image *image, const fc_stream *stream,
                           const Py_buffer *of, Py_ssize_t width, bool is_traced, bool predicts)
{
    held_chain *const h = PyMem_Calloc(1, sizeof *h + fc_chain_bytes(image, stream));
    if (h == NULL)
        return PyErr_NoMemory();
    h->image = Py_NewRef(capsule);
    h->is_traced = is_traced;
    h->width = width;
    memcpy(h->columns, of[COLUMNS].buf, (size_t)of[COLUMNS].len);
    memcpy(h->offset, of[OFFSET].buf, (size_t)of[OFFSET].len);
    memcpy(h->scale, of[SCALE].buf, (size_t)of[SCALE].len);
    const fc_program program = {
        h, on_event, is_traced ? on_window : NULL, NULL, predicts ? on_predict : NULL,
        {on_settled, on_judge, h},
    };
    fc_chain_init(&h->chain, image, stream, &program, h->memory);
    PyObject *const made = PyCapsule_New(h, STREAM, free_chain);
    if (made == NULL) {
        Py_DECREF(h->image);
        PyMem_Free(h);
    }
    return made;
}

/* chain(image, fingers, alpha, floors, columns, offset, scale, width, is_by_hand,
   keeps_first_state, is_traced, functions)

   floors is an empty array if they are unknown. columns, offset and scale: vibration channels,
   then taxels. functions: settled, judge, predict and contact, each None if later calls have none. */
static PyObject *make_chain(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    Py_buffer of[ARRAYS];
    PyObject *functions[FUNCTIONS], *made = NULL;
    int held = 0;
    (void)self;
    if (!has(n, 12) || !fetch_functions(args[11], functions))
        return NULL;
    const held_image *const image = PyCapsule_GetPointer(args[0], IMAGE);
    const Py_ssize_t width = PyLong_AsSsize_t(args[7]);
    const int is_by_hand = PyObject_IsTrue(args[8]), keeps_first_state = PyObject_IsTrue(args[9]);
    const int is_traced = PyObject_IsTrue(args[10]);
    if (!PyErr_Occurred() && array_get(args[1], of + FINGERS, I32, false) && ++held
        && array_take(args[2], of + ALPHA, of[FINGERS].len / 4, F64, false) && ++held
        && array_get(args[3], of + FLOORS, F64, false) && ++held
        && array_get(args[4], of + COLUMNS, I32, false) && ++held
        && array_take(args[5], of + OFFSET, of[COLUMNS].len / 4, F64, false) && ++held
        && array_take(args[6], of + SCALE, of[COLUMNS].len / 4, F64, false) && ++held) {
        const char *const fault = misfit(&image->image, functions, of, width);
        if (fault == NULL) {
            fc_stream stream = {0};
            stream.channels = (int32_t)(of[FINGERS].len / 4);
            stream.taxels = (int32_t)(of[COLUMNS].len / 4) - stream.channels;
            memcpy(stream.finger, of[FINGERS].buf, (size_t)of[FINGERS].len);
            memcpy(stream.alpha, of[ALPHA].buf, (size_t)of[ALPHA].len);
            memcpy(stream.floors, of[FLOORS].buf, (size_t)of[FLOORS].len);
            stream.has_floors = of[FLOORS].len > 0;
            stream.is_by_hand = is_by_hand;
            stream.keeps_first_state = keeps_first_state;
            made = new_chain(args[0], &image->image, &stream, of, width, is_traced,
                             functions[PREDICT] != Py_None);
        } else {
            refuse(fault);
        }
    }
    release(of, held);
    return made;
}

static double number_at(const void *data, enum kind kind, Py_ssize_t k)
{
    switch (kind) {
    case I16:
        return ((const int16_t *)data)[k];
    case U16:
        return ((const uint16_t *)data)[k];
    case I32:
        return ((const int32_t *)data)[k];
    case F32:
        return (double)((const float *)data)[k];
    default:
        return ((const double *)data)[k];
    }
}

/* Return the lists of the call that ends here, or NULL after an error. */
static PyObject *results(held_chain *h)
{
    PyObject *out = NULL;
    if (!PyErr_Occurred())
        out = h->is_traced ? PyTuple_Pack(2, h->events, h->windows) : Py_NewRef(h->events);
    Py_CLEAR(h->events);
    Py_CLEAR(h->windows);
    return out;
}

static bool begin_call(held_chain *h, PyObject *functions)
{
    if (h == NULL || h->events != NULL)
        return h == NULL ? false : refuse("the chain is in use") != NULL;
    if (!fetch_functions(functions, h->functions))
        return false;
    h->events = PyList_New(0);
    h->windows = h->is_traced ? PyList_New(0) : NULL;
    return h->events != NULL;
}

/* take(chain, data, first, epoch, functions): process samples (samples, width). Return the
   events. */
static PyObject *take(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    static const enum kind KINDS[] = {I16, F64, F32, I32, U16};
    Py_buffer view;
    enum kind kind = F64;
    bool is_read = false;
    (void)self;
    if (!has(n, 5))
        return NULL;
    held_chain *const h = PyCapsule_GetPointer(args[0], STREAM);
    const long long first = PyLong_AsLongLong(args[2]), epoch = PyLong_AsLongLong(args[3]);
    if (h == NULL || PyErr_Occurred())
        return NULL;
    for (size_t k = 0; k < sizeof KINDS / sizeof *KINDS && !is_read; k++) {
        PyErr_Clear();
        kind = KINDS[k];
        is_read = array_get(args[1], &view, kind, false);
    }
    if (!is_read)
        return NULL;
    fc_chain *const c = &h->chain;
    const int32_t channels = c->stream.channels, columns = channels + c->stream.taxels;
    const Py_ssize_t samples = view.len / (h->width * array_size(kind));
    if (samples * h->width * array_size(kind) != view.len)
        refuse("the samples do not have the width of the chain");
    else if (first < 0)
        refuse("the number of the first sample must be 0 or more");
    if (PyErr_Occurred() || !begin_call(h, args[4])) {
        PyBuffer_Release(&view);
        return NULL;
    }
    if (!c->has_begun || first != c->next || epoch != h->epoch)
        fc_chain_restart(c, first, epoch == h->epoch);
    h->epoch = epoch;
    for (Py_ssize_t i = 0; i < samples && !PyErr_Occurred(); i++) {
        double volts[FC_CHANNELS_MOST + FC_TAXELS_MOST];
        for (int32_t k = 0; k < columns; k++)
            volts[k] = (number_at(view.buf, kind, i * h->width + h->columns[k]) - h->offset[k])
                       * h->scale[k];
        fc_chain_take(c, volts, volts + channels);
    }
    PyBuffer_Release(&view);
    return results(h);
}

static held_chain *chain_of(PyObject *object)
{
    return PyCapsule_GetPointer(object, STREAM);
}

/* finish(chain, functions): end the stream. Return the events. */
static PyObject *finish(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    (void)self;
    if (!has(n, 2))
        return NULL;
    held_chain *const h = chain_of(args[0]);
    if (!begin_call(h, args[1]))
        return NULL;
    fc_chain_finish(&h->chain);
    return results(h);
}

/* hint(chain, speed, error, radius) */
static PyObject *hint(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    (void)self;
    if (!has(n, 4))
        return NULL;
    held_chain *const h = chain_of(args[0]);
    const fc_hints hints
        = {PyFloat_AsDouble(args[1]), PyFloat_AsDouble(args[2]), PyFloat_AsDouble(args[3])};
    if (h == NULL || PyErr_Occurred())
        return NULL;
    fc_chain_hint(&h->chain, &hints);
    Py_RETURN_NONE;
}

/* state(chain, most): a dictionary. "runs" is true in a closing, and also if a pinch is over but its
   motor does not rest yet. */
static PyObject *state(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    (void)self;
    if (!has(n, 2))
        return NULL;
    const held_chain *const h = chain_of(args[0]);
    const long most = PyLong_AsLong(args[1]);
    if (h == NULL || PyErr_Occurred())
        return NULL;
    const fc_chain *const c = &h->chain;
    return Py_BuildValue("{sisisisisisi}", "due", fc_chain_due(c, (int32_t)most),
                         "is_open", c->is_open && !c->is_over, "refused", c->gate.refused,
                         "is_resting", c->stream.has_floors && c->gate.state == FC_GATE_REST,
                         "is_confirmed", c->is_confirmed, "runs", c->is_open);
}

PyMethodDef STREAM_FUNCTIONS[] = {
    {"chain", FAST(make_chain), METH_FASTCALL, "Return a chain."},
    {"take", FAST(take), METH_FASTCALL, "Process samples and return their events."},
    {"finish", FAST(finish), METH_FASTCALL, "End the stream and return its events."},
    {"hint", FAST(hint), METH_FASTCALL, "Set closing speed and radius."},
    {"state", FAST(state), METH_FASTCALL, "Return the state of a chain."},
    {NULL, NULL, 0, NULL},
};
