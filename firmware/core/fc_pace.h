/* When to sample: whole ticks of a timer whose mean rate is exact.

   4936 Hz is no whole number of ticks of 600, 25 or 24 MHz. What a period leaves over is
   added up, and a period is one tick longer whenever it makes a whole one: any rate_hz
   periods in a row last one second, to the tick. */
#ifndef FC_PACE_H
#define FC_PACE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { FC_RATE_HZ = 4936 };

typedef struct {
    uint32_t whole; /* ticks of a short period */
    uint32_t rest;  /* left over each time, in 1/rate of a tick */
    uint32_t rate;
    uint32_t sum;
} fc_pace;

/* clock_hz is at least rate_hz, and rate_hz below 2^31. */
void fc_pace_init(fc_pace *p, uint32_t clock_hz, uint32_t rate_hz);

/* Ticks of the period that comes next. */
uint32_t fc_pace_next(fc_pace *p);

#ifdef __cplusplus
}
#endif
#endif
