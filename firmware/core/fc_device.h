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
    FC_DESCRIPTOR_MAX = 2400, /* longest descriptor */
    FC_PAYLOAD_MAX = FC_DESCRIPTOR_MAX + 5,
    FC_HEARD_MAX = 256        /* longer than any frame of the host, stuffed */
};

/* One scan: both piezos, the taxel of each array whose turn it is, both strips (0 or 1). */
typedef struct {
    uint16_t piezo[FC_FINGERS];
    uint16_t force[FC_FINGERS];
    uint8_t strip[FC_FINGERS];
} fc_raw;

typedef struct {
    /* Written by the side that samples. */
    fc_smooth piezo[FC_FINGERS];
    fc_means force[FC_FINGERS];
    fc_scan scan;
    volatile uint32_t next; /* number of the sample that comes next */
    volatile uint32_t overflow;
    fc_ring ring;
    /* Written by the side that talks. */
    volatile bool streaming;
    const char *descriptor;
    uint32_t boot;
    uint32_t counter;
    uint8_t reply; /* type of the frame that the host is owed, 0 for none */
    uint32_t reply_sample;
    uint32_t reply_overflow;
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
