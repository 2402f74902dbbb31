#include "fc_math.h"
#include "fc_model.h"

#include <math.h>
#include <stddef.h>

/* Finite, and moving in every channel. A NaN fails every comparison, an infinity the last. */
static bool usable(const fc_window_model *m, const float *window)
{
    for (int32_t c = 0; c < m->channels; c++) {
        float low = window[c], high = window[c];
        for (int32_t k = 0; k < m->samples; k++) {
            const float v = window[k * m->channels + c];
            if (!(v - v == 0.0f))
                return false;
            low = v < low ? v : low;
            high = v > high ? v : high;
        }
        if (!(high - low > 0.0f && high - low < INFINITY))
            return false;
    }
    return true;
}

static double within(double x, double least, double most)
{
    const double above = x > least ? x : least;
    return above < most ? above : most;
}

static void bound(const fc_window_model *m, double spread, fc_answer *answer)
{
    answer->low = answer->high = NAN;
    if (m->edges < 0)
        return;
    int32_t k = 0;
    while (k < m->edges && answer->value >= m->edge[k])
        k++;
    const double half = m->scaled ? m->half_width[k] * spread : m->half_width[k];
    answer->low = answer->value - half;
    answer->high = answer->value + half;
    if (m->limited) {
        answer->low = within(answer->low, m->least, m->most);
        answer->high = within(answer->high, m->least, m->most);
    }
}

fc_status fc_model_answer(const fc_window_model *m, const float *window, float *outputs,
                          fc_answer *answer)
{
    float spread = 1.0f;
    if (!usable(m, window))
        return FC_UNUSABLE;
    m->run(window, outputs, &spread);
    for (int32_t i = 0; i < m->outputs; i++)
        if (!(outputs[i] - outputs[i] == 0.0f))
            return FC_NO_ANSWER;
    answer->chosen = -1;
    if (m->classes == NULL) {
        answer->value = (double)outputs[0] * m->scale + m->mean;
        if (!(fabs(answer->value) < 1e9))
            return FC_NO_ANSWER;
    } else {
        answer->chosen = 0;
        for (int32_t i = 1; i < m->outputs; i++)
            if (outputs[i] > outputs[answer->chosen])
                answer->chosen = i;
        answer->value = m->classes[answer->chosen];
    }
    bound(m, spread, answer);
    return FC_ANSWER;
}
