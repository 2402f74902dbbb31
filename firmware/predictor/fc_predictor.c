#include "fc_predictor.h"
#include "fc_predictor_model.h"

#include <math.h>
#include <string.h>

#include "fc_layout.h"
#include "fc_pace.h"

/* Send the counts of late estimates and missed samples if a stream begins or one has changed. */
static void send_late(fc_predictor *a, bool begins)
{
    uint8_t payload[FC_LATE_BYTES];
    const uint32_t skipped = a->skipped, unheard = a->device->unheard;
    const bool has_changed = skipped != a->sent_skipped || unheard != a->sent_unheard;
    if (!a->device->streaming || !(has_changed || begins))
        return;
    fc_device_queue(a->device, FC_LATE, payload, fc_put_late(payload, skipped, unheard));
    a->sent_skipped = skipped;
    a->sent_unheard = unheard;
}

static void send_contact(fc_predictor *a, const fc_event *e, uint8_t type)
{
    uint8_t payload[FC_CONTACT_BYTES];
    const size_t n = fc_put_contact(payload, (uint32_t)e->sample, (uint32_t)e->known,
                                    (uint8_t)e->channel, (e->flags & FC_IS_FIRST) != 0);
    fc_device_queue(a->device, type, payload, n);
}

static void send_estimate(fc_predictor *a, const fc_event *e)
{
    uint8_t payload[FC_ESTIMATE_BYTES];
    const fc_estimate *const s = &e->estimate;
    const bool has_none = e->kind == FC_NOT_ESTIMATED;
    fc_wire_estimate estimate = {
        (uint32_t)e->sample, (uint32_t)e->known, (uint16_t)e->samples, (uint8_t)e->channel, 0,
        s->value, s->low, s->high, a->is_timed ? a->board.clock() - a->then : 0};
    estimate.flags = (uint8_t)(has_none ? FC_REFUSES | e->reason << FC_REASON_SHIFT
                                    : s->is_out_of_range ? FC_OUT_OF_RANGE : 0);
    fc_device_queue(a->device, FC_ESTIMATE, payload, fc_put_estimate(payload, &estimate));
}

static void on_event(void *context, const fc_event *e)
{
    fc_predictor *const a = context;
    if (e->kind == FC_CONTACT_FOUND)
        send_contact(a, e, FC_CONTACT);
    else if (e->kind == FC_CONTACT_WITHDRAWN)
        send_contact(a, e, FC_WITHDRAWN);
    else if (e->kind == FC_NOT_ESTIMATED
             || (e->kind == FC_ESTIMATED && !(e->flags & FC_IS_FINAL))) /* that repeats an estimate */
        send_estimate(a, e);
    else if (e->kind == FC_SKIPPED)
        a->skipped++;
    else if (e->kind == FC_CLOSING_ENDED)
        send_late(a, false);
    if (a->board.event != NULL)
        a->board.event(e);
}

/* The chain calls this before it computes an estimate, or skips one because samples wait. */
static int32_t waiting(void *context)
{
    fc_predictor *const a = context;
    const uint32_t used = fc_ring_used(&a->device->own_samples);
    a->is_timed = used < FC_FRAME_SAMPLES && a->board.clock != NULL;
    if (a->is_timed)
        a->then = a->board.clock();
    return (int32_t)used;
}

static void take(fc_predictor *a, const fc_sample *s)
{
    fc_chain *const c = &a->chain;
    double vibration[FC_FINGERS], loads[FC_LOADS];
    /* The wire has 32 bits of a sample's number, the chain 64. */
    const uint32_t ahead = s->number - (uint32_t)c->next;
    const bool begins = !c->has_begun || (s->streamed && !a->streamed);
    if (begins || ahead != 0) {
        send_late(a, begins);
        fc_chain_restart(c, c->has_begun ? c->next + ahead : (int64_t)s->number, !begins);
    }
    a->streamed = s->streamed;
    for (int f = 0; f < FC_FINGERS; f++)
        vibration[f] = (s->value[f] - FC_PIEZO_OFFSET) * FC_PIEZO_SCALE;
    for (int k = 0; k < FC_LOADS; k++)
        loads[k] = (s->value[FC_FINGERS + k] - FC_FORCE_OFFSET) * FC_FORCE_SCALE;
    fc_chain_take(c, vibration, loads);
}

/* Return true if a text is one JSON object in printable ASCII. The descriptor contains it
   unchanged. */
static bool is_object(const char *text, size_t n)
{
    int32_t depth = 0;
    bool quoted = false, escaped = false;
    for (size_t k = 0; k < n; k++) {
        const char c = text[k];
        if (c < ' ' || c > '~')
            return false;
        if (quoted) {
            quoted = escaped || c != '"';
            escaped = !escaped && c == '\\';
        } else {
            quoted = c == '"';
            depth += (c == '{') - (c == '}');
        }
        if ((depth <= 0) != (k + 1 == n))
            return false;
    }
    return n > 0 && text[0] == '{' && depth == 0;
}

const char *fc_predictor_fits(const fc_image *image, fc_stream *stream)
{
    memset(stream, 0, sizeof *stream);
    stream->channels = FC_FINGERS;
    stream->taxels = FC_LOADS;
    stream->has_floors = true;
    for (int f = 0; f < FC_FINGERS; f++) {
        stream->finger[f] = f;
        stream->alpha[f] = 1.0; /* the device has smoothed */
        stream->floors[f] = image->floors[f];
        stream->has_floors &= image->floors[f] > 0.0;
    }
    if (image->rate != FC_RATE_HZ || image->model.kind == FC_MODEL_NONE
        || image->model.kind == FC_MODEL_PROGRAM)
        return "the model is for another sampling rate, or predicts nothing";
    if (image->detector->kind != FC_DETECTOR_LOGISTIC
        && image->detector->kind != FC_DETECTOR_THRESHOLD)
        return "the model's detector cannot run on a device";
    if (!is_object(image->text, image->text_bytes))
        return "the text of the model is no JSON object";
    return fc_chain_bytes(image, stream) <= FC_MEMORY
               ? NULL : "the model needs more memory than the device has";
}

void fc_predictor_start(fc_predictor *a)
{
    const fc_program program = {.context = a, .emit = on_event, .waiting = waiting};
    fc_stream stream;
    (void)fc_predictor_fits(&a->image, &stream);
    fc_chain_init(&a->chain, &a->image, &stream, &program, a->memory);
}

void fc_predictor_init(fc_predictor *a, fc_device *device, const fc_memory *memory,
                     const fc_board *board)
{
    memset(a, 0, sizeof *a);
    a->device = device;
    a->board = *board;
    a->receiver.own = a;
    a->receiver.receive = fc_predictor_receive;
    a->receiver.hint = fc_predictor_take_hint;
    device->receiver = &a->receiver;
    fc_store_open(&a->store, memory);
    (void)fc_predictor_load(a);
}

void fc_predictor_work(fc_predictor *a)
{
    fc_ring *const ring = &a->device->own_samples;
    while (fc_ring_used(ring) > 0) {
        const fc_sample s = *fc_ring_peek(ring, 0);
        fc_ring_drop(ring, 1);
        a->is_timed = false;
        if (a->ready)
            take(a, &s);
    }
}

bool fc_predictor_hint(fc_predictor *a, double speed, double error, double radius)
{
    const fc_hints hints = {speed, error, radius};
    if (!(speed >= 0.0 && speed <= 100.0 && error >= 0.0 && error <= 1e9)
        || !(isnan(radius) || radius >= 1e-6))
        return false;
    if (a->ready)
        fc_chain_hint(&a->chain, &hints);
    return true;
}
