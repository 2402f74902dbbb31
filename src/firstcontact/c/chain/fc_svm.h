/* Support vector machine with a radial basis function kernel, which predicts from one window: the
   signal after a contact, smoothed, minus the quiet signal before it. Sums are computed in a fixed
   order, and fused only by fmaf, so that every machine computes the same bits.

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". */
#ifndef FC_SVM_H
#define FC_SVM_H

#include <stddef.h>

#include "fc_detector.h"

enum {
    FC_SVMS_MOST = 8,        /* machines of a model, each with a window of its own length */
    FC_CLASSES_MOST = 1000,
    FC_SVM_LOOKAHEAD = 2     /* samples after a window that its filter needs */
};

/* Numbers of a machine, as they are in the image. Lengths are in samples. */
typedef struct {
    int32_t guard, baseline; /* baseline: length of the quiet signal that ends `guard` before the contact */
    int32_t least;           /* shortest quiet signal */
    int32_t vectors;
    int32_t class_count;     /* 0 for a regression */
    int32_t edges;           /* edges of the interval; -1 without an interval */
    int32_t is_logarithmic;  /* 1 if value and interval are natural logarithms, which are undone */
    int32_t unused;
    double level, slope;     /* a window's level is (ln(RMS) - level) * slope */
    double gamma;
    double mean, scale;      /* of the target of a regression */
    double lowest, highest;  /* ends of the scale */
} fc_svm_numbers;

/* A support vector has samples + 1 numbers: a window divided by its RMS, and its level. */
typedef struct {
    const fc_svm_numbers *numbers;
    int32_t samples;         /* length of the window */
    int32_t decisions;       /* 1 for a regression, else one for each pair of classes */
    const float *scaled;     /* 2 gamma v of each support vector v */
    const float *norms;      /* -gamma |v|^2 of each support vector v */
    const float *weights, *bias; /* (decisions, vectors) and (decisions,) */
    const double *classes;   /* values of the classes */
    const double *edge;      /* predictions at which the width of the interval changes */
    const double *half_width; /* (edges + 1,) */
} fc_svm;

/* Stiffness in the unit of the training, and the ends of its interval. */
typedef struct {
    double value, low, high;
} fc_svm_estimate;

/* Return how many floats one prediction needs as memory.
   m  in */
size_t fc_svm_room(const fc_svm *m);

/* Predict from a window, which must vary. Return the decision of a regression, or the votes for each
   class, in `room`; NULL if they are not finite.
   m     in
   room  in, out: (fc_svm_room(m)). It begins with the window, V, (samples), which is overwritten. */
const float *fc_svm_outputs(const fc_svm *m, float *room);

/* Predict from the signal of a contact. Return FC_DONE, or the reason of FC_NOT_ESTIMATED.
   m        in
   past     in, which holds samples + FC_SVM_LOOKAHEAD samples from `first` on
   channel  in, from 0
   first    in, number of the contact's first sample
   room     out, room for work, (fc_svm_room(m))
   out      out, where without an interval all numbers are equal. Unchanged without a prediction. */
int32_t fc_svm_predict(const fc_svm *m, const fc_past *past, int32_t channel, int64_t first,
                       float *room, fc_svm_estimate *out);

#endif
