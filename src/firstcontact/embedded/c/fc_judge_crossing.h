/* A contact is a sample far from the steady mean in the newest step. */
#ifndef FC_JUDGE_CROSSING_H
#define FC_JUDGE_CROSSING_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "fc_detector_sizes.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    double sigmas;
} fc_crossing;
extern const fc_crossing fc_judge_constants;

typedef struct {
    uint8_t nothing;
} fc_judge;

static inline void fc_judge_settle(fc_judge *j, const double *quiet)
{
    (void)j, (void)quiet;
}

static inline void fc_judge_take(fc_judge *j, const double *past, uint32_t n)
{
    (void)j, (void)past, (void)n;
}

static inline void fc_judge_step(fc_judge *j)
{
    (void)j;
}

static inline bool fc_judge_wakes(double size)
{
    return size > fc_judge_constants.sigmas;
}

static inline bool fc_judge_fires(fc_judge *j, const double *past, uint32_t end)
{
    (void)j;
    for (uint32_t k = 1; k <= FC_STEP; k++)
        if (fabs(past[(end - k) % FC_RING]) > fc_judge_constants.sigmas)
            return true;
    return false;
}

#ifdef __cplusplus
}
#endif

#endif
