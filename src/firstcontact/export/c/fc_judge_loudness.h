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

/* Steps that are remembered, and those that lie whole in the quiet part of a look: of x, and of
   what of it was not foretold, which begins FC_ORDER samples later. */
enum {
    FC_RECENT = FC_LOOK - FC_QUIET,
    FC_AFTER_QUIET = (FC_RECENT + FC_STEP - 1) / FC_STEP,
    FC_STEPS = FC_STEP > 1 ? FC_RING / 2 : FC_RING,
    FC_QUIET_STEPS = FC_LOOK / FC_STEP - FC_AFTER_QUIET,
    FC_FRESH_STEPS = (FC_LOOK - FC_ORDER) / FC_STEP - FC_AFTER_QUIET,
    /* Steps of the steady state that the first window's looks hold, with the sample before them; and
       those that have as many samples before them as are foretold from. */
    FC_RECALLED = FC_LOOK / FC_STEP + FC_LOOKS - 1,
    FC_FORETOLD = (FC_WINDOW - FC_ORDER) / FC_STEP
};

/* Largest of the last so many values: from place at on, of each to the end of those of the round
   before; before it, those of this round. */
typedef struct {
    double since; /* largest of this round */
    int32_t at;
    double value[FC_QUIET_STEPS + 1]; /* the last is of none */
} fc_peak;

typedef struct {
    double high, low, loud; /* of x, and of the square of what was not foretold */
} fc_extremes;

/* Sums up to and including a sample: of x, of x^2, and of what of x was not foretold, squared; and
   that square itself. */
typedef struct {
    double sum, square, left, fresh;
} fc_grown;

typedef struct {
    uint32_t step, barred; /* no window is a contact before step barred: a look said no */
    double base, blur; /* a score by coarse logarithms begins here, and is so far off at most */
    double share[FC_PARTS + 1]; /* one over the lengths of the newest parts, and of what lies between */
    /* From [1] on, of the steady state: sums of products of samples so far apart. */
    double lag[FC_ORDER + 1];
    double weight[FC_ORDER + 1];
    struct {
        fc_extremes quiet;
        double score; /* infinite until it was asked for */
    } look[FC_LOOKS];                /* the newest at step % FC_LOOKS */
    fc_grown grown[FC_RING];
    fc_peak high, low, loud;            /* of the quiet part; low of -x */
    fc_extremes extremes[2 * FC_STEPS]; /* of step n at n % FC_STEPS and again FC_STEPS behind */
} fc_judge;

/* Sample n of a steady state has come in. */
void fc_judge_hear(fc_judge *j, const double *steady, uint32_t n);

/* The steady state is complete: its mean, and the sum of squares around it. */
void fc_judge_settle(fc_judge *j, const double *steady, double mean, double spread);

/* Steps of the steady state's end, for the first windows; end: one after it, in its sigmas. */
void fc_judge_recall(fc_judge *j, const double *end);

/* A step of samples more: end is one after the newest, count their number. */
void fc_judge_step(fc_judge *j, const double *end, uint32_t count);
bool fc_judge_fires(fc_judge *j, const double *end, uint32_t count);

static inline bool fc_judge_wakes(double size)
{
    return size > fc_judge_constants.awake;
}

#ifdef __cplusplus
}
#endif

#endif
