/* The wire protocol of docs/protocol.md, version 1: frames from and to bytes, nothing sent. */
#ifndef FC_PROTOCOL_H
#define FC_PROTOCOL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "fc_cobs.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A macro, so that the preprocessor can put it into words. */
#define FC_PROTOCOL_VERSION 1

enum {
    FC_FRAME_SAMPLES = 5,  /* most samples of a frame: 1 ms */
    FC_MARKER_BYTES = 200, /* longest text of a marker */
    FC_CHUNK_BYTES = 200,  /* most of a model in a frame */
    FC_CONTACT_BYTES = 10,
    FC_ESTIMATE_BYTES = 28,
    FC_LATE_BYTES = 8,
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
    FC_HELLO = 0x81,
    FC_START = 0x82,
    FC_STOP = 0x83,
    FC_MARK = 0x84,
    FC_MODEL_BEGIN = 0x86,
    FC_MODEL_CHUNK = 0x87,
    FC_MODEL_END = 0x88
};

/* Flags of an estimate. */
enum { FC_REFUSES = 1, FC_STRANGE = 2 };
/* What a model's state says. */
enum { FC_MODEL_GOES_ON = 0, FC_MODEL_KEPT = 1, FC_MODEL_REFUSED = 2 };

/* Bytes of a frame with a payload of n on the line, with the zero that ends it, at most. */
#define FC_WIRE_MAX(n) (FC_COBS_MAX((n) + FC_FRAME_HEAD + FC_FRAME_CRC) + 1u)

void fc_put_u16(uint8_t *to, uint16_t value);
void fc_put_u32(uint8_t *to, uint32_t value);
uint32_t fc_get_u32(const uint8_t *from);

/* A frame whose payload of n bytes stands at body + FC_FRAME_HEAD: writes type, counter and
   CRC around it, where body has room for them, and the stuffed frame with its zero into
   wire, which has room for FC_WIRE_MAX(n). Returns the bytes on the wire. */
size_t fc_frame_encode(uint8_t type, uint32_t counter, uint8_t *body, size_t n, uint8_t *wire);

typedef struct {
    uint8_t type;
    uint32_t counter;
    const uint8_t *payload;
    size_t n;
} fc_frame;

/* Takes a frame apart in place, given what stood before its zero. Returns 0, or -1 where it
   is damaged. The payload lies in wire. */
int fc_frame_decode(uint8_t *wire, size_t n, fc_frame *frame);

/* Payloads; each returns its bytes. */
size_t fc_put_descriptor(uint8_t *to, uint32_t boot, const char *text, size_t n);
size_t fc_put_samples_head(uint8_t *to, uint32_t first_sample, uint32_t overflow, uint8_t n);
size_t fc_put_marker(uint8_t *to, uint32_t sample, const uint8_t *text, size_t n);
size_t fc_put_stopped(uint8_t *to, uint32_t next_sample, uint32_t overflow);
size_t fc_put_refused(uint8_t *to, const char *reason);
size_t fc_put_contact(uint8_t *to, uint32_t sample, uint32_t known, uint8_t finger, bool first);
size_t fc_put_model_state(uint8_t *to, uint8_t state, uint8_t of, uint32_t next,
                          const char *reason);

/* What an answer of the device says: of which contact, from how many samples after it, known with
   which sample; Shore A; and the time that it took, ns, 0 where nothing measures it. */
typedef struct {
    uint32_t contact, known;
    uint16_t samples;
    uint8_t finger, flags;
    float value, low, high;
    uint32_t took;
} fc_told;
size_t fc_put_estimate(uint8_t *to, const fc_told *told);
size_t fc_put_late(uint8_t *to, uint32_t skipped, uint32_t unheard);

#ifdef __cplusplus
}
#endif
#endif
