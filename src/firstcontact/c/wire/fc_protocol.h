/* Frames of the wire protocol of docs/protocol.md, version 1, to and from bytes. */
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

void fc_put_u16(uint8_t *to, uint16_t value);
void fc_put_u32(uint8_t *to, uint32_t value);
uint32_t fc_get_u32(const uint8_t *from);
float fc_get_float(const uint8_t *from);

/* Encode a frame whose payload of n bytes is at body + FC_FRAME_HEAD. Write type, counter and CRC
   around it, where body has room for them. Write the stuffed frame with its zero into wire, which
   has room for FC_WIRE_MAX(n). Return the number of bytes on the wire. */
size_t fc_frame_encode(uint8_t type, uint32_t counter, uint8_t *body, size_t n, uint8_t *wire);

typedef struct {
    uint8_t type;
    uint32_t counter;
    const uint8_t *payload;
    size_t n;
} fc_frame;

/* Decode a frame in place. wire holds the bytes before the final zero, and later the payload.
   Return 0, or -1 for a damaged frame. */
int fc_frame_decode(uint8_t *wire, size_t n, fc_frame *frame);

/* Write a payload and return its length. */
size_t fc_put_descriptor(uint8_t *to, uint32_t boot, const char *text, size_t n);
size_t fc_put_samples_head(uint8_t *to, uint32_t first_sample, uint32_t overflow, uint8_t n);
size_t fc_put_marker(uint8_t *to, uint32_t sample, const uint8_t *text, size_t n);
size_t fc_put_stopped(uint8_t *to, uint32_t next_sample, uint32_t overflow);
size_t fc_put_refused(uint8_t *to, const char *reason);
size_t fc_put_contact(uint8_t *to, uint32_t sample, uint32_t known, uint8_t finger, bool first);
size_t fc_put_model_state(uint8_t *to, uint8_t state, uint8_t of, uint32_t next,
                          const char *reason);

/* Estimate of the device: its contact, the number of samples after it, and the sample with which
   the estimate was complete. Values are in Shore A. took is the computing time, ns, 0 if
   unknown. */
typedef struct {
    uint32_t contact, known;
    uint16_t samples;
    uint8_t finger, flags;
    float value, low, high;
    uint32_t took;
} fc_wire_estimate;
size_t fc_put_estimate(uint8_t *to, const fc_wire_estimate *estimate);
size_t fc_put_late(uint8_t *to, uint32_t skipped, uint32_t unheard);

#ifdef __cplusplus
}
#endif
#endif
