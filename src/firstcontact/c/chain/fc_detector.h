/* Contact detectors that evaluate sliding windows in units of the motor's noise (sigmas).

   A window contains several looks: spans of equal length, one step apart. A contact must show in
   all looks. */
#ifndef FC_DETECTOR_H
#define FC_DETECTOR_H

#include <stdbool.h>
#include <stdint.h>

#include "fc_gate.h"

enum {
    FC_ORDER = 12,          /* order of the linear prediction, a multiple of 4 */
    FC_PARTS = 5,           /* spans at the end of a look */
    FC_LEVELS = FC_PARTS + 3, /* features of the signal, and of its prediction error */
    FC_LOOKS_MOST = 8,
    FC_WINDOW_MOST = 1 << 14,
    FC_LEAST_LOUD = 3       /* fewest samples on each side of an onset */
};

/* Kinds of detectors. For the last kind, the calling program evaluates the windows. */
enum { FC_DETECTOR_NONE, FC_DETECTOR_LOGISTIC, FC_DETECTOR_THRESHOLD, FC_DETECTOR_PROGRAM };

/* Constants of a detector, at one rate. Lengths are in samples. */
typedef struct {
    int32_t kind;
    int32_t window, step;   /* length of a window, and distance between two windows */
    int32_t steady;         /* length of the steady state */
    int32_t search;         /* number of newest samples of a window in which an onset can lie */
    int32_t looks;          /* number of looks in a window */
    int32_t lengths[FC_PARTS + 1]; /* lengths of spans at the end of a look, ascending */
    int32_t unused[2];
    double threshold;       /* deviation of a new sample, in sigmas, from which the detector evaluates the
                               window, or FC_DETECTOR_THRESHOLD fires */
    double floor;           /* added to levels before their logarithm, in sigmas */
    double line[2 * FC_LEVELS + 1]; /* weights of the features, and the intercept */
} fc_detector_constants;

/* Newest smoothed samples of each channel, V. The capacity is a power of 2. Sample n of channel c
   is at volts[c * capacity + n % capacity]. */
typedef struct {
    double *volts;
    int32_t capacity, channels;
    int64_t begin, end;     /* numbers of the first stored sample, and of the next one */
} fc_past;

static inline double fc_past_at(const fc_past *p, int32_t channel, int64_t sample)
{
    return p->volts[channel * p->capacity + (int32_t)((uint32_t)sample & (uint32_t)(p->capacity - 1))];
}

/* Functions of a program that evaluates windows itself. */
typedef struct {
    /* Receive a new steady state, in sigmas: (steady, channels). */
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
    double *window, *work;  /* room for (channels, n) and (n,) numbers; n is the larger of window and steady */
    int32_t effort;         /* looks computed since the program set it to 0, or as much other work */
    bool is_settled;
    int64_t settles, next;  /* ends of the steady state, and of the next window */
    double mean[FC_CHANNELS_MOST], sigma[FC_CHANNELS_MOST]; /* a constant channel has sigma 0 */
    double weights[FC_CHANNELS_MOST][FC_ORDER + 1];
    double looks[FC_CHANNELS_MOST][FC_LOOKS_MOST][2]; /* end and score of each look */
} fc_detector;

/* Start at sample `first`, and forget all earlier samples. */
void fc_detector_restart(fc_detector *d, int64_t first);

/* Measure the steady state in the samples before `end`. */
void fc_detector_settle(fc_detector *d, const fc_past *past, int64_t end);

/* Replace the steady state of the channels that are quieter in the samples before `end`. */
void fc_detector_resettle(fc_detector *d, const fc_past *past, int64_t end);

/* Evaluate the window that ends with the newest sample. Write the first sample of a contact into
   `onsets` for each channel, or -1. is_skipped marks channels that need no decision. */
void fc_detector_judge(fc_detector *d, const fc_past *past, const bool *is_skipped, int64_t *onsets);

/* Fit a linear prediction to n samples of the steady state, in sigmas. The prediction removes the
   predictable part of the motor's noise. Its error has a sigma of 1. `error` has room for n
   numbers, `weights` for FC_ORDER + 1. */
void fc_fit_prediction(const double *x, int32_t n, double *error, double *weights);

/* Write the 2 * FC_LEVELS features of a look of n samples, in sigmas. `power` has room for n
   numbers. */
void fc_look_features(const fc_detector_constants *k, const double *x, int32_t n,
                      const double *weights, double *power, double *features);

#endif
