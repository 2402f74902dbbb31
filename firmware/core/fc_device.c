#include "fc_device.h"

#include <string.h>

#include "fc_lock.h"

void fc_device_init(fc_device *d, const char *descriptor, uint32_t boot, fc_sample *slots,
                    uint32_t size)
{
    memset(d, 0, sizeof *d);
    for (int f = 0; f < FC_FINGERS; f++) {
        fc_smooth_init(&d->piezo[f]);
        fc_means_init(&d->force[f]);
    }
    fc_scan_init(&d->scan);
    fc_ring_init(&d->ring, slots, size);
    d->descriptor = descriptor;
    d->boot = boot;
}

void fc_device_copy_samples(fc_device *d, fc_sample *slots, uint32_t size)
{
    fc_ring_init(&d->own_samples, slots, size);
}

void fc_device_queue(fc_device *d, uint8_t type, const uint8_t *payload, size_t n)
{
    if (!d->streaming || n > FC_ESTIMATE_BYTES || d->notices - d->notices_sent == FC_NOTICES)
        return;
    fc_notice *const t = &d->notice[d->notices++ % FC_NOTICES];
    t->type = type;
    t->n = (uint8_t)n;
    memcpy(t->payload, payload, n);
}

void fc_device_sample(fc_device *d, const fc_raw *raw)
{
    fc_sample s;
    int16_t *const force = s.value + FC_FINGERS;
    int16_t *const strip = force + FC_FINGERS * FC_TAXELS;
    for (int f = 0; f < FC_FINGERS; f++) {
        s.value[f] = fc_smooth_step(&d->piezo[f], raw->piezo[f]);
        fc_means_step(&d->force[f], d->scan.taxel, raw->force[f], force + f * FC_TAXELS);
        strip[f] = raw->strip[f] != 0;
    }
    s.number = d->next;
    s.overflow = d->overflow;
    s.streamed = d->streaming;
    if (d->own_samples.size > 0 && !fc_ring_put(&d->own_samples, &s))
        d->unheard++;
    if (s.streamed && !fc_ring_put(&d->ring, &s))
        d->overflow++;
    d->next++;
    fc_scan_next(&d->scan);
}

void fc_device_skip(fc_device *d, uint32_t n)
{
    d->next += n;
    for (n %= FC_TAXELS; n > 0; n--)
        fc_scan_next(&d->scan);
}

bool fc_device_can_receive(const fc_device *d)
{
    return d->reply == 0;
}

static void hello(fc_device *d, const fc_frame *frame)
{
    if (frame->n >= 1)
        d->reply = frame->payload[0] == FC_PROTOCOL_VERSION ? FC_DESCRIPTOR : FC_REFUSED;
}

static void stop(fc_device *d)
{
    FC_LOCK();
    d->streaming = false;
    d->reply_sample = d->next;
    d->reply_overflow = d->overflow;
    FC_UNLOCK();
    d->reply = FC_STOPPED;
}

static void mark(fc_device *d, const fc_frame *frame)
{
    if (frame->n > FC_MARKER_BYTES)
        return;
    memcpy(d->text, frame->payload, frame->n);
    d->text_bytes = frame->n;
    d->reply_sample = d->next;
    d->reply = FC_MARKER;
}

static void take_model(fc_device *d, const fc_frame *frame)
{
    if (d->receiver == NULL)
        return;
    d->reply_of = frame->type;
    d->reply_why = "";
    d->reply_sample = 0;
    if (d->streaming) {
        d->reply_state = FC_MODEL_REFUSED;
        d->reply_why = "samples are being sent: stop them first";
    } else {
        d->reply_state =
            d->receiver->receive(d->receiver->own, frame, &d->reply_sample, &d->reply_why);
    }
    d->reply = FC_MODEL_STATE;
}

static void obey(fc_device *d, const fc_frame *frame)
{
    switch (frame->type) {
    case FC_HELLO:
        hello(d, frame);
        break;
    case FC_START:
        d->streaming = true;
        break;
    case FC_STOP:
        stop(d);
        break;
    case FC_MARK:
        mark(d, frame);
        break;
    case FC_MODEL_BEGIN:
    case FC_MODEL_CHUNK:
    case FC_MODEL_END:
        take_model(d, frame);
        break;
    case FC_HINT:
        if (d->receiver != NULL)
            d->receiver->hint(d->receiver->own, frame);
        break;
    default: /* a frame of a later version */
        break;
    }
}

void fc_device_receive(fc_device *d, uint8_t byte)
{
    fc_frame frame;
    if (byte != 0) {
        if (d->received_bytes < FC_RECEIVED_MAX)
            d->received[d->received_bytes++] = byte;
        else
            d->received_bytes = FC_RECEIVED_MAX + 1;
        return;
    }
    if (d->received_bytes <= FC_RECEIVED_MAX
        && fc_frame_decode(d->received, d->received_bytes, &frame) == 0)
        obey(d, &frame);
    d->received_bytes = 0;
}

/* Return the number of samples for the next frame: five in a row, fewer before a gap, and all that
   remain before a stop. Return 0 if there are too few for a frame. */
static uint32_t in_a_row(const fc_device *d)
{
    const uint32_t used = fc_ring_used(&d->ring);
    uint32_t n = 0;
    while (n < used && n < FC_FRAME_SAMPLES
           && fc_ring_peek(&d->ring, n)->number == fc_ring_peek(&d->ring, 0)->number + n)
        n++;
    return n == FC_FRAME_SAMPLES || n < used || d->reply == FC_STOPPED ? n : 0;
}

static size_t put_samples(fc_device *d, uint8_t *payload, uint32_t n)
{
    const fc_sample *first = fc_ring_peek(&d->ring, 0);
    size_t w = fc_put_samples_head(payload, first->number, first->overflow, (uint8_t)n);
    for (uint32_t k = 0; k < n; k++) {
        const fc_sample *s = fc_ring_peek(&d->ring, k);
        for (int c = 0; c < FC_WIDTH; c++, w += 2)
            fc_put_u16(payload + w, (uint16_t)s->value[c]);
    }
    fc_ring_drop(&d->ring, n);
    return w;
}

#define IN_WORDS(x) IN_WORDS_(x)
#define IN_WORDS_(x) #x
#define REFUSAL "this firmware speaks version " IN_WORDS(FC_PROTOCOL_VERSION) " of the protocol"

/* Append a field to the descriptor if it fits. Return the new length. */
static size_t put_field(uint8_t *payload, size_t w, const char *name, const char *json, size_t n)
{
    const size_t named = strlen(name);
    if (json == NULL || w + named + n > FC_PAYLOAD_MAX)
        return w;
    w--; /* the closing brace */
    memcpy(payload + w, name, named);
    memcpy(payload + w + named, json, n);
    w += named + n;
    payload[w++] = '}';
    return w;
}

/* Write the descriptor with its fields about models. */
static size_t put_descriptor(fc_device *d, uint8_t *payload)
{
    const size_t n = strlen(d->descriptor);
    size_t w = fc_put_descriptor(payload, d->boot, d->descriptor, n);
    w = put_field(payload, w, ",\"answers\":", d->active_model, d->active_model_bytes);
    return put_field(payload, w, ",\"models\":", d->models, d->models_bytes);
}

static size_t put_reply(fc_device *d, uint8_t *payload)
{
    switch (d->reply) {
    case FC_DESCRIPTOR:
        return put_descriptor(d, payload);
    case FC_REFUSED:
        return fc_put_refused(payload, REFUSAL);
    case FC_MARKER:
        return fc_put_marker(payload, d->reply_sample, d->text, d->text_bytes);
    case FC_MODEL_STATE:
        return fc_put_model_state(payload, d->reply_state, d->reply_of, d->reply_sample,
                                  d->reply_why);
    default:
        return fc_put_stopped(payload, d->reply_sample, d->reply_overflow);
    }
}

/* Make the next frame. Return false if there is none. */
static bool next_frame(fc_device *d)
{
    uint8_t *const payload = d->body + FC_FRAME_HEAD;
    const bool replies_now = d->reply != 0 && d->reply != FC_STOPPED;
    const bool sends_notice = !replies_now && d->notices_sent != d->notices;
    const uint32_t samples = replies_now || sends_notice ? 0 : in_a_row(d);
    uint8_t type = FC_SAMPLES;
    size_t n;
    if (sends_notice) {
        const fc_notice *const t = &d->notice[d->notices_sent++ % FC_NOTICES];
        type = t->type;
        n = t->n;
        memcpy(payload, t->payload, n);
    } else if (samples > 0) {
        n = put_samples(d, payload, samples);
    } else if (d->reply != 0) { /* the reply to a stop follows the last samples */
        type = d->reply;
        n = put_reply(d, payload);
        d->reply = 0;
    } else {
        return false;
    }
    d->wire_bytes = fc_frame_encode(type, d->counter++, d->body, n, d->wire);
    d->wire_sent = 0;
    return true;
}

const uint8_t *fc_device_outgoing(fc_device *d, size_t *n)
{
    if (d->wire_sent == d->wire_bytes && !next_frame(d)) {
        *n = 0;
        return d->wire;
    }
    *n = d->wire_bytes - d->wire_sent;
    return d->wire + d->wire_sent;
}

void fc_device_sent(fc_device *d, size_t n)
{
    d->wire_sent += n;
}
