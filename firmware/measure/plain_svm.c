#include "plain_svm.h"

#include <math.h>

#ifdef CMSIS
#include "dsp/svm_functions.h"
#endif

static float inputs[PLAIN_INPUTS];

fc_status plain_svm(const float *window, fc_prediction *prediction)
{
    float power = 0.0f, sum = PLAIN_BIAS;
    for (int k = 0; k < PLAIN_INPUTS - 1; k++)
        power += window[k] * window[k];
    const float rms = sqrtf(power / (PLAIN_INPUTS - 1));
    for (int k = 0; k < PLAIN_INPUTS - 1; k++)
        inputs[k] = window[k] / rms;
    inputs[PLAIN_INPUTS - 1] = (logf(rms) - PLAIN_MEAN) * PLAIN_SLOPE;
#ifdef CMSIS
    static const int32_t classes[2] = {0, 1};
    arm_svm_rbf_instance_f32 machine;
    int32_t chosen;
    arm_svm_rbf_init_f32(&machine, PLAIN_VECTORS, PLAIN_INPUTS, PLAIN_BIAS, plain_weights,
                         plain_vectors, classes, PLAIN_GAMMA);
    arm_svm_rbf_predict_f32(&machine, inputs, &chosen);
    prediction->class_number = chosen;
    (void)sum;
#else
    for (int i = 0; i < PLAIN_VECTORS; i++) {
        float square = 0.0f;
        for (int k = 0; k < PLAIN_INPUTS; k++) {
            const float away = inputs[k] - plain_vectors[i * PLAIN_INPUTS + k];
            square += away * away;
        }
        sum += plain_weights[i] * expf(-PLAIN_GAMMA * square);
    }
    prediction->value = sum;
#endif
    return FC_PREDICTED;
}
