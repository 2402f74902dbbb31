/* Stiffness from one window, by a support vector machine with a radial basis function kernel.

   `firstcontact export-model` writes the constants of a trained model. Sums are computed in a fixed
   order, and fused only by fmaf, so that every machine computes the same bits. */
#ifndef FC_SVM_H
#define FC_SVM_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    FC_PREDICTED = 0,
    FC_UNUSABLE = 1,     /* a sample is not finite, or a channel is constant */
    FC_NO_PREDICTION = 2 /* the result is not finite, or not below 1e9 */
} fc_status;

typedef struct {
    double value;       /* Shore A, or the value of the predicted class */
    double low, high;   /* ends of the interval; NAN if the model has none */
    int32_t class_number; /* -1 for a regression */
} fc_prediction;

/* Constants of a model. A support vector v has samples * channels + 1 numbers: the window divided
   by its RMS, and its level (ln(RMS) - level) * slope. */
typedef struct {
    int32_t samples, channels;
    int32_t vectors;
    int32_t decisions;          /* 1 for a regression, else one for each pair of classes */
    int32_t class_count;        /* 0 for a regression */
    double level, slope;
    double least_power, most_power; /* limits of the sum of squares, V^2; beyond them no prediction */
    double gamma;
    const float *scaled;        /* 2 gamma v of each support vector v */
    const float *norms;         /* -gamma |v|^2 of each support vector v */
    const float *weights, *bias; /* decisions * vectors and decisions numbers */
    double least_decision;      /* decision above which the first class of a pair wins */
    double mean, scale;         /* of the target of a regression */
    const double *classes;      /* values of the classes; NULL for a regression */
    int32_t edges;              /* number of edges; -1 without an interval */
    const double *edge;         /* predictions at which the width of the interval changes */
    const double *half_width;   /* edges + 1 half widths */
    double lowest, highest;     /* ends of the scale */
    float *memory; /* samples * channels + 1 + vectors + decisions + class_count numbers */
} fc_svm;

/* Predict from a window: volts from the contact on, minus the quiet signal before it. The window
   holds all channels of the first sample, then those of the next. */
fc_status fc_svm_predict(const fc_svm *model, const float *window, fc_prediction *prediction);

#ifdef __cplusplus
}
#endif
#endif
