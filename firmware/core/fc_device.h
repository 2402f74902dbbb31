/* Device with two fingertips: it takes raw readings and gives frames.

   fc_device_sample may run in a timer's interrupt. Call everything else from the main loop. No
   function waits: samples wait in the ring while the line is slow, and are dropped and counted
   when the ring is full. */
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
    FC_DESCRIPTOR_MAX = 2600, /* longest descriptor, its fields about models included */
    FC_PAYLOAD_MAX = FC_DESCRIPTOR_MAX + 5,
    FC_HEARD_MAX = 256,       /* longer than any stuffed frame of the host */
    FC_TELLINGS = 64          /* most contacts and estimates that wait for the line */
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
} fc_telling;

/* Receiver of what the device's own predictions need. hear takes a frame about a model. It returns the
   state to reply, and gives the number of bytes received and the reason for a refusal. */
typedef struct {
    void *own;
    uint8_t (*hear)(void *own, const fc_frame *frame, uint32_t *next, const char **why);
    void (*hint)(void *own, const fc_frame *frame);
} fc_taker;

typedef struct {
    /* Written by fc_device_sample. */
    fc_smooth piezo[FC_FINGERS];
    fc_means force[FC_FINGERS];
    fc_scan scan;
    volatile uint32_t next; /* number of the next sample */
    volatile uint32_t overflow;
    volatile uint32_t unheard; /* samples without room in listeners, since the start */
    fc_ring ring;
    fc_ring listeners; /* samples for the device's own predictions; size 0 without these */
    /* Written by the main loop. */
    volatile bool streaming;
    const char *descriptor;
    const char *answers; /* JSON about the model that predicts, NULL without one */
    size_t answers_bytes;
    const char *models; /* JSON about the models that the device accepts, NULL without room */
    size_t models_bytes;
    const fc_taker *taker; /* NULL if the device accepts no model */
    fc_telling telling[FC_TELLINGS];
    uint32_t tellings, told; /* queued and sent so far */
    uint32_t boot;
    uint32_t counter;
    uint8_t reply; /* type of the reply that is due, 0 for none */
    uint32_t reply_sample;
    uint32_t reply_overflow;
    uint8_t reply_state, reply_of;
    const char *reply_why;
    uint8_t text[FC_MARKER_BYTES];
    size_t text_bytes;
    uint8_t heard[FC_HEARD_MAX];
    size_t heard_bytes; /* FC_HEARD_MAX + 1 once a frame is longer than that */
    uint8_t body[FC_FRAME_HEAD + FC_PAYLOAD_MAX + FC_FRAME_CRC];
    uint8_t wire[FC_WIRE_MAX(FC_PAYLOAD_MAX)];
    size_t wire_bytes;
    size_t wire_sent;
} fc_device;

/* descriptor: JSON of at most FC_DESCRIPTOR_MAX bytes; the caller keeps it. boot: a number that
   differs after each start. slots: room for size - 1 samples. */
void fc_device_init(fc_device *d, const char *descriptor, uint32_t boot, fc_sample *slots,
                    uint32_t size);

/* Copy all samples into slots, whether sent or not, for the device's own predictions. */
void fc_device_listen(fc_device *d, fc_sample *slots, uint32_t size);

/* Queue a contact or an estimate, which is sent before waiting samples. Do nothing while the device
   does not stream, or when the queue is full. */
void fc_device_tell(fc_device *d, uint8_t type, const uint8_t *payload, size_t n);

/* Skip the numbers of n samples that were not taken, so that numbers still follow time. Call it only
   while no sample can be taken. */
void fc_device_skip(fc_device *d, uint32_t n);

/* Take one scan, whose force readings are of the taxel d->scan, and advance d->scan. */
void fc_device_sample(fc_device *d, const fc_raw *raw);

/* Return true if the device can take bytes of the host. It cannot while a reply is due. */
bool fc_device_listens(const fc_device *d);

/* Take one byte of the host. */
void fc_device_hear(fc_device *d, uint8_t byte);

/* Return the bytes to send next and their number n, which is 0 if there are none. */
const uint8_t *fc_device_outgoing(fc_device *d, size_t *n);

/* Note that the first n of these bytes were sent. */
void fc_device_sent(fc_device *d, size_t n);

#ifdef __cplusplus
}
#endif
#endif
