#include "fc_protocol.h"

#include <string.h>

#include "fc_crc32.h"

void fc_put_u16(uint8_t *to, uint16_t value)
{
    to[0] = (uint8_t)value;
    to[1] = (uint8_t)(value >> 8);
}

void fc_put_u32(uint8_t *to, uint32_t value)
{
    fc_put_u16(to, (uint16_t)value);
    fc_put_u16(to + 2, (uint16_t)(value >> 16));
}

uint32_t fc_get_u32(const uint8_t *from)
{
    return (uint32_t)from[0] | (uint32_t)from[1] << 8 | (uint32_t)from[2] << 16
           | (uint32_t)from[3] << 24;
}

float fc_get_float(const uint8_t *from)
{
    const uint32_t bits = fc_get_u32(from);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

size_t fc_frame_encode(uint8_t type, uint32_t counter, uint8_t *body, size_t n, uint8_t *wire)
{
    const size_t end = FC_FRAME_HEAD + n;
    body[0] = type;
    fc_put_u32(body + 1, counter);
    fc_put_u32(body + end, fc_crc32(body, end));
    const size_t stuffed = fc_cobs_stuff(body, end + FC_FRAME_CRC, wire);
    wire[stuffed] = 0;
    return stuffed + 1;
}

int fc_frame_decode(uint8_t *wire, size_t n, fc_frame *frame)
{
    const ptrdiff_t length = fc_cobs_unstuff(wire, n, wire);
    if (length < FC_FRAME_HEAD + FC_FRAME_CRC)
        return -1;
    const size_t end = (size_t)length - FC_FRAME_CRC;
    if (fc_get_u32(wire + end) != fc_crc32(wire, end))
        return -1;
    frame->type = wire[0];
    frame->counter = fc_get_u32(wire + 1);
    frame->payload = wire + FC_FRAME_HEAD;
    frame->n = end - FC_FRAME_HEAD;
    return 0;
}

size_t fc_put_descriptor(uint8_t *to, uint32_t boot, const char *text, size_t n)
{
    to[0] = FC_PROTOCOL_VERSION;
    fc_put_u32(to + 1, boot);
    memcpy(to + 5, text, n);
    return 5 + n;
}

size_t fc_put_samples_head(uint8_t *to, uint32_t first_sample, uint32_t overflow, uint8_t n)
{
    fc_put_u32(to, first_sample);
    fc_put_u32(to + 4, overflow);
    to[8] = n;
    return 9;
}

size_t fc_put_marker(uint8_t *to, uint32_t sample, const uint8_t *text, size_t n)
{
    fc_put_u32(to, sample);
    memcpy(to + 4, text, n);
    return 4 + n;
}

size_t fc_put_stopped(uint8_t *to, uint32_t next_sample, uint32_t overflow)
{
    fc_put_u32(to, next_sample);
    fc_put_u32(to + 4, overflow);
    return 8;
}

size_t fc_put_refused(uint8_t *to, const char *reason)
{
    const size_t n = strlen(reason);
    to[0] = FC_PROTOCOL_VERSION;
    memcpy(to + 1, reason, n);
    return 1 + n;
}

size_t fc_put_contact(uint8_t *to, uint32_t sample, uint32_t known, uint8_t finger, bool first)
{
    fc_put_u32(to, sample);
    fc_put_u32(to + 4, known);
    to[8] = finger;
    to[9] = first;
    return FC_CONTACT_BYTES;
}

static void put_float(uint8_t *to, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    fc_put_u32(to, bits);
}

size_t fc_put_estimate(uint8_t *to, const fc_wire_estimate *estimate)
{
    fc_put_u32(to, estimate->contact);
    fc_put_u32(to + 4, estimate->known);
    fc_put_u16(to + 8, estimate->samples);
    to[10] = estimate->finger;
    to[11] = estimate->flags;
    put_float(to + 12, estimate->value);
    put_float(to + 16, estimate->low);
    put_float(to + 20, estimate->high);
    fc_put_u32(to + 24, estimate->took);
    return FC_ESTIMATE_BYTES;
}

size_t fc_put_late(uint8_t *to, uint32_t skipped, uint32_t unheard)
{
    fc_put_u32(to, skipped);
    fc_put_u32(to + 4, unheard);
    return FC_LATE_BYTES;
}

size_t fc_put_model_state(uint8_t *to, uint8_t state, uint8_t of, uint32_t next,
                          const char *reason)
{
    const size_t n = strlen(reason);
    to[0] = state;
    to[1] = of;
    fc_put_u32(to + 2, next);
    memcpy(to + 6, reason, n);
    return 6 + n;
}
