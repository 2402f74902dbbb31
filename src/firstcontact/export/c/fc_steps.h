/* Steps of trained models: each makes one vector of floats from others, without memory of its
   own. What was trained is in the constants; those are generated, this is not.

   Arithmetic is plain IEEE and in a stated order, fused nowhere but where fmaf is written: every
   machine gives the same bits. */
#ifndef FC_STEPS_H
#define FC_STEPS_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The window over its RMS, then how loud it was: samples + 1 numbers. That is NaN where the sum of
   squares is not between least and most: the host, which sums in single precision, holds no more. */
typedef struct {
    int32_t samples;
    double mean, slope, least, most;
} fc_shape_and_level;
void fc_shape_and_level_run(const fc_shape_and_level *s, const float *in, float *out);

/* exp(-gamma |x - v|^2) of each vector: steep is 2 gamma v, norms is -gamma |v|^2. */
typedef struct {
    int32_t vectors, inputs;
    double gamma;
    const float *steep, *norms;
} fc_rbf;
void fc_rbf_run(const fc_rbf *s, const float *in, float *out);

/* weight x + bias, row by row. */
typedef struct {
    int32_t outputs, inputs;
    const float *weight, *bias;
} fc_dense;
void fc_dense_run(const fc_dense *s, const float *in, float *out);

/* How many pairs each class wins, the first of a pair with more than least: so much is what fc_exp
   takes for 0 never worth. Pairs are (0, 1), (0, 2), ... (1, 2), ... */
typedef struct {
    int32_t classes;
    double least;
} fc_votes;
void fc_votes_run(const fc_votes *s, const float *in, float *out);

typedef struct {
    int32_t outputs;
    const float *values;
} fc_given;
void fc_given_run(const fc_given *s, const float *in, float *out);

typedef struct {
    int32_t samples;
} fc_log_peak;
void fc_log_peak_run(const fc_log_peak *s, const float *in, float *out);

typedef struct {
    double a, b, c, low, high;
} fc_parabola;
void fc_parabola_run(const fc_parabola *s, const float *in, float *out);

typedef struct {
    int32_t outputs;
    const float *places;
} fc_nearness;
void fc_nearness_run(const fc_nearness *s, const float *in, float *out);

/* scale sqrt(max(most - |L x|^2, least)); lower holds the rows of L up to the diagonal. */
typedef struct {
    int32_t inputs;
    const float *lower;
    double most, least, scale;
} fc_deviation;
void fc_deviation_run(const fc_deviation *s, const float *in, float *out);

#ifdef __cplusplus
}
#endif
#endif
