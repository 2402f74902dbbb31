/* Steps of convolutional networks. A vector holds all channels of the first sample, then all of
   the next: what a convolution sees of it lies side by side. */
#ifndef FC_LAYERS_H
#define FC_LAYERS_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* (asinh(x each) - mean) slope. */
typedef struct {
    int32_t size;
    double each, mean, slope;
} fc_compress;
void fc_compress_run(const fc_compress *s, const float *in, float *out);

/* weight: outputs x taps x inputs; zeros stand before the first sample and after the last. */
typedef struct {
    int32_t samples, inputs, outputs, taps, stride;
    const float *weight, *bias;
} fc_conv;
void fc_conv_run(const fc_conv *s, const float *in, float *out);

/* Each channel for itself; weight: taps x channels. */
typedef struct {
    int32_t samples, channels, taps, stride;
    const float *weight, *bias;
} fc_depthwise;
void fc_depthwise_run(const fc_depthwise *s, const float *in, float *out);

typedef struct {
    int32_t size;
} fc_silu;
void fc_silu_run(const fc_silu *s, const float *in, float *out);

/* Each channel times the logistic function of its number in by. */
typedef struct {
    int32_t samples, channels;
} fc_gate;
void fc_gate_run(const fc_gate *s, const float *in, const float *by, float *out);

typedef struct {
    int32_t size;
} fc_plus;
void fc_plus_run(const fc_plus *s, const float *in, const float *other, float *out);

/* Of each channel over the samples. */
typedef struct {
    int32_t samples, channels;
} fc_means;
void fc_means_run(const fc_means *s, const float *in, float *out);

#ifdef __cplusplus
}
#endif
#endif
