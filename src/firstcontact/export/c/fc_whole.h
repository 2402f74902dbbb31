/* Layers whose weights are whole numbers times a scale for each row.

   What comes in is rounded to 15 bits and a sign; sums are of whole numbers and have the same bits
   everywhere. The magnitudes of a row add up to less than 2^16: no sum overflows. */
#ifndef FC_WHOLE_H
#define FC_WHOLE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    int32_t outputs, inputs; /* columns: inputs, rounded up to a multiple of four */
    const int16_t *weight;
    const float *scale, *bias;
} fc_whole;

/* Rounds n numbers; gives the unit of what comes out. Room for a multiple of four. */
float fc_round(const float *x, int32_t n, int16_t *rounded);

/* scale * (weight x) + bias, x in units; bias is the layer's own where it is NULL. */
void fc_whole_run(const fc_whole *s, const int16_t *rounded, float unit, const float *bias,
                  float *out);

#ifdef __cplusplus
}
#endif
#endif
