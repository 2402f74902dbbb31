/* Which taxel of both arrays is read in which sample: one a sample, row by row. */
#ifndef FC_SCAN_H
#define FC_SCAN_H

#include <stdint.h>

#include "fc_filter.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Counts taxels rather than taking the sample number modulo 6: that number wraps at 2^32,
   which 6 does not divide. */
typedef struct {
    uint8_t taxel; /* of the sample that comes next */
} fc_scan;

void fc_scan_init(fc_scan *s);
void fc_scan_next(fc_scan *s);

/* The row to drive and the column to read for it. */
uint8_t fc_scan_row(const fc_scan *s);
uint8_t fc_scan_column(const fc_scan *s);

#ifdef __cplusplus
}
#endif
#endif
