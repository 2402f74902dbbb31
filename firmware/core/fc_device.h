/* A fingertip pair: raw readings in on one side, frames out on the other.

   fc_device_sample may run in a timer's interrupt; everything else belongs to the main loop.
   Nothing here waits: when the line is slow, samples wait in the ring; when the ring is full,
   they are dropped and counted. */
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
    FC_DESCRIPTOR_MAX = 2600, /* longest descriptor, what it says of models in it */
    FC_PAYLOAD_MAX = FC_DESCRIPTOR_MAX + 5,
    FC_HEARD_MAX = 256,       /* longer than any frame of the host, stuffed */
    FC_TELLINGS = 64          /* contacts and estimates that wait for the line, at most */
};

/* One scan: both piezos, the taxel of each array whose turn it is, both strips (0 or 1). */
typedef struct {
    uint16_t piezo[FC_FINGERS];
    uint16_t force[FC_FINGERS];
    uint8_t strip[FC_FINGERS];
} fc_raw;

/* A contact or an estimate on its way. */
typedef struct {
    uint8_t type, n;
    uint8_t payload[FC_ESTIMATE_BYTES];
} fc_telling;

/* What takes a model that comes over the line. Gives what is answered: a state, how many bytes
   there are, and the reason where it is refused. */
typedef struct {
    void *own;
    uint8_t (*hear)(void *own, const fc_frame *frame, uint32_t *next, const char **why);
} fc_model_taker;

typedef struct {
    /* Written by the side that samples. */
    fc_smooth piezo[FC_FINGERS];
    fc_means force[FC_FINGERS];
    fc_scan scan;
    volatile uint32_t next; /* number of the sample that comes next */
    volatile uint32_t overflow;
    volatile uint32_t unheard; /* samples that found no room in listeners, since the start */
    fc_ring ring;
    fc_ring listeners; /* for who answers on the device itself; of size 0 where nobody does */
    /* Written by the side that talks. */
    volatile bool streaming;
    const char *descriptor;
    const char *answers; /* JSON about the model that answers, NULL where there is none */
    size_t answers_bytes;
    const char *models; /* JSON about the models that are taken, NULL where none are */
    size_t models_bytes;
    const fc_model_taker *taker; /* NULL where no model can be taken */
    fc_telling telling[FC_TELLINGS];
    uint32_t tellings, told; /* put and sent so far */
    uint32_t boot;
    uint32_t counter;
    uint8_t reply; /* type of the frame that the host is owed, 0 for none */
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

/* descriptor: JSON of at most FC_DESCRIPTOR_MAX bytes, which stays; boot: another number
   after each start; slots: room for size - 1 samples. */
void fc_device_init(fc_device *d, const char *descriptor, uint32_t boot, fc_sample *slots,
                    uint32_t size);

/* Has all samples put into slots, too, sent or not, for who answers on the device itself. */
void fc_device_listen(fc_device *d, fc_sample *slots, uint32_t size);

/* A contact or an estimate goes out, before samples that wait; nothing where nobody asked for
   samples. One too many is left out. */
void fc_device_tell(fc_device *d, uint8_t type, const uint8_t *payload, size_t n);

/* This many samples could not be taken: their numbers are left out, so that numbers go on telling
   time. Only where no sample can come in between. */
void fc_device_skip(fc_device *d, uint32_t n);

/* Takes one scan, whose force readings are of the taxel d->scan; moves d->scan on. */
void fc_device_sample(fc_device *d, const fc_raw *raw);

/* Whether bytes of the host may be given now. While it is owed a reply they have to wait. */
bool fc_device_listens(const fc_device *d);

/* Takes one byte of the host. */
void fc_device_hear(fc_device *d, uint8_t byte);

/* What is to be sent next, n bytes; n is 0 when there is nothing. */
const uint8_t *fc_device_outgoing(fc_device *d, size_t *n);

/* Says that the first n of them were sent. */
void fc_device_sent(fc_device *d, size_t n);

#ifdef __cplusplus
}
#endif
#endif
