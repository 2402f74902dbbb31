/* Run the chain over streams. Input: the length of an image and its bytes; then, for each stream, its
   head and its pieces; for each piece its head and its samples. Output: the events of each stream, and
   a record of the kind 0 with the instructions of its samples. */
#include "machine.h"

#include <string.h>

#include "fc_chain.h"

/* Instructions per second: 600 MHz, 1.5 cycles each. */
static const double SPEED = 600e6 / 1.5;

enum { IMAGE_MOST = 1 << 18, MEMORY = 1 << 16, TAXELS_MOST = 12 };

typedef struct {
    int32_t pieces, channels, taxels, has_floors;
    double floors[2], alpha;
    fc_hints hints;           /* set with each first contact */
} head;

typedef struct {
    int64_t first;            /* number of the first sample */
    int32_t samples;
    int32_t begins_epoch;
} piece;

typedef struct {
    int32_t kind, reason, flags, channel;
    int64_t sample, known;
    int32_t samples;
    float value, low, high, half_width, spread;
    uint32_t instructions;    /* since the chain took the sample */
    uint32_t waited;          /* instructions of earlier samples that were left when it arrived */
} record;

static uint64_t bytes[IMAGE_MOST / 8], memory[MEMORY / 8];
static fc_image image;
static fc_chain chain;
static head stream;
static uint32_t then, told;   /* instructions of this sample: begin, and spent here */
static uint32_t left;         /* instructions of earlier samples that are left */

static void on_event(void *context, const fc_event *e)
{
    record r;
    const uint32_t took = machine_since(then), before = machine_clock();
    (void)context;
    memset(&r, 0, sizeof r);
    r.kind = e->kind;
    r.reason = e->reason;
    r.flags = e->flags;
    r.channel = e->channel;
    r.sample = e->sample;
    r.known = e->known;
    r.samples = e->samples;
    r.value = e->estimate.value;
    r.low = e->estimate.low;
    r.high = e->estimate.high;
    r.half_width = e->estimate.half_width;
    r.spread = e->estimate.spread;
    r.instructions = took - told;
    r.waited = left;
    machine_write(&r, sizeof r);
    if (e->kind == FC_CONTACT_FOUND && (e->flags & FC_IS_FIRST))
        fc_chain_hint(&chain, &stream.hints);
    told += machine_since(before);
}

/* Run a piece. Add to the count of instructions. */
static int run(const piece *p, record *total)
{
    float values[2 + TAXELS_MOST];
    double volts[2 + TAXELS_MOST];
    const int32_t columns = stream.channels + stream.taxels;
    const uint32_t between = (uint32_t)(SPEED / image.rate);
    if (!chain.has_begun || p->begins_epoch || p->first != chain.next)
        fc_chain_restart(&chain, p->first, !p->begins_epoch);
    for (int32_t i = 0; i < p->samples; i++) {
        if (machine_read(values, sizeof *values * (size_t)columns) == 0)
            return 0;
        for (int32_t k = 0; k < columns; k++)
            volts[k] = values[k];
        told = 0;
        then = machine_clock();
        fc_chain_take(&chain, volts, volts + stream.channels);
        const uint32_t took = machine_since(then) - told;
        total->samples++;
        total->sample += took;
        if (took > total->known)
            total->known = took;
        left = left + took > between ? left + took - between : 0;
    }
    return 1;
}

int main(int argc, char **argv)
{
    const fc_program program = {.emit = on_event};
    uint32_t n;
    if (!machine_begin(argc, argv) || machine_read(&n, sizeof n) != sizeof n || n > sizeof bytes
        || machine_read(bytes, n) != n
        || fc_image_read((const uint8_t *)bytes, n, &image) != NULL)
        return 2;
    while (machine_read(&stream, sizeof stream) == sizeof stream) {
        fc_stream channels = {.channels = stream.channels, .taxels = stream.taxels};
        record total;
        memset(&total, 0, sizeof total);
        channels.has_floors = stream.has_floors != 0;
        for (int32_t k = 0; k < stream.channels; k++) {
            channels.finger[k] = k;
            channels.alpha[k] = stream.alpha;
            channels.floors[k] = stream.floors[k];
        }
        if (fc_chain_bytes(&image, &channels) > sizeof memory)
            return 3;
        fc_chain_init(&chain, &image, &channels, &program, memory);
        for (int32_t k = 0; k < stream.pieces; k++) {
            piece p;
            if (machine_read(&p, sizeof p) != sizeof p || !run(&p, &total))
                return 4;
        }
        then = machine_clock();
        told = left = 0;
        fc_chain_finish(&chain);
        machine_write(&total, sizeof total);
    }
    machine_end();
    return 0;
}
