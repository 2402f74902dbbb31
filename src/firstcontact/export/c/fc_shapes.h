/* Steps that describe a window's shape. */
#ifndef FC_SHAPES_H
#define FC_SHAPES_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Over the largest magnitude. */
typedef struct {
    int32_t size;
} fc_over_peak;
void fc_over_peak_run(const fc_over_peak *s, const float *in, float *out);

/* Squared magnitudes: in holds the real parts of all lines, then the imaginary ones. */
typedef struct {
    int32_t lines;
} fc_powers;
void fc_powers_run(const fc_powers *s, const float *in, float *out);

/* ln(share of the sum + floor), less the mean of these. */
typedef struct {
    int32_t size;
    double floor;
} fc_level_free;
void fc_level_free_run(const fc_level_free *s, const float *in, float *out);

/* When each share of a channel's energy has come, turns of its sign, roughness, when its peak is. */
typedef struct {
    int32_t samples, channels, channel, quantiles;
    const double *quantile;
} fc_course;
void fc_course_run(const fc_course *s, const float *in, float *out);

/* MiniRocket: of 84 kernels at each dilation the share of the window, over its RMS, above each bias;
   last the logarithm of the RMS. */
typedef struct {
    int32_t samples, channels, dilations, each;
    const int32_t *dilation;
    const float *bias; /* dilations x 84 x each */
} fc_shares_above;
void fc_shares_above_run(const fc_shares_above *s, const float *in, float *out);

#ifdef __cplusplus
}
#endif
#endif
