/* Python module of the chain. Arrays come as contiguous buffers, whose sizes are checked here. */
#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030B0000
#include <Python.h>

#include <math.h>
#include <string.h>

#include "arrays.h"
#include "fc_chain.h"

static const char IMAGE[] = "firstcontact.image", STREAM[] = "firstcontact.chain";

/* Image with its own copy of the bytes. */
typedef struct {
    fc_image image;
    double bytes[];
} held_image;

/* Chain with its image, its columns, and the Python functions that it calls. */
typedef struct {
    fc_chain chain;
    PyObject *image;        /* capsule */
    PyObject *settled, *judge, *predict, *contact; /* NULL for None */
    PyObject *events, *windows; /* lists of the call in progress; windows is NULL without a trace */
    bool is_traced;
    Py_ssize_t width;
    int32_t columns[FC_CHANNELS_MOST + FC_TAXELS_MOST];
    double offset[FC_CHANNELS_MOST + FC_TAXELS_MOST], scale[FC_CHANNELS_MOST + FC_TAXELS_MOST];
    long long epoch;
    double memory[];
} held_chain;

static void release(Py_buffer *views, int n)
{
    while (n--)
        PyBuffer_Release(views + n);
}

static PyObject *refuse(const char *why)
{
    if (!PyErr_Occurred())
        PyErr_SetString(PyExc_ValueError, why);
    return NULL;
}

static bool has(Py_ssize_t n, Py_ssize_t wanted)
{
    if (n != wanted)
        PyErr_Format(PyExc_TypeError, "%zd arguments are needed, not %zd", wanted, n);
    return n == wanted;
}

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

static void append(held_chain *h, PyObject *list, PyObject *item)
{
    (void)h;
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
    append(h, h->events,
           Py_BuildValue("(iiiiLLifffff)", e->kind, e->reason, e->flags, e->channel,
                         (long long)e->sample, (long long)e->known, e->samples, s->value, s->low,
                         s->high, s->half_width, s->spread));
    if (h->contact != NULL && e->kind == FC_CONTACT_FOUND && (e->flags & FC_IS_FIRST)) {
        fc_hints hints;
        PyObject *const out = PyObject_CallFunction(h->contact, "L", (long long)e->sample);
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
    append(h, h->windows, row);
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
        Py_XDECREF(PyObject_CallFunctionObjArgs(h->settled, view, NULL));
    Py_XDECREF(view);
}

static void on_judge(void *context, const double *windows, uint8_t *fired)
{
    held_chain *const h = context;
    const int32_t channels = h->chain.stream.channels;
    const Py_ssize_t n = (Py_ssize_t)h->chain.detector.constants->window * channels;
    PyObject *const view = PyErr_Occurred() ? NULL : doubles_of(windows, n);
    PyObject *const mask = view == NULL ? NULL : PyObject_CallFunctionObjArgs(h->judge, view, NULL);
    const long bits = mask == NULL ? 0 : PyLong_AsLong(mask);
    for (int32_t k = 0; k < channels; k++)
        fired[k] = bits > 0 && (bits >> k) & 1;
    Py_XDECREF(mask);
    Py_XDECREF(view);
}

static bool on_predict(void *context, const fc_chain *c, int32_t samples, fc_estimate *out)
{
    held_chain *const h = context;
    const fc_hints *const hints = &c->hints;
    float signal[FC_BEFORE_MOST + FC_POINTS] = {0.0f};
    const int32_t before = c->image->model.before;
    if (PyErr_Occurred())
        return false;
    memcpy(signal, c->before, sizeof(float) * (size_t)before);
    for (int32_t k = 0; k < c->touch.samples; k++)
        signal[before + k] = (float)(c->touch.rig->sign * c->touch.volts[k]);
    PyObject *const view = PyMemoryView_FromMemory(
        (char *)signal, (before + FC_POINTS) * (Py_ssize_t)sizeof *signal, PyBUF_READ);
    PyObject *const result = view == NULL ? NULL
        : PyObject_CallFunction(h->predict, "Oiiddd", view, samples, c->stream.finger[c->channel],
                                hints->speed, hints->error, hints->radius);
    int is_out = 0;
    const bool is_right = result != NULL
        && PyArg_ParseTuple(result, "fffffp", &out->value, &out->low, &out->high,
                            &out->half_width, &out->spread, &is_out);
    out->is_out_of_range = is_out != 0;
    Py_XDECREF(result);
    Py_XDECREF(view);
    return is_right && isfinite(out->value) && isfinite(out->low) && isfinite(out->high);
}

static void free_chain(PyObject *capsule)
{
    held_chain *const h = PyCapsule_GetPointer(capsule, STREAM);
    Py_XDECREF(h->image);
    Py_XDECREF(h->settled);
    Py_XDECREF(h->judge);
    Py_XDECREF(h->predict);
    Py_XDECREF(h->contact);
    PyMem_Free(h);
}

static PyObject *function_or_null(PyObject *object)
{
    return object == Py_None ? NULL : Py_NewRef(object);
}

/* chain(image, fingers, alpha, floors, columns, offset, scale, width, is_by_hand,
   keeps_first_state, is_traced, settled, judge, predict, contact)

   floors is an empty array if they are unknown. columns, offset and scale: vibration channels,
   then taxels. The last four are functions or None. */
static PyObject *make_chain(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    Py_buffer views[6];
    int held = 0;
    fc_stream stream = {0};
    (void)self;
    if (!has(n, 15))
        return NULL;
    held_image *const image = PyCapsule_GetPointer(args[0], IMAGE);
    if (image == NULL || !array_get(args[1], views, I32, false))
        return NULL;
    held = 1;
    const Py_ssize_t channels = views[0].len / 4;
    if (channels < 1 || channels > FC_CHANNELS_MOST) {
        refuse("a chain has 1 to 6 vibration channels");
        goto failed;
    }
    if (!array_take(args[2], views + 1, channels, F64, false))
        goto failed;
    held = 2;
    if (!array_get(args[3], views + 2, F64, false))
        goto failed;
    held = 3;
    if (!array_get(args[4], views + 3, I32, false))
        goto failed;
    held = 4;
    const Py_ssize_t columns = views[3].len / 4;
    if (!array_take(args[5], views + 4, columns, F64, false))
        goto failed;
    held = 5;
    if (!array_take(args[6], views + 5, columns, F64, false))
        goto failed;
    held = 6;
    const Py_ssize_t width = PyLong_AsSsize_t(args[7]);
    const int flags[3] = {PyObject_IsTrue(args[8]), PyObject_IsTrue(args[9]), PyObject_IsTrue(args[10])};
    if (PyErr_Occurred())
        goto failed;
    const Py_ssize_t floors = views[2].len / 8;
    bool fits = columns >= channels && columns - channels <= FC_TAXELS_MOST
                && (floors == 0 || floors == channels);
    for (Py_ssize_t k = 0; k < columns; k++)
        fits = fits && ((const int32_t *)views[3].buf)[k] >= 0 && ((const int32_t *)views[3].buf)[k] < width;
    if (image->image.detector->kind == FC_DETECTOR_PROGRAM)
        fits = fits && args[11] != Py_None && args[12] != Py_None;
    if (!fits) {
        refuse("the columns of the chain do not fit together");
        goto failed;
    }
    stream.channels = (int32_t)channels;
    stream.taxels = (int32_t)(columns - channels);
    memcpy(stream.finger, views[0].buf, (size_t)views[0].len);
    memcpy(stream.alpha, views[1].buf, (size_t)views[1].len);
    memcpy(stream.floors, views[2].buf, (size_t)views[2].len);
    stream.has_floors = floors > 0;
    stream.is_by_hand = flags[0];
    stream.keeps_first_state = flags[1];
    held_chain *const h = PyMem_Calloc(1, sizeof *h + fc_chain_bytes(&image->image, &stream));
    if (h == NULL) {
        PyErr_NoMemory();
        goto failed;
    }
    h->image = Py_NewRef(args[0]);
    h->is_traced = flags[2];
    h->settled = function_or_null(args[11]);
    h->judge = function_or_null(args[12]);
    h->predict = function_or_null(args[13]);
    h->contact = function_or_null(args[14]);
    h->width = width;
    memcpy(h->columns, views[3].buf, (size_t)views[3].len);
    memcpy(h->offset, views[4].buf, (size_t)views[4].len);
    memcpy(h->scale, views[5].buf, (size_t)views[5].len);
    const fc_program program = {
        h, on_event, h->is_traced ? on_window : NULL, NULL, h->predict != NULL ? on_predict : NULL,
        {on_settled, on_judge, h},
    };
    fc_chain_init(&h->chain, &image->image, &stream, &program, h->memory);
    release(views, held);
    PyObject *const capsule = PyCapsule_New(h, STREAM, free_chain);
    if (capsule == NULL)
        PyMem_Free(h);
    return capsule;
failed:
    release(views, held);
    return NULL;
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

static bool begin_call(held_chain *h)
{
    if (h == NULL || h->events != NULL)
        return h == NULL ? false : refuse("the chain is in use") != NULL;
    h->events = PyList_New(0);
    h->windows = h->is_traced ? PyList_New(0) : NULL;
    return h->events != NULL;
}

/* take(chain, data, first, epoch): process samples (samples, width). Return the events. */
static PyObject *take(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    static const enum kind KINDS[] = {I16, F64, F32, I32, U16};
    Py_buffer view;
    enum kind kind = F64;
    bool is_read = false;
    (void)self;
    if (!has(n, 4))
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
    if (samples * h->width * array_size(kind) != view.len || first < 0 || !begin_call(h)) {
        PyBuffer_Release(&view);
        return refuse("the samples do not have the width of the chain");
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

/* finish(chain): end the stream. Return the events. */
static PyObject *finish(PyObject *self, PyObject *object)
{
    held_chain *const h = chain_of(object);
    (void)self;
    if (!begin_call(h))
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

/* state(chain, most): due, is_open, refused motor starts, is at rest, is confirmed, next sample,
   runs (is_open, or a pinch is over but its motor does not rest yet) */
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
    return Py_BuildValue("(iiiiiLi)", fc_chain_due(c, (int32_t)most), c->is_open && !c->is_over,
                         c->gate.refused, c->stream.has_floors && c->gate.state == 1,
                         c->is_confirmed, (long long)c->next, c->is_open);
}

/* Rows of contacts: signals (n, before + FC_POINTS), and the number of valid samples of each. */
typedef struct {
    Py_buffer views[8];
    int held;
    Py_ssize_t n;
    int32_t before;
} rows;

static bool take_row_array(rows *r, PyObject *object, Py_ssize_t each, enum kind kind, bool is_written)
{
    if (!array_take(object, r->views + r->held, r->n * each, kind, is_written))
        return false;
    r->held++;
    return true;
}

static bool take_rows(rows *r, PyObject *signals, PyObject *valid, int32_t before)
{
    r->held = 0;
    r->before = before;
    if (!array_get(valid, r->views, I32, false))
        return false;
    r->n = r->views[0].len / 4;
    r->held = 1;
    if (!take_row_array(r, signals, before + FC_POINTS, F32, false))
        return false;
    for (Py_ssize_t i = 0; i < r->n; i++) {
        const int32_t n = ((const int32_t *)r->views[0].buf)[i];
        if (n < 2 || n > FC_POINTS)
            return refuse("a contact has 2 to 74 valid samples") != NULL;
    }
    return true;
}

static const float *signal_of(const rows *r, Py_ssize_t i)
{
    return (const float *)r->views[1].buf + i * (r->before + FC_POINTS);
}

static int32_t valid_of(const rows *r, Py_ssize_t i)
{
    return ((const int32_t *)r->views[0].buf)[i];
}

static double value_of(const rows *r, int view, Py_ssize_t i)
{
    return ((const double *)r->views[view].buf)[i];
}

/* Image with a model, and the contacts (signals, valid, fingers, speeds, errors, radii) that
   follow it in the arguments. Return NULL with an exception. */
static const fc_model *take_contacts(rows *r, PyObject *const *args)
{
    r->held = 0;
    const held_image *const held = PyCapsule_GetPointer(args[0], IMAGE);
    if (held == NULL || !held->image.has_model)
        return refuse("the image has no model"), NULL;
    const fc_model *const m = &held->image.model;
    if (!take_rows(r, args[1], args[2], m->before) || !take_row_array(r, args[3], 1, I32, false)
        || !take_row_array(r, args[4], 1, F64, false) || !take_row_array(r, args[5], 1, F64, false)
        || !take_row_array(r, args[6], 1, F64, false))
        return NULL;
    return m;
}

/* Begin contact i of take_contacts, with all its valid samples. */
static void begin_contact(fc_touch *t, const fc_model *m, const rows *r, Py_ssize_t i,
                          fc_touch_room *room)
{
    const float *const signal = signal_of(r, i);
    const fc_hints hints = {value_of(r, 3, i), value_of(r, 4, i), value_of(r, 5, i)};
    fc_touch_begin(t, m, ((const int32_t *)r->views[2].buf)[i], signal, room);
    fc_touch_hint(t, &hints);
    for (int32_t k = 0; k < valid_of(r, i); k++)
        fc_touch_take(t, signal[m->before + k]);
}

/* predict(image, signals, valid, fingers, speeds, errors, radii, is_regression, out)

   Predict from contacts. out (n, 6): value, low, high, half width, spread, is out of range. With
   is_regression, the regression of the rig predicts alone, and only value and spread are written. */
static PyObject *predict(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    rows r;
    fc_touch touch;
    fc_touch_room room;
    (void)self;
    if (!has(n, 9))
        return NULL;
    const int is_regression = PyObject_IsTrue(args[7]);
    const fc_model *const m = take_contacts(&r, args);
    if (m == NULL || !take_row_array(&r, args[8], 6, F64, true)) {
        release(r.views, r.held);
        return NULL;
    }
    for (Py_ssize_t i = 0; i < r.n; i++) {
        double *const out = (double *)r.views[6].buf + 6 * i;
        const int32_t valid = valid_of(&r, i);
        fc_estimate e = {NAN, NAN, NAN, NAN, NAN, false};
        begin_contact(&touch, m, &r, i, &room);
        if (is_regression && touch.rig->pinches > 0) {
            double traits[FC_TRAITS];
            fc_touch_traits(&touch, valid, traits);
            fc_process_predict(&touch, fc_touch_stage(m, valid), traits, out, out + 4);
            continue;
        }
        fc_touch_predict(&touch, valid, &room, &e);
        out[0] = e.value;
        out[1] = e.low;
        out[2] = e.high;
        out[3] = e.half_width;
        out[4] = e.spread;
        out[5] = e.is_out_of_range;
    }
    release(r.views, r.held);
    Py_RETURN_NONE;
}

/* rig_inputs(image, signals, valid, fingers, speeds, errors, radii, inputs)

   Write the inputs of the network (n, FC_INPUTS), float32, for contacts of the image's rigs. */
static PyObject *rig_inputs(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    rows r;
    fc_touch touch;
    fc_touch_room room;
    double traits[FC_TRAITS];
    (void)self;
    if (!has(n, 8))
        return NULL;
    const fc_model *const m = take_contacts(&r, args);
    if (m == NULL || !take_row_array(&r, args[7], FC_INPUTS, F32, true)) {
        release(r.views, r.held);
        return NULL;
    }
    for (Py_ssize_t i = 0; i < r.n; i++) {
        begin_contact(&touch, m, &r, i, &room);
        fc_touch_inputs(&touch, valid_of(&r, i), (float *)r.views[6].buf + i * FC_INPUTS, traits);
    }
    release(r.views, r.held);
    Py_RETURN_NONE;
}

/* network(image, inputs, terms, out)

   Predict from inputs (n, FC_INPUTS) and terms of rigs (n, rank). out (n, 2): mean and spread. */
static PyObject *network(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    Py_buffer v[3];
    int held = 0;
    fc_network_room room;
    (void)self;
    if (!has(n, 4))
        return NULL;
    const held_image *const of = PyCapsule_GetPointer(args[0], IMAGE);
    if (of == NULL || !of->image.has_model)
        return refuse("the image has no model");
    const fc_network *const net = &of->image.model.network;
    const int32_t rank = net->layers[FC_RIG_LAYER].into.rows;
    if (!array_get(args[1], v, F32, false))
        return NULL;
    held = 1;
    const Py_ssize_t rows = v[0].len / 4 / FC_INPUTS;
    const bool is_right = v[0].len == rows * 4 * FC_INPUTS
                          && array_take(args[2], v + 1, rows * rank, F32, false) && ++held
                          && array_take(args[3], v + 2, rows * 2, F64, true) && ++held;
    for (Py_ssize_t i = 0; is_right && i < rows; i++) {
        double *const out = (double *)v[2].buf + 2 * i;
        memcpy(room.values, (const float *)v[0].buf + i * FC_INPUTS, FC_INPUTS * sizeof(float));
        fc_network_predict(net, (const float *)v[1].buf + i * rank, &room, out, out + 1);
    }
    release(v, held);
    if (!is_right)
        return refuse("the inputs of the network do not fit");
    Py_RETURN_NONE;
}

/* inputs(signals, valid, before, level, sign, hints, inputs, traits)

   Write the inputs of the network (n, FC_INPUTS), float32, and the traits of contacts
   (n, FC_TRAITS). level, sign (n,): those of each contact's rig. hints (n, FC_HINTS). */
static PyObject *inputs(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    rows r = {.held = 0};
    fc_touch touch;
    fc_touch_room room;
    fc_rig rig = {.finger = -1, .has_level = true};
    (void)self;
    if (!has(n, 8))
        return NULL;
    const long before = PyLong_AsLong(args[2]);
    if (PyErr_Occurred() || before < 4 || before > FC_BEFORE_MOST)
        return refuse("the signal before the contact has 4 to 256 samples");
    if (!take_rows(&r, args[0], args[1], (int32_t)before) || !take_row_array(&r, args[3], 1, F64, false)
        || !take_row_array(&r, args[4], 1, F64, false)
        || !take_row_array(&r, args[5], FC_HINTS, F64, false)
        || !take_row_array(&r, args[6], FC_INPUTS, F32, true)
        || !take_row_array(&r, args[7], FC_TRAITS, F64, true)) {
        release(r.views, r.held);
        return NULL;
    }
    fc_model model = {.before = (int32_t)before, .rigs = 1};
    for (Py_ssize_t i = 0; i < r.n; i++) {
        const float *const signal = signal_of(&r, i);
        rig.level = value_of(&r, 2, i);
        rig.sign = value_of(&r, 3, i);
        model.rig[0] = rig;
        fc_touch_begin(&touch, &model, -1, signal, &room);
        memcpy(touch.hints, (const double *)r.views[4].buf + i * FC_HINTS, sizeof touch.hints);
        for (int32_t k = 0; k < valid_of(&r, i); k++)
            fc_touch_take(&touch, signal[before + k]);
        fc_touch_inputs(&touch, valid_of(&r, i), (float *)r.views[5].buf + i * FC_INPUTS,
                        (double *)r.views[6].buf + i * FC_TRAITS);
    }
    release(r.views, r.held);
    Py_RETURN_NONE;
}

/* spectra(signals, samples, sine, fade, part, cell, out): signals (n, samples), out (n, FC_LINES) */
static PyObject *spectra(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    Py_buffer v[6];
    int held = 0;
    float work[FC_TURN];
    bool is_right;
    (void)self;
    if (!has(n, 7))
        return NULL;
    const long samples = PyLong_AsLong(args[1]);
    if (PyErr_Occurred() || samples < 2 || samples > FC_TURN)
        return refuse("the spectrum needs 2 to 512 samples");
    is_right = array_get(args[0], v, F32, false) && ++held
               && array_take(args[2], v + 1, FC_TURN / 4 + 1, F32, false) && ++held
               && array_take(args[3], v + 2, samples, F32, false) && ++held
               && array_take(args[4], v + 3, FC_LINES, F32, false) && ++held
               && array_take(args[5], v + 4, FC_LINES, I32, false) && ++held
               && array_take(args[6], v + 5, v[0].len / 4 / samples * FC_LINES, F32, true) && ++held;
    for (int32_t k = 0; is_right && k < FC_LINES; k++)
        is_right = ((const int32_t *)v[4].buf)[k] >= 0 && ((const int32_t *)v[4].buf)[k] < FC_TURN / 2;
    if (is_right) {
        const fc_pitch pitch = {(int32_t)samples, v[1].buf, v[2].buf, v[3].buf, v[4].buf};
        for (Py_ssize_t i = 0; i < v[0].len / 4 / samples; i++)
            fc_spectrum(&pitch, (const float *)v[0].buf + i * samples, work,
                        (float *)v[5].buf + i * FC_LINES);
    }
    release(v, held);
    if (!is_right)
        return refuse("the arrays of the spectrum do not fit together");
    Py_RETURN_NONE;
}

/* shifts(spectra, reference, shift, correlation): spectra (n, FC_LINES), the last two (n,) */
static PyObject *shifts(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    Py_buffer v[4];
    int held = 0;
    (void)self;
    if (!has(n, 4))
        return NULL;
    const bool is_right = array_get(args[0], v, F32, false) && ++held
                          && array_take(args[1], v + 1, FC_LINES, F32, false) && ++held
                          && array_take(args[2], v + 2, v[0].len / 4 / FC_LINES, I32, true) && ++held
                          && array_take(args[3], v + 3, v[0].len / 4 / FC_LINES, F32, true) && ++held;
    for (Py_ssize_t i = 0; is_right && i < v[0].len / 4 / FC_LINES; i++)
        fc_shift((const float *)v[0].buf + i * FC_LINES, v[1].buf, (int32_t *)v[2].buf + i,
                 (float *)v[3].buf + i);
    release(v, held);
    if (!is_right)
        return NULL;
    Py_RETURN_NONE;
}

/* fit_predictions(quiet, samples, out): quiet (n, samples), in sigmas. out (n, FC_ORDER + 1). */
static PyObject *fit_predictions(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    Py_buffer v[2];
    double error[FC_WINDOW_MOST];
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
        fc_fit_prediction((const double *)v[0].buf + i * samples, (int32_t)samples, error,
                          (double *)v[1].buf + i * (FC_ORDER + 1));
    release(v, 2);
    Py_RETURN_NONE;
}

/* look_features(looks, samples, weights, lengths, floor, out): looks (n, samples), in sigmas,
   weights (n, FC_ORDER + 1), lengths (FC_PARTS + 1,). out (n, 2 * FC_LEVELS). */
static PyObject *look_features(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    Py_buffer v[4];
    double power[FC_WINDOW_MOST];
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
                         (const double *)v[1].buf + i * (FC_ORDER + 1), power,
                         (double *)v[3].buf + i * 2 * FC_LEVELS);
    release(v, held);
    if (!is_right)
        return refuse("the arrays of the looks do not fit together");
    Py_RETURN_NONE;
}

#define FAST(f) (PyCFunction)(void (*)(void))(f)

static PyMethodDef METHODS[] = {
    {"image", make_image, METH_O, "Check and hold an image of a model."},
    {"chain", FAST(make_chain), METH_FASTCALL, "Return a chain."},
    {"take", FAST(take), METH_FASTCALL, "Process samples and return their events."},
    {"finish", finish, METH_O, "End the stream and return its events."},
    {"hint", FAST(hint), METH_FASTCALL, "Set closing speed and radius."},
    {"state", FAST(state), METH_FASTCALL, "Return the state of a chain."},
    {"predict", FAST(predict), METH_FASTCALL, "Predict from contacts."},
    {"inputs", FAST(inputs), METH_FASTCALL, "Write inputs and traits of contacts."},
    {"rig_inputs", FAST(rig_inputs), METH_FASTCALL, "Write inputs of contacts of known rigs."},
    {"network", FAST(network), METH_FASTCALL, "Predict from inputs."},
    {"fit_predictions", FAST(fit_predictions), METH_FASTCALL, "Write linear predictions."},
    {"look_features", FAST(look_features), METH_FASTCALL, "Write the features of looks."},
    {"spectra", FAST(spectra), METH_FASTCALL, "Write the spectra before contacts."},
    {"shifts", FAST(shifts), METH_FASTCALL, "Write the shifts of spectra."},
    {NULL, NULL, 0, NULL},
};

static struct PyModuleDef MODULE = {
    .m_base = PyModuleDef_HEAD_INIT,
    .m_name = "_compiled",
    .m_doc = "The chain: samples in, events out.",
    .m_size = 0,
    .m_methods = METHODS,
};

PyMODINIT_FUNC PyInit__compiled(void)
{
    return PyModuleDef_Init(&MODULE);
}
