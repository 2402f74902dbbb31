/* Ring buffer of samples between the timer's interrupt (writer) and the main loop (reader). */
#ifndef FC_RING_H
#define FC_RING_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { FC_FINGERS = 2, FC_WIDTH = 16 };

typedef struct {
    uint32_t number;
    uint32_t overflow; /* samples dropped before this one, since the device's start */
    int16_t value[FC_WIDTH];
    bool streamed; /* true if the sample is also sent to the host */
} fc_sample;

typedef struct {
    fc_sample *slots;
    uint32_t size; /* one slot stays empty, to tell a full ring from an empty one */
    volatile uint32_t head;
    volatile uint32_t tail;
} fc_ring;

void fc_ring_init(fc_ring *r, fc_sample *slots, uint32_t size);
uint32_t fc_ring_used(const fc_ring *r);

/* For the writer. Return false if the ring is full. */
bool fc_ring_put(fc_ring *r, const fc_sample *sample);

/* For the reader: return the k-th waiting sample, for k below fc_ring_used, and drop the first n
   samples. */
const fc_sample *fc_ring_peek(const fc_ring *r, uint32_t k);
void fc_ring_drop(fc_ring *r, uint32_t n);

#ifdef __cplusplus
}
#endif
#endif
