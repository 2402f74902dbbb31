#include "fc_svm.h"

#include <math.h>
#include <stddef.h>

#include "fc_math.h"

/* Compute eight rows of weights * x + bias. Each number of x is loaded once for all rows, and eight
   independent sums hide the latency of fmaf. */
static void eight_rows(const float *weights, const float *bias, int32_t inputs, const float *x,
                       float *out)
{
    const float *const a = weights, *const b = a + inputs, *const c = b + inputs;
    const float *const d = c + inputs, *const e = d + inputs, *const f = e + inputs;
    const float *const g = f + inputs, *const h = g + inputs;
    float p = bias[0], q = bias[1], r = bias[2], s = bias[3];
    float t = bias[4], u = bias[5], v = bias[6], w = bias[7];
    for (int32_t k = 0; k < inputs; k++) {
        const float y = x[k];
        p = fmaf(a[k], y, p);
        q = fmaf(b[k], y, q);
        r = fmaf(c[k], y, r);
        s = fmaf(d[k], y, s);
        t = fmaf(e[k], y, t);
        u = fmaf(f[k], y, u);
        v = fmaf(g[k], y, v);
        w = fmaf(h[k], y, w);
    }
    out[0] = p;
    out[1] = q;
    out[2] = r;
    out[3] = s;
    out[4] = t;
    out[5] = u;
    out[6] = v;
    out[7] = w;
}

static float one_row(const float *weights, float bias, int32_t inputs, const float *x)
{
    for (int32_t k = 0; k < inputs; k++)
        bias = fmaf(weights[k], x[k], bias);
    return bias;
}

/* Compute weights * x + bias. The last block of eight rows overlaps the one before it. */
static void rows(const float *weights, const float *bias, int32_t n, int32_t inputs, const float *x,
                 float *out)
{
    for (int32_t i = 0; i < n && n < 8; i++)
        out[i] = one_row(weights + i * inputs, bias[i], inputs, x);
    for (int32_t i = 0; i < n && n >= 8; i += 8) {
        const int32_t start = i + 8 <= n ? i : n - 8;
        eight_rows(weights + start * inputs, bias + start, inputs, x, out + start);
    }
}

/* Return true if all samples are finite and no channel is constant. */
static bool is_usable(const fc_svm *m, const float *window)
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

/* Compute the shape, which is the window divided by its RMS, and the level. The level is NaN if
   float32 holds too few digits of the power. */
static void shape_and_level(const fc_svm *m, const float *window, float *out)
{
    const int32_t n = m->samples * m->channels;
    double power = 0.0;
    for (int32_t k = 0; k < n; k++)
        power += (double)window[k] * window[k];
    const double rms = sqrt(power / n);
    const float scale = (float)(1.0 / rms);
    for (int32_t k = 0; k < n; k++)
        out[k] = window[k] * scale;
    const bool is_in_range = power > m->least_power && power < m->most_power;
    out[n] = is_in_range ? (float)((fc_log(rms) - m->level) * m->slope) : NAN;
}

/* Compute exp(-gamma |x - v|^2) for each support vector v. */
static void kernel(const fc_svm *m, const float *x, int32_t inputs, float *out)
{
    double square = 0.0;
    for (int32_t k = 0; k < inputs; k++)
        square += (double)x[k] * x[k];
    const float norm = (float)(m->gamma * square);
    rows(m->scaled, m->norms, m->vectors, inputs, x, out);
    for (int32_t i = 0; i < m->vectors; i++) {
        const float exponent = out[i] - norm;
        out[i] = exponent == exponent ? fc_expf(exponent) : exponent;
    }
}

/* Return the class that wins most pairs, in a tie the first. Pairs are (0, 1), (0, 2), ...,
   (1, 2), ... */
static int32_t most_votes(const fc_svm *m, const float *decisions, float *votes)
{
    for (int32_t i = 0; i < m->class_count; i++)
        votes[i] = 0.0f;
    for (int32_t i = 0; i < m->class_count; i++)
        for (int32_t j = i + 1; j < m->class_count; j++)
            votes[*decisions++ > m->least_decision ? i : j] += 1.0f;
    int32_t best = 0;
    for (int32_t i = 1; i < m->class_count; i++)
        best = votes[i] > votes[best] ? i : best;
    return best;
}

static void set_interval(const fc_svm *m, fc_prediction *p)
{
    p->low = p->high = NAN;
    if (m->edges < 0)
        return;
    int32_t k = 0;
    while (k < m->edges && p->value >= m->edge[k])
        k++;
    p->low = fc_bounded(p->value - m->half_width[k], m->lowest, m->highest);
    p->high = fc_bounded(p->value + m->half_width[k], m->lowest, m->highest);
}

fc_status fc_svm_predict(const fc_svm *m, const float *window, fc_prediction *prediction)
{
    if (!is_usable(m, window))
        return FC_UNUSABLE;
    const int32_t inputs = m->samples * m->channels + 1;
    float *const kernels = m->memory + inputs, *const decisions = kernels + m->vectors;
    shape_and_level(m, window, m->memory);
    kernel(m, m->memory, inputs, kernels);
    rows(m->weights, m->bias, m->decisions, m->vectors, kernels, decisions);
    for (int32_t i = 0; i < m->decisions; i++)
        if (!(decisions[i] - decisions[i] == 0.0f))
            return FC_NO_PREDICTION;
    prediction->class_number = -1;
    if (m->classes == NULL) {
        prediction->value = (double)decisions[0] * m->scale + m->mean;
        if (!(fabs(prediction->value) < 1e9))
            return FC_NO_PREDICTION;
    } else {
        prediction->class_number = most_votes(m, decisions, decisions + m->decisions);
        prediction->value = m->classes[prediction->class_number];
    }
    set_interval(m, prediction);
    return FC_PREDICTED;
}
