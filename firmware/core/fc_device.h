/* Device with two fingertips, which turns raw readings into frames.

   Call fc_device_sample from a timer's interrupt or the main loop, and all other functions from
   the main loop. No function blocks. While the line is slow, samples wait in a ring. If the ring
   is full, samples are dropped and counted.

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". */
#ifndef FC_DEVICE_H
#define FC_DEVICE_H

#include "fc_filter.h"
#include "fc_protocol.h"
#include "fc_ring.h"
#include "fc_scan.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    FC_DESCRIPTOR_MAX = 2600, /* longest descriptor, with its fields about models */
    FC_PAYLOAD_MAX = FC_DESCRIPTOR_MAX + 5,
    FC_RECEIVED_MAX = 256,       /* room for a stuffed frame of the host */
    FC_NOTICES = 64          /* largest number of contacts and estimates that wait for the line */
};

/* One scan: both piezos, one taxel of each array in turn, both strips (0 or 1). */
typedef struct {
    uint16_t piezo[FC_FINGERS];
    uint16_t force[FC_FINGERS];
    uint8_t strip[FC_FINGERS];
} fc_raw;

/* Contact or estimate that waits for the line. */
typedef struct {
    uint8_t type, n;
    uint8_t payload[FC_ESTIMATE_BYTES];
} fc_notice;

/* Receiver of models and hints for the device's own predictions. */
typedef struct {
    void *own;                   /* passed to both functions, or NULL */
    /* Handle a frame about a model. Return the state for the reply.
       own    in, as above
       frame  in
       next   out, bytes received so far
       why    out, reason of a refusal, which ends with a zero */
    uint8_t (*receive)(void *own, const fc_frame *frame, uint32_t *next, const char **why);
    /* Handle a frame with a hint.
       own    in, as above
       frame  in */
    void (*hint)(void *own, const fc_frame *frame);
} fc_receiver;

typedef struct {
    /* Written by fc_device_sample. */
    fc_smooth piezo[FC_FINGERS];
    fc_means force[FC_FINGERS];
    fc_scan scan;
    volatile uint32_t next; /* number of the next sample */
    volatile uint32_t overflow;
    volatile uint32_t unheard; /* samples without room in own_samples, since the start */
    fc_ring ring;
    fc_ring own_samples; /* samples for the device's own predictions; size 0 without them */
    /* Written by the main loop. */
    volatile bool streaming;
    const char *descriptor;
    const char *active_model; /* JSON about the active model; NULL without one */
    size_t active_model_bytes;
    const char *models; /* JSON about accepted models; NULL if the device accepts none */
    size_t models_bytes;
    const fc_receiver *receiver; /* NULL if the device accepts no model */
    fc_notice notice[FC_NOTICES];
    uint32_t notices, notices_sent; /* queued and sent so far */
    uint32_t boot;
    uint32_t counter;
    uint8_t reply; /* type of the reply that is due, 0 for none */
    uint32_t reply_sample;
    uint32_t reply_overflow;
    uint8_t reply_state, reply_of;
    const char *reply_why;
    uint8_t text[FC_MARKER_BYTES];
    size_t text_bytes;
    uint8_t received[FC_RECEIVED_MAX];
    size_t received_bytes; /* FC_RECEIVED_MAX + 1 once a frame is longer than that */
    uint8_t body[FC_FRAME_HEAD + FC_PAYLOAD_MAX + FC_FRAME_CRC];
    uint8_t wire[FC_WIRE_MAX(FC_PAYLOAD_MAX)];
    size_t wire_bytes;
    size_t wire_sent;
} fc_device;

/* Set up a device.
   d           out
   descriptor  in, JSON of at most FC_DESCRIPTOR_MAX bytes, which must outlive the device
   boot        in, number that differs after each start
   slots       out, room for size - 1 samples, which must outlive the device, (size)
   size        in, at least 2 */
void fc_device_init(fc_device *d, const char *descriptor, uint32_t boot, fc_sample *slots,
                    uint32_t size);

/* Also copy all samples, for the device's own predictions.
   d      in, out
   slots  out, room for size - 1 samples, which must outlive the device, (size)
   size   in, at least 2 */
void fc_device_copy_samples(fc_device *d, fc_sample *slots, uint32_t size);

/* Queue a contact or an estimate, to be sent before waiting samples. Drop it if the device does not
   stream, or if the queue is full.
   d        in, out
   type     in, type of the frame
   payload  in, (n)
   n        in, bytes, at most FC_ESTIMATE_BYTES */
void fc_device_queue(fc_device *d, uint8_t type, const uint8_t *payload, size_t n);

/* Skip the numbers of missing samples, so that sample numbers still follow time. Call this only while
   the interrupt is off.
   d  in, out
   n  in, samples */
void fc_device_skip(fc_device *d, uint32_t n);

/* Process one scan. Its force readings are those of taxel d->scan. Advance d->scan.
   d    in, out
   raw  in, counts of the converter */
void fc_device_sample(fc_device *d, const fc_raw *raw);

/* Return true if the device can receive bytes. It cannot while a reply is due.
   d  in */
bool fc_device_can_receive(const fc_device *d);

/* Process one byte from the host.
   d     in, out
   byte  in */
void fc_device_receive(fc_device *d, uint8_t byte);

/* Return the bytes to send next.
   d  in, out
   n  out, bytes; 0 if there is nothing to send */
const uint8_t *fc_device_outgoing(fc_device *d, size_t *n);

/* Remove the first of these bytes, which were sent.
   d  in, out
   n  in, bytes */
void fc_device_sent(fc_device *d, size_t n);

#ifdef __cplusplus
}
#endif
#endif
