/* Contact detectors that judge sliding windows in units of the motor's noise. */
#ifndef FC_DETECTOR_H
#define FC_DETECTOR_H

#include <stdbool.h>
#include <stdint.h>

#include "fc_gate.h"

enum {
    FC_ORDER = 12,          /* order of the linear prediction */
    FC_PARTS = 5,           /* spans at the end of a look */
    FC_LEVELS = FC_PARTS + 3, /* features of the signal, and of its prediction error */
    FC_LOOKS_MOST = 8,
    FC_WINDOW_MOST = 1 << 14,
    FC_LEAST_LOUD = 3       /* fewest samples on each side of an onset */
};

/* Kinds of detectors. A program judges the windows of the last kind itself. */
enum { FC_DETECTOR_NONE, FC_DETECTOR_LOGISTIC, FC_DETECTOR_THRESHOLD, FC_DETECTOR_PROGRAM };

/* Constants of a detector, at one rate. Lengths are in samples. */
typedef struct {
    int32_t kind;
    int32_t window, step;   /* length of a window, and distance between two windows */
    int32_t steady;         /* length of the steady state */
    int32_t search;         /* newest samples of a window in which an onset may lie */
    int32_t looks;          /* consecutive looks of a window that must agree */
    int32_t lengths[FC_PARTS + 1]; /* spans at the end of a look, ascending */
    int32_t unused[2];
    double threshold;       /* of a sample, in sigmas: the window is judged, or the threshold fires */
    double floor;           /* added to levels before their logarithm, in sigmas */
    double line[2 * FC_LEVELS + 1]; /* weights of the features, and the intercept */
} fc_detector_constants;

/* Newest smoothed samples of each channel, V. The capacity is a power of 2. Sample n of channel c is
   at volts[c * capacity + n % capacity]. */
typedef struct {
    double *volts;
    int32_t capacity, channels;
    int64_t begin, end;     /* numbers of the first stored sample, and of the next one */
} fc_past;

static inline double fc_past_at(const fc_past *p, int32_t channel, int64_t sample)
{
    return p->volts[channel * p->capacity + (int32_t)((uint32_t)sample & (uint32_t)(p->capacity - 1))];
}

/* Functions of a program that judges windows itself. */
typedef struct {
    /* A channel has a new steady state, in its sigmas: (steady, channels). */
    void (*settled)(void *context, const double *quiet);
    /* Write 1 into `fired` for each channel with a contact. windows: (channels, window). */
    void (*judge)(void *context, const double *windows, uint8_t *fired);
    void *context;
} fc_judge;

/* State of a detector in one closing. */
typedef struct {
    const fc_detector_constants *constants;
    fc_judge program;
    int32_t channels;
    double *window, *work;  /* room: (channels, n) and (n,), n the longer of window and steady */
    bool is_settled;
    int64_t settles, next;  /* ends of the steady state, and of the next window */
    double mean[FC_CHANNELS_MOST], sigma[FC_CHANNELS_MOST]; /* a constant channel has sigma 0 */
    double weights[FC_CHANNELS_MOST][FC_ORDER + 1];
    double looks[FC_CHANNELS_MOST][FC_LOOKS_MOST][2]; /* end of a look, and its score */
} fc_detector;

/* Start at sample `first`, and forget all earlier samples. */
void fc_detector_restart(fc_detector *d, int64_t first);

/* Measure the steady state in the samples before `end`. */
void fc_detector_settle(fc_detector *d, const fc_past *past, int64_t end);

/* Replace the steady state of the channels that are quieter in the samples before `end`. */
void fc_detector_resettle(fc_detector *d, const fc_past *past, int64_t end);

/* Judge the window that ends with the newest sample. onsets: sample at which a contact began, for
   each channel; -1 without a contact. is_skipped marks channels that need no decision. */
void fc_detector_judge(fc_detector *d, const fc_past *past, const bool *is_skipped, int64_t *onsets);

/* Fit a linear prediction to n samples of the steady state, in sigmas. It removes the predictable part
   of the motor's noise. Its error has a sigma of 1. error: room for n numbers. weights: FC_ORDER + 1. */
void fc_fit_prediction(const double *x, int32_t n, double *error, double *weights);

/* Write the 2 * FC_LEVELS features of a look of n samples, in sigmas. power: room for n numbers. */
void fc_look_features(const fc_detector_constants *k, const double *x, int32_t n,
                      const double *weights, double *power, double *features);

#endif
