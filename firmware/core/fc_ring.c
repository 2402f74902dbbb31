#include "fc_ring.h"

#include "fc_lock.h"

void fc_ring_init(fc_ring *r, fc_sample *slots, uint32_t size)
{
    r->slots = slots;
    r->size = size;
    r->head = 0;
    r->tail = 0;
}

uint32_t fc_ring_used(const fc_ring *r)
{
    const uint32_t head = r->head;
    const uint32_t tail = r->tail;
    return head >= tail ? head - tail : head + r->size - tail;
}

bool fc_ring_put(fc_ring *r, const fc_sample *sample)
{
    const uint32_t head = r->head;
    const uint32_t next = head + 1 == r->size ? 0 : head + 1;
    if (next == r->tail)
        return false;
    r->slots[head] = *sample;
    FC_BARRIER(); /* write the sample before the reader can see it */
    r->head = next;
    return true;
}

const fc_sample *fc_ring_peek(const fc_ring *r, uint32_t k)
{
    const uint32_t place = r->tail + k;
    FC_BARRIER();
    return &r->slots[place < r->size ? place : place - r->size];
}

void fc_ring_drop(fc_ring *r, uint32_t n)
{
    const uint32_t place = r->tail + n;
    FC_BARRIER(); /* read the samples before the writer can overwrite them */
    r->tail = place < r->size ? place : place - r->size;
}
