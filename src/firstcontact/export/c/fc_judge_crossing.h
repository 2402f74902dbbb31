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
    return size > fc_judge_constants.sigmas;
}

static inline bool fc_judge_fires(fc_judge *j, const double *end, uint32_t count)
{
    (void)j, (void)count;
    for (const double *x = end - FC_STEP; x < end; x++)
        if (fabs(*x) > fc_judge_constants.sigmas)
            return true;
    return false;
}

#ifdef __cplusplus
}
#endif

#endif
