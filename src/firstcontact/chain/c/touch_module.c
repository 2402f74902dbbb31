/* Inputs and predictions of contacts that are known already, and the pitch of the motor. */
#include "extension.h"

#include <math.h>
#include <string.h>

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
    if (held == NULL || held->image.model.kind != FC_MODEL_NETWORK)
        return refuse("the image has no model"), NULL;
    const fc_model *const m = &held->image.model;
    if (!take_rows(r, args[1], args[2], m->sizes->before) || !take_row_array(r, args[3], 1, I32, false)
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
        fc_touch_take(t, signal[m->sizes->before + k]);
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
        if (is_regression && touch.rig->counts->pinches > 0) {
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
    if (of == NULL || of->image.model.kind != FC_MODEL_NETWORK)
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
    const fc_rig_counts counts = {.finger = -1, .has_level = 1};
    fc_rig_scales scales = {0};
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
    const fc_model_sizes sizes = {.before = (int32_t)before, .rigs = 1};
    const fc_model model = {.sizes = &sizes, .rig = {{.counts = &counts, .scales = &scales}}};
    for (Py_ssize_t i = 0; i < r.n; i++) {
        const float *const signal = signal_of(&r, i);
        scales.level = value_of(&r, 2, i);
        scales.sign = value_of(&r, 3, i);
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

/* Return the image of a capsule if its model has SVMs, and memory for the first one's prediction. */
static const fc_svm *take_svm(PyObject *capsule, float **room)
{
    const held_image *const held = PyCapsule_GetPointer(capsule, IMAGE);
    if (held == NULL || held->image.model.kind != FC_MODEL_SVM)
        return refuse("the image has no SVM"), NULL;
    *room = PyMem_Malloc(fc_svm_room(held->image.model.svm) * sizeof **room);
    return *room == NULL ? (PyErr_NoMemory(), NULL) : held->image.model.svm;
}

/* svm(image, signal, lead): predict from a signal (n,), float64, with `lead` samples before the
   contact. Return value, low and high; or None if the signal cannot be used. */
static PyObject *svm(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    Py_buffer view;
    float *room;
    fc_svm_estimate out;
    (void)self;
    const long lead = has(n, 3) ? PyLong_AsLong(args[2]) : -1;
    const fc_svm *const m = PyErr_Occurred() ? NULL : take_svm(args[0], &room);
    if (m == NULL)
        return NULL;
    if (!array_get(args[1], &view, F64, false)) {
        PyMem_Free(room);
        return NULL;
    }
    const Py_ssize_t samples = view.len / 8;
    const fc_past past = {view.buf, FC_CAPACITY_MOST, 1, 0, samples};
    const bool fits = lead >= 0 && samples <= past.capacity
                      && samples - lead >= m->samples + FC_SVM_LOOKAHEAD;
    const int32_t reason = fits ? fc_svm_predict(m, &past, 0, lead, room, &out) : FC_NO_SIGNAL;
    PyBuffer_Release(&view);
    PyMem_Free(room);
    if (reason != FC_DONE)
        Py_RETURN_NONE;
    return Py_BuildValue("ddd", out.value, out.low, out.high);
}

/* svm_outputs(image, windows, out)

   windows (n, samples), float32, which vary. out (n, outputs), float32: see fc_svm_outputs; NaN for
   outputs that are not finite. */
static PyObject *svm_outputs(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    Py_buffer v[2];
    float *room;
    int held = 0;
    (void)self;
    if (!has(n, 3))
        return NULL;
    const fc_svm *const m = take_svm(args[0], &room);
    if (m == NULL)
        return NULL;
    const int32_t classes = m->numbers->class_count, each = classes > 0 ? classes : 1;
    const bool is_right
        = array_get(args[1], v, F32, false) && ++held
          && array_take(args[2], v + 1, v[0].len / 4 / m->samples * each, F32, true) && ++held;
    for (Py_ssize_t i = 0; is_right && i < v[0].len / 4 / m->samples; i++) {
        float *const out = (float *)v[1].buf + i * each;
        memcpy(room, (const float *)v[0].buf + i * m->samples, (size_t)m->samples * sizeof *room);
        const float *const outputs = fc_svm_outputs(m, room);
        for (int32_t k = 0; k < each; k++)
            out[k] = outputs == NULL ? NAN : outputs[k];
    }
    release(v, held);
    PyMem_Free(room);
    if (!is_right)
        return NULL;
    Py_RETURN_NONE;
}

/* constants(): numbers of fc_touch.h and fc_gate.h by name. */
static PyObject *constants(PyObject *self, PyObject *none)
{
    (void)self;
    (void)none;
    return Py_BuildValue("{sdsdsdsdsdsdsd}", "believed", FC_BELIEVED, "tip", FC_TIP, "largest", FC_LARGEST,
                         "length", FC_LENGTH, "linear", FC_LINEAR, "noise", FC_NOISE,
                         "running", FC_RUNNING);
}

PyMethodDef TOUCH_FUNCTIONS[] = {
    {"constants", constants, METH_NOARGS, "Return the numbers that the training reads, too."},
    {"svm", FAST(svm), METH_FASTCALL, "Predict from a signal with an SVM."},
    {"svm_outputs", FAST(svm_outputs), METH_FASTCALL, "Write the outputs of an SVM."},
    {"predict", FAST(predict), METH_FASTCALL, "Predict from contacts."},
    {"inputs", FAST(inputs), METH_FASTCALL, "Write inputs and traits of contacts."},
    {"rig_inputs", FAST(rig_inputs), METH_FASTCALL, "Write inputs of contacts of known rigs."},
    {"network", FAST(network), METH_FASTCALL, "Predict from inputs."},
    {"spectra", FAST(spectra), METH_FASTCALL, "Write the spectra before contacts."},
    {"shifts", FAST(shifts), METH_FASTCALL, "Write the shifts of spectra."},
    {NULL, NULL, 0, NULL},
};
