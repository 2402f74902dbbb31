/* How stiff is what is touched, at any time from the first milliseconds after a contact on.

   A contact begins with what was heard before it; then come its samples, and after any of them an
   answer may be asked for. */
#ifndef FC_ANYTIME_H
#define FC_ANYTIME_H

#include <stdbool.h>
#include <stdint.h>

#include "fc_anytime_sizes.h"
#include "fc_model.h"
#include "fc_pitch.h"
#include "fc_steps.h"
#include "fc_whole.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { FC_FEATURES = 14, FC_TRAITS = FC_FEATURES + 2, FC_COMPONENTS = 3 };
enum { FC_NUMBERS = 3 * FC_LONGEST + FC_FEATURES + FC_BESIDE };

/* What is known of a rig: at each stage and level of Shore A what heads look for and find. */
typedef struct {
    int32_t finger, levels; /* finger is -1 for any other */
    double level, sign;
    const float *keys, *values, *along;
    const fc_motor *motor; /* NULL where it is not listened to */
} fc_rig;

typedef struct {
    int32_t rigs, shortest, stages;
    const int32_t *stage;      /* samples up to which each lasts */
    const fc_rig *rig;
    const float *mean, *each;  /* of the inputs: mean, and one over the deviation */
    fc_whole query1[2], query2[2], body1[2], body2[2], body3[2];
    fc_dense answer;
    const double *factor;      /* half widths in spreads */
    const double *usual;       /* of what is familiar: means, */
    const float *whitening;    /* what makes distances of differences, */
    const double *limit;       /* and the largest distance */
    const fc_ear *ear;         /* NULL where no motor is listened to */
    double still;              /* share of samples that repeat themselves in a dead sensor */
} fc_anytime;

typedef struct {
    double value, spread, low, high; /* Shore A */
    bool strange;                    /* like nothing that was learned from */
} fc_running;

typedef struct {
    const fc_rig *rig;
    int32_t samples;
    bool broken;
    float lowest, highest;
    float beside[FC_BESIDE]; /* what is known beside the signal: closing speed and radius */
    double loud; /* logarithm of the noise before the contact over the rig's level */
    double v[FC_LONGEST];
    float scaled[FC_LONGEST];
} fc_touch;

/* before: FC_BEFORE samples up to the contact, V, baseline removed. The motor is listened to here. */
void fc_anytime_begin(const fc_anytime *m, fc_touch *t, const float *before, int32_t finger);

/* The next sample, V, baseline removed; what comes after FC_LONGEST is left out. */
void fc_anytime_take(fc_touch *t, float volts);

/* FC_UNUSABLE: too few samples, one that is not finite, or a signal that does not move. */
fc_status fc_anytime_answer(const fc_anytime *m, const fc_touch *t, fc_running *answer);

#ifdef __cplusplus
}
#endif
#endif
