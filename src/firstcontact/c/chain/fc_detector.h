/* Contact detectors that evaluate sliding windows in units of the motor's noise (sigmas).

   A window contains several looks: spans of equal length, one step apart. A contact must show in
   all looks.

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". A sigma is the standard deviation of the motor's noise. */
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

/* Return a stored sample, V.
   p        in
   channel  in, from 0 to channels - 1
   sample   in, number from begin to end - 1 */
static inline double fc_past_at(const fc_past *p, int32_t channel, int64_t sample)
{
    return p->volts[channel * p->capacity + (int32_t)((uint32_t)sample & (uint32_t)(p->capacity - 1))];
}

/* Functions of a program that evaluates windows itself. */
typedef struct {
    /* Receive a new steady state. Can be NULL for other kinds of detectors.
       context  in, as below
       quiet    in, sigmas, (steady, channels) */
    void (*settled)(void *context, const double *quiet);
    /* Mark the channels with a contact. Can be NULL for other kinds of detectors.
       context  in, as below
       windows  in, sigmas, (channels, window)
       fired    out, 1 for a contact, else 0, (channels) */
    void (*judge)(void *context, const double *windows, uint8_t *fired);
    void *context;          /* passed to both functions, or NULL */
} fc_judge;

/* Score of a look that ends before sample `end`. */
typedef struct {
    int64_t end;            /* -1 if nothing is stored */
    double score;
} fc_look;

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
    fc_look looks[FC_CHANNELS_MOST][FC_LOOKS_MOST]; /* newest looks, which windows share */
} fc_detector;

/* Start again, and forget all earlier samples.
   d      in, out
   first  in, number of the next sample */
void fc_detector_restart(fc_detector *d, int64_t first);

/* Measure the steady state.
   d     in, out
   past  in
   end   in, number of the sample after the steady state */
void fc_detector_settle(fc_detector *d, const fc_past *past, int64_t end);

/* Replace the steady state of the channels that are quieter than before.
   d     in, out
   past  in
   end   in, number of the sample after the new steady state */
void fc_detector_resettle(fc_detector *d, const fc_past *past, int64_t end);

/* Evaluate the window that ends with the newest sample.
   d           in, out
   past        in
   is_skipped  in, true for channels that need no decision, (channels)
   onsets      out, number of the first sample of a contact, or -1, (channels) */
void fc_detector_judge(fc_detector *d, const fc_past *past, const bool *is_skipped, int64_t *onsets);

/* Fit a linear prediction to the steady state. The prediction removes the predictable part of the
   motor's noise. Its error has a sigma of 1.
   x        in, sigmas, (n)
   n        in, samples, above FC_ORDER
   error    out, room for work, (n)
   weights  out, (FC_ORDER + 1) */
void fc_fit_prediction(const double *x, int32_t n, double *error, double *weights);

/* Compute the features of a look.
   k         in, of which only `lengths` and `floor` are read
   x         in, sigmas, (n)
   n         in, samples, above FC_ORDER + lengths[FC_PARTS]
   weights   in, of fc_fit_prediction, (FC_ORDER + 1)
   power     out, room for work, (n)
   features  out, ln(sigmas), (2 * FC_LEVELS) */
void fc_look_features(const fc_detector_constants *k, const double *x, int32_t n,
                      const double *weights, double *power, double *features);

#endif
