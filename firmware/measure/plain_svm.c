/* Straightforward support vector machine for comparison: libm's expf, one vector after the other.
   With CMSIS defined it calls CMSIS-DSP on the same vectors. Input: windows of floats. Output: the
   number of instructions for each. */
#include "machine.h"

#include <math.h>

#include "plain_svm_model.h"

#ifdef CMSIS
#include "dsp/svm_functions.h"
#endif

static float window[PLAIN_INPUTS - 1], inputs[PLAIN_INPUTS];

static float predict(void)
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
    sum = (float)chosen;
#else
    for (int i = 0; i < PLAIN_VECTORS; i++) {
        float square = 0.0f;
        for (int k = 0; k < PLAIN_INPUTS; k++) {
            const float away = inputs[k] - plain_vectors[i * PLAIN_INPUTS + k];
            square += away * away;
        }
        sum += plain_weights[i] * expf(-PLAIN_GAMMA * square);
    }
#endif
    return sum;
}

int main(int argc, char **argv)
{
    static volatile float predicted;
    if (!machine_begin(argc, argv))
        return 2;
    while (machine_read(window, sizeof window) == sizeof window) {
        const uint32_t before = machine_clock();
        predicted = predict();
        const uint32_t took = machine_since(before);
        (void)predicted;
        machine_write(&took, sizeof took);
    }
    machine_end();
    return 0;
}
