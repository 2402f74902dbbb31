/* Support vector machine with a radial basis function kernel, which predicts from one window: the
   signal after a contact, smoothed, minus the quiet signal before it. Sums are computed in a fixed
   order, and fused only by fmaf, so that every machine computes the same bits. */
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

/* Return the size of the room for one prediction, in numbers. */
size_t fc_svm_room(const fc_svm *m);

/* Predict from the window at the start of `room`, which is overwritten. Return the decision of a
   regression, or the votes for each class; NULL if they are not finite. The window must vary. */
const float *fc_svm_outputs(const fc_svm *m, float *room);

/* Predict from the window that begins with sample `first`. `out`: value, and ends of the interval,
   which equal the value without an interval. Return FC_DONE, or the reason of FC_NOT_ESTIMATED. */
int32_t fc_svm_predict(const fc_svm *m, const fc_past *past, int32_t channel, int64_t first,
                       float *room, double out[3]);

#endif
