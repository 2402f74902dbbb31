/* Sampling periods in whole timer ticks with an exact mean rate.

   A period of 4936 Hz is not a whole number of ticks at 600, 25 or 24 MHz. The remainders add up,
   and a period is one tick longer whenever they reach a whole tick. Any rate_hz periods in a row
   last one second, exact to the tick.

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". */
#ifndef FC_PACE_H
#define FC_PACE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The same number stands in FINGERTIP_RATE (core/layout.py) and in RATE (twin/c/fingertips.c). */
enum { FC_RATE_HZ = 4936 };

typedef struct {
    uint32_t whole; /* ticks of a short period */
    uint32_t rest;  /* remainder of a period, in 1/rate of a tick */
    uint32_t rate;
    uint32_t sum;
} fc_pace;

/* Start.
   p         out
   clock_hz  in, Hz, at least rate_hz
   rate_hz   in, Hz, from 1 to 2^31 - 1 */
void fc_pace_init(fc_pace *p, uint32_t clock_hz, uint32_t rate_hz);

/* Return the length of the next period, ticks.
   p  in, out */
uint32_t fc_pace_next(fc_pace *p);

#ifdef __cplusplus
}
#endif
#endif
