/* How fast the hand closes, heard in the pitch of its motor before a contact: by how much the
   spectrum moved against the rig's usual one on a logarithmic axis of frequency. */
#ifndef FC_PITCH_H
#define FC_PITCH_H

#include <stdint.h>

#include "fc_anytime_sizes.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Points of the axis, and the farthest shift that is looked for. */
enum { FC_POINTS = 400, FC_FARTHEST = 88 };

typedef struct {
    const float *turn;      /* sines of 2560 angles, 2048 to a turn */
    const float *fade;      /* FC_HEARD: how much each sample counts, in counts of the converter */
    const int16_t *cell;    /* FC_POINTS: line of the spectrum below each point, */
    const float *part;      /* and how far the point is on its way to the next */
    const float *each;      /* FC_FARTHEST + 1: what makes correlations of products */
    double step;            /* between two points, ln(frequency) */
} fc_ear;

typedef struct {
    const float *reference; /* FC_POINTS: the rig's usual spectrum */
    double deviation, usual;
} fc_motor;

/* quiet: FC_HEARD samples before the contact. ln(speed / usual speed), and how sure that is. */
void fc_pitch_listen(const fc_ear *ear, const fc_motor *motor, const float *quiet, double *speed,
                     double *alike);

#ifdef __cplusplus
}
#endif
#endif
