/* Order in which the taxels of both arrays are read: one per sample, row by row.

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". */
#ifndef FC_SCAN_H
#define FC_SCAN_H

#include <stdint.h>

#include "fc_filter.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Counter of taxels. The sample number modulo 6 does not work, because it wraps at 2^32, which is
   not a multiple of 6. */
typedef struct {
    uint8_t taxel; /* taxel of the next sample */
} fc_scan;

/* Start with taxel 0.
   s  out */
void fc_scan_init(fc_scan *s);

/* Go to the next taxel.
   s  in, out */
void fc_scan_next(fc_scan *s);

/* Return the row to drive and the column to read for this taxel, from 0.
   s  in */
uint8_t fc_scan_row(const fc_scan *s);
uint8_t fc_scan_column(const fc_scan *s);

#ifdef __cplusplus
}
#endif
#endif
