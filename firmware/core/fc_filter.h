/* What is done to readings before they are sent: integers throughout, so that the host can
   compute the same bits. Values are in 1/32 of an ADC count. */
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
    FC_TAXELS = 6,        /* of one finger's array, 3 rows of 2 */
    FC_COLUMNS = 2,
    FC_READINGS = 8       /* of each taxel, under the sliding mean */
};

/* Exponential smoothing with alpha 1/2, rounding down. */
typedef struct {
    int32_t y; /* below 0 before the first sample, which it then starts from */
} fc_smooth;

void fc_smooth_init(fc_smooth *s);
int16_t fc_smooth_step(fc_smooth *s, uint16_t count);

/* Sliding means of one array, which is read one taxel a sample, row by row. */
typedef struct {
    uint16_t reading[FC_TAXELS][FC_READINGS];
    uint16_t sum[FC_TAXELS];
    uint8_t oldest; /* which reading of each taxel is replaced next */
    bool read[FC_TAXELS]; /* whether a taxel was read at all */
} fc_means;

/* A taxel's first reading stands in for the seven before it; until then its mean is 0. */
void fc_means_init(fc_means *m);

/* Takes the reading of one taxel and gives all six means. */
void fc_means_step(fc_means *m, uint8_t taxel, uint16_t count, int16_t out[FC_TAXELS]);

#ifdef __cplusplus
}
#endif
#endif
