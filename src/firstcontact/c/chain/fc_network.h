/* Network that predicts stiffness from one contact, conditioned on a rig. Its weights are integers
   whose sums are exact, so every machine computes the same bits.

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". */
#ifndef FC_NETWORK_H
#define FC_NETWORK_H

#include <stdint.h>

enum {
    FC_LAYERS = 4,          /* layers, each with a SiLU; the rig acts on layer FC_RIG_LAYER */
    FC_RIG_LAYER = 1,
    FC_COMPONENTS = 3,      /* normal distributions of the predicted mixture */
    FC_WIDTH_MOST = 256     /* inputs or outputs of a layer */
};

/* Matrix of integers with a scale for each row. Rows are padded with zeros to a multiple of 4. The
   magnitudes of a row add up to 65535 at most, so sums fit into 32 bits. */
typedef struct {
    int32_t rows, columns;
    const int16_t *weight;
    const float *scale;
} fc_matrix;

/* Thin layer: outputs = out . (into . inputs + rig term) + bias. */
typedef struct {
    fc_matrix into, out;
    const float *bias;
} fc_layer;

typedef struct {
    int32_t inputs;
    const float *mean, *sd; /* of the inputs */
    fc_layer layers[FC_LAYERS];
    const float *output, *output_bias; /* (3 * FC_COMPONENTS, outputs of the last layer), and bias */
} fc_network;

/* Memory for one prediction. */
typedef struct {
    float values[FC_WIDTH_MOST], thin[FC_WIDTH_MOST];
    int16_t rounded[FC_WIDTH_MOST + 4];
    int32_t sums[FC_WIDTH_MOST];
} fc_network_room;

/* Predict from inputs.
   n         in
   rig_term  in, contribution of the rig to layer FC_RIG_LAYER, (rows of its first matrix)
   room      in, out: the inputs are in `values`, (inputs), and are overwritten
   mean      out, Shore A
   spread    out, Shore A: standard deviation */
void fc_network_predict(const fc_network *n, const float *rig_term, fc_network_room *room,
                        double *mean, double *spread);

#endif
