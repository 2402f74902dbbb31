/* A contact is where a machine of radial basis functions says so of a window's features. */
#ifndef FC_JUDGE_KERNEL_H
#define FC_JUDGE_KERNEL_H

#include <stdbool.h>
#include <stdint.h>

#include "fc_detector_sizes.h"

#ifdef __cplusplus
extern "C" {
#endif

/* FC_STEP is that of the detector, generated beside what was learned. */
enum { FC_SPANS = 3, FC_COARSE = 5, FC_SEEN = FC_STEP + FC_COARSE + 6 * FC_SPANS + 2 };

typedef struct {
    double floor, gamma, bias;    /* bias: less the threshold */
    int32_t vectors;
    const int32_t *span, *coarse; /* where parts of a window begin, and the end of the last */
    const double *mean, *slope;   /* of each feature: mean, and one over the deviation */
    const float *steep, *norms, *weight; /* of the vectors, as of fc_rbf; and of each vector */
} fc_kernel;
extern const fc_kernel fc_judge_constants;

typedef struct {
    uint8_t nothing;
} fc_judge;

bool fc_judge_fires(fc_judge *j, const double *end, uint32_t count);

static inline void fc_judge_hear(fc_judge *j, const double *steady, uint32_t n)
{
    (void)j, (void)steady, (void)n;
}

static inline void fc_judge_settle(fc_judge *j, const double *steady, double mean, double spread)
{
    (void)j, (void)steady, (void)mean, (void)spread;
}

static inline void fc_judge_recall(fc_judge *j, const double *end)
{
    (void)j, (void)end;
}

static inline void fc_judge_step(fc_judge *j, const double *end, uint32_t count)
{
    (void)j, (void)end, (void)count;
}

static inline bool fc_judge_wakes(double size)
{
    (void)size;
    return true;
}

#ifdef __cplusplus
}
#endif

#endif
