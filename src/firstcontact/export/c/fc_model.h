/* An estimate of stiffness from one window, with the refusals of the host's program. */
#ifndef FC_MODEL_H
#define FC_MODEL_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    FC_ANSWER = 0,
    FC_UNUSABLE = 1, /* a value that is not finite, or a channel that does not move */
    FC_NO_ANSWER = 2 /* what comes out is not a number below 1e9 */
} fc_status;

typedef struct {
    double value;     /* Shore A, or what else was learned */
    double low, high; /* ends of the interval; NAN where the model has none */
    int32_t chosen;   /* number of the class, -1 for a regression */
} fc_answer;

typedef struct {
    int32_t samples, channels, outputs;
    void (*run)(const float *window, float *outputs, float *spread);
    double mean, scale;       /* of the target */
    const double *classes;    /* outputs of them; NULL for a regression */
    int32_t edges;            /* -1 where there is no interval */
    const double *edge, *half_width; /* edges and edges + 1 numbers */
    bool scaled, limited;     /* half widths in spreads; bounds within these limits */
    double least, most;
} fc_window_model;

/* window: volts from the contact on, baseline removed, all channels of each sample;
   outputs: room for model->outputs numbers. */
fc_status fc_model_answer(const fc_window_model *model, const float *window, float *outputs,
                          fc_answer *answer);

#ifdef __cplusplus
}
#endif
#endif
