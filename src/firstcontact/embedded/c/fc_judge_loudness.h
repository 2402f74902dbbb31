/* A contact is where several looks in a row find the newest samples louder than those before.

   Nothing is computed twice: sums grow sample by sample, and a look takes their differences. */
#ifndef FC_JUDGE_LOUDNESS_H
#define FC_JUDGE_LOUDNESS_H

#include <stdbool.h>
#include <stdint.h>

#include "fc_detector_sizes.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Sizes of looks are those of the detector, generated beside the line. */
enum { FC_ORDER = 12, FC_PARTS = 5, FC_LEVELS = FC_PARTS + 4 };

typedef struct {
    double awake, floor, ridge, bias;
    double doubt;                   /* a score by rough logarithms is this far off at most */
    int32_t recent;                 /* samples at a look's end that are not quiet any more */
    const int32_t *lengths;         /* FC_PARTS of the newest parts, ascending */
    const double *line;             /* of the logarithms of 2 * FC_LEVELS levels */
} fc_loudness;
#ifdef fc_judge_constants /* those of a model that was loaded */
extern const fc_loudness *fc_judge_loaded;
#else
extern const fc_loudness fc_judge_constants;
#endif

/* Largest of the last n values: those before the current block from its end, and since then. */
typedef struct {
    double value[FC_QUIET], suffix[FC_QUIET], prefix, top;
    int32_t at;
} fc_peak;

typedef struct {
    double weight[FC_ORDER + 1];
    /* Sums up to and including each sample: of x, of x^2, and of what of x was not foretold, squared. */
    double sum[FC_RING], square[FC_RING], left[FC_RING], new_square[FC_RING];
    fc_peak high, low, loud; /* of the quiet part: x, -x, and the last squared */
    struct {
        double high, low, loud;
        double score; /* infinite until it was asked for */
    } look[FC_LOOKS]; /* the newest at step % FC_LOOKS */
    uint32_t step;
} fc_judge;

void fc_judge_settle(fc_judge *j, const double *quiet);
void fc_judge_take(fc_judge *j, const double *past, uint32_t n);
void fc_judge_step(fc_judge *j);
bool fc_judge_fires(fc_judge *j, const double *past, uint32_t end);

static inline bool fc_judge_wakes(double size)
{
    return size > fc_judge_constants.awake;
}

#ifdef __cplusplus
}
#endif

#endif
