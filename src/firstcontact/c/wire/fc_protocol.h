/* Frames of the wire protocol of docs/protocol.md, version 1, to and from bytes.

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". */
#ifndef FC_PROTOCOL_H
#define FC_PROTOCOL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "fc_cobs.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A macro, because the preprocessor turns it into text. */
#define FC_PROTOCOL_VERSION 1

enum {
    FC_FRAME_SAMPLES = 5,  /* most samples in a frame: 1 ms */
    FC_MARKER_BYTES = 200, /* longest text of a marker */
    FC_CHUNK_BYTES = 200,  /* most bytes of a model in a frame */
    FC_CONTACT_BYTES = 10,
    FC_ESTIMATE_BYTES = 28,
    FC_LATE_BYTES = 8,
    FC_HINT_BYTES = 12,
    FC_FRAME_HEAD = 5,     /* type and counter */
    FC_FRAME_CRC = 4
};

enum {
    FC_DESCRIPTOR = 0x01,
    FC_SAMPLES = 0x02,
    FC_MARKER = 0x03,
    FC_STOPPED = 0x04,
    FC_REFUSED = 0x05,
    FC_CONTACT = 0x06,
    FC_ESTIMATE = 0x07,
    FC_MODEL_STATE = 0x08,
    FC_LATE = 0x09,
    FC_WITHDRAWN = 0x0a,
    FC_HELLO = 0x81,
    FC_START = 0x82,
    FC_STOP = 0x83,
    FC_MARK = 0x84,
    FC_MODEL_BEGIN = 0x86,
    FC_MODEL_CHUNK = 0x87,
    FC_MODEL_END = 0x88,
    FC_HINT = 0x89
};

/* Flags of an estimate. The reason why there is none is in the bits from FC_REASON_SHIFT on. */
enum { FC_REFUSES = 1, FC_OUT_OF_RANGE = 2, FC_REASON_SHIFT = 4 };
/* States of a model transfer. */
enum { FC_MODEL_GOES_ON = 0, FC_MODEL_KEPT = 1, FC_MODEL_REFUSED = 2 };

/* Largest length of a frame on the line, for n bytes of payload and the final zero. */
#define FC_WIRE_MAX(n) (FC_COBS_MAX((n) + FC_FRAME_HEAD + FC_FRAME_CRC) + 1u)

/* Numbers, little-endian.
   to     out, (2) or (4)
   value  in
   from   in, (4) */
void fc_put_u16(uint8_t *to, uint16_t value);
void fc_put_u32(uint8_t *to, uint32_t value);
uint32_t fc_get_u32(const uint8_t *from);
float fc_get_float(const uint8_t *from);

/* Encode a frame. Return the number of bytes on the wire.
   type     in, such as FC_SAMPLES
   counter  in, number of the frame
   body     in, out: (FC_FRAME_HEAD + n + FC_FRAME_CRC). The payload is at body + FC_FRAME_HEAD. Type,
            counter and CRC are written around it.
   n        in, bytes of the payload
   wire     out, the stuffed frame with its zero, (FC_WIRE_MAX(n)), apart from `body` */
size_t fc_frame_encode(uint8_t type, uint32_t counter, uint8_t *body, size_t n, uint8_t *wire);

typedef struct {
    uint8_t type;
    uint32_t counter;
    const uint8_t *payload;
    size_t n;              /* bytes of the payload */
} fc_frame;

/* Decode a frame in place. Return 0, or -1 for a damaged frame.
   wire   in, out: the bytes before the final zero, (n), and then the payload
   n      in, bytes
   frame  out; it points into `wire`. Unchanged if the frame is damaged. */
int fc_frame_decode(uint8_t *wire, size_t n, fc_frame *frame);

/* Write a payload. Return its length, bytes.
   to           out, with room for the payload
   boot         in, number that differs after each start
   text         in, (n)
   n            in, bytes of the text; or samples in the frame, which the caller writes after this head
   first_sample, next_sample, sample  in, numbers of samples
   known        in, number of the last sample that decided about the contact
   overflow     in, samples dropped so far
   reason       in, text that ends with a zero
   finger       in, 0 for the index finger, 1 for the thumb
   first        in, true for the first contact of a closing
   state        in, of a model's transfer, such as FC_MODEL_KEPT
   of           in, type of the frame that this answers
   next         in, bytes: offset of the next chunk */
size_t fc_put_descriptor(uint8_t *to, uint32_t boot, const char *text, size_t n);
size_t fc_put_samples_head(uint8_t *to, uint32_t first_sample, uint32_t overflow, uint8_t n);
size_t fc_put_marker(uint8_t *to, uint32_t sample, const uint8_t *text, size_t n);
size_t fc_put_stopped(uint8_t *to, uint32_t next_sample, uint32_t overflow);
size_t fc_put_refused(uint8_t *to, const char *reason);
size_t fc_put_contact(uint8_t *to, uint32_t sample, uint32_t known, uint8_t finger, bool first);
size_t fc_put_model_state(uint8_t *to, uint8_t state, uint8_t of, uint32_t next,
                          const char *reason);

/* Estimate of the device. */
typedef struct {
    uint32_t contact, known; /* first sample of the contact, and last sample that the estimate uses */
    uint16_t samples;        /* number of samples after the contact that it uses */
    uint8_t finger, flags;   /* number of the finger; FC_REFUSES and the other flags */
    float value, low, high;  /* unit of the model's training, such as Shore A */
    uint32_t took;           /* computing time, ns; 0 if unknown */
} fc_wire_estimate;

/* Write a payload. Return its length, bytes.
   to        out, (FC_ESTIMATE_BYTES) or (FC_LATE_BYTES)
   estimate  in
   skipped   in, estimates skipped so far
   unheard   in, samples without prediction so far */
size_t fc_put_estimate(uint8_t *to, const fc_wire_estimate *estimate);
size_t fc_put_late(uint8_t *to, uint32_t skipped, uint32_t unheard);

#ifdef __cplusplus
}
#endif
#endif
