/* Finds contacts in a stream of samples: one sample of all channels in, contacts out.

   Memory is one fc_detector; what it holds beside the stream is the judge's (fc_judge_*.h). */
#ifndef FC_DETECTOR_H
#define FC_DETECTOR_H

#include <stdbool.h>
#include <stdint.h>

#include "fc_detector_sizes.h"

#include FC_JUDGE_HEADER

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    int32_t channel;
    uint32_t sample; /* at which the contact began */
    uint32_t known;  /* after which it was known */
} fc_contact;

typedef struct {
    /* A channel is measured from its first sample: an offset costs no digits of the sums, which grow
       while the steady state comes in. */
    double first, sum, squares;
    double mean, sigma; /* infinite for a channel that does not move: it stays at 0 sigmas */
    bool latched;
    /* In sigmas of the steady state: sample n at n % FC_RING and again FC_RING behind it, so that
       the newest ones always lie in a row. */
    double past[2 * FC_RING];
    double steady[FC_STEADY]; /* volts from the first sample */
    fc_judge judge;
} fc_channel;

typedef struct {
    fc_channel channel[FC_CHANNELS];
    uint32_t next;       /* number of the next sample */
    uint32_t count;      /* samples since the stream began anew */
    uint32_t window_end; /* count at which the next window is whole */
} fc_detector;

/* A closing begins: nothing is held, and the next sample has this number. */
void fc_detector_start(fc_detector *d, uint32_t next);

/* Samples were lost: the steady state is measured anew, what is held stays held. */
void fc_detector_gap(fc_detector *d, uint32_t next);

/* One sample of each channel, V as the fingertip sends it; room for FC_CHANNELS contacts.
   Returns how many there are, the earlier first. A value that is not finite is a gap. */
int32_t fc_detector_take(fc_detector *d, const double *volts, fc_contact *contacts);

#ifdef __cplusplus
}
#endif
#endif
