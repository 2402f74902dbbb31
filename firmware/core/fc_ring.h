/* Ring buffer of samples between the timer's interrupt (writer) and the main loop (reader).

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". */
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

/* Set up an empty ring, before the interrupt runs.
   r      out
   slots  out, room for size - 1 samples, which must outlive the ring, (size)
   size   in, at least 2 */
void fc_ring_init(fc_ring *r, fc_sample *slots, uint32_t size);

/* Return the number of waiting samples, for the reader.
   r  in */
uint32_t fc_ring_used(const fc_ring *r);

/* Store a sample, for the writer. Return false if the ring is full.
   r       in, out
   sample  in, copied */
bool fc_ring_put(fc_ring *r, const fc_sample *sample);

/* Return a waiting sample, for the reader.
   r  in
   k  in, position in the queue, below fc_ring_used */
const fc_sample *fc_ring_peek(const fc_ring *r, uint32_t k);

/* Drop the first samples, for the reader.
   r  in, out
   n  in, samples, at most fc_ring_used */
void fc_ring_drop(fc_ring *r, uint32_t n);

#ifdef __cplusplus
}
#endif
#endif
