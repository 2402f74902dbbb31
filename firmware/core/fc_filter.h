/* Filters of the readings. They use integers, so that the host can compute the same bits. Values
   are in 1/32 of an ADC count.

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". */
#ifndef FC_FILTER_H
#define FC_FILTER_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
    FC_ADC_COUNTS = 1024, /* 10 bits */
    FC_SUBCOUNTS = 32,
    FC_TAXELS = 6,        /* taxels of one finger's array, 3 rows of 2 */
    FC_COLUMNS = 2,
    FC_READINGS = 8       /* readings of a taxel in its sliding mean */
};

/* Exponential smoothing with alpha 1/2, rounded down. */
typedef struct {
    int32_t y; /* below 0 before the first sample, where the smoothing starts */
} fc_smooth;

/* Start again.
   s  out */
void fc_smooth_init(fc_smooth *s);

/* Return the smoothed reading, 1/32 counts.
   s      in, out
   count  in, counts; larger ones than FC_ADC_COUNTS - 1 are clipped */
int16_t fc_smooth_step(fc_smooth *s, uint16_t count);

/* Sliding means of one array. One taxel is read per sample, row by row, while the other rows are at
   ground. A column's taxels then share its divider: the more its other taxels conduct, the less a
   reading is. The means are corrected for that. */
typedef struct {
    uint16_t reading[FC_TAXELS][FC_READINGS];
    uint16_t sum[FC_TAXELS];
    uint8_t oldest; /* index of the reading that is replaced next */
    bool read[FC_TAXELS]; /* true once the taxel was read */
} fc_means;

/* Start again. A taxel's mean is 0 before its first reading, which then also fills the seven before
   it.
   m  out */
void fc_means_init(fc_means *m);

/* Take the reading of one taxel. Compute for all six what each would read alone in its column.
   m      in, out
   taxel  in, from 0 to FC_TAXELS - 1
   count  in, counts; larger ones than FC_ADC_COUNTS - 1 are clipped
   out    out, 1/32 counts */
void fc_means_step(fc_means *m, uint8_t taxel, uint16_t count, int16_t out[FC_TAXELS]);

#ifdef __cplusplus
}
#endif
#endif
