#include "fc_svm.h"

#include "fc_chain.h"
#include "fc_assert.h"
#include "fc_math.h"

/* On a computer, the compiler makes a second version with the fused products of its processor. */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__GLIBC__)
#define FUSED __attribute__((target_clones("fma", "default")))
#else
#define FUSED
#endif

#if defined(__GNUC__) && !defined(__clang__)
#define UNROLL _Pragma("GCC unroll 8")
#else
#define UNROLL
#endif

/* Savitzky-Golay filter of five points and second order. */
static const double SMOOTHING[5] = {-3.0 / 35, 12.0 / 35, 17.0 / 35, 12.0 / 35, -3.0 / 35};
/* Largest magnitude of the logarithm of a prediction. */
static const double LOGARITHM_MOST = 50.0;
/* Largest magnitude of a level. Kernels are 0 long before. */
static const double LEVEL_MOST = 1e6;

/* Compute weights * x + bias. Each number of x is loaded once for eight rows, whose independent sums
   hide the latency of fmaf. The last block of eight rows overlaps the one before it. */
FUSED static void rows(const float *weights, const float *bias, int32_t n, int32_t inputs,
                       const float *x, float *out)
{
    for (int32_t i = 0; i < n && n >= 8; i += 8) {
        const int32_t start = i + 8 <= n ? i : n - 8;
        const float *const row = weights + start * inputs;
        float sum[8];
        memcpy(sum, bias + start, sizeof sum);
        for (int32_t k = 0; k < inputs; k++)
            UNROLL
            for (int32_t j = 0; j < 8; j++)
                sum[j] = fmaf(row[j * inputs + k], x[k], sum[j]);
        memcpy(out + start, sum, sizeof sum);
    }
    for (int32_t i = 0; i < n && n < 8; i++) {
        out[i] = bias[i];
        for (int32_t k = 0; k < inputs; k++)
            out[i] = fmaf(weights[i * inputs + k], x[k], out[i]);
    }
}

size_t fc_svm_room(const fc_svm *m)
{
    const fc_svm_numbers *const n = m->numbers;
    return (size_t)m->samples + 1 + (size_t)n->vectors + (size_t)m->decisions + (size_t)n->class_count;
}

/* Divide a window by its RMS, and append its level. */
static void shape_and_level(const fc_svm *m, float *x)
{
    double power = 0.0;
    for (int32_t k = 0; k < m->samples; k++)
        power += (double)x[k] * x[k];
    const double rms = sqrt(power / m->samples), scale = 1.0 / rms;
    for (int32_t k = 0; k < m->samples; k++)
        x[k] = (float)(x[k] * scale);
    x[m->samples] = (float)fc_bounded((fc_log(rms) - m->numbers->level) * m->numbers->slope,
                                      -LEVEL_MOST, LEVEL_MOST);
}

/* Compute exp(-gamma |x - v|^2) for each support vector v. */
static void kernel(const fc_svm *m, const float *x, float *out)
{
    const int32_t inputs = m->samples + 1, n = m->numbers->vectors;
    double square = 0.0;
    for (int32_t k = 0; k < inputs; k++)
        square += (double)x[k] * x[k];
    const float norm = (float)(m->numbers->gamma * square);
    rows(m->scaled, m->norms, n, inputs, x, out);
    for (int32_t i = 0; i < n; i++)
        out[i] = fc_expf(out[i] - norm);
}

const float *fc_svm_outputs(const fc_svm *m, float *x)
{
    FC_ASSERT(m != NULL && x != NULL);
    float *const kernels = x + m->samples + 1, *const decisions = kernels + m->numbers->vectors;
    float *const votes = decisions + m->decisions;
    const float *each = decisions;
    shape_and_level(m, x);
    kernel(m, x, kernels);
    rows(m->weights, m->bias, m->decisions, m->numbers->vectors, kernels, decisions);
    for (int32_t i = 0; i < m->decisions; i++)
        if (!isfinite(decisions[i]))
            return NULL;
    const int32_t classes = m->numbers->class_count;
    if (classes == 0)
        return decisions;
    for (int32_t i = 0; i < classes; i++)
        votes[i] = 0.0f;
    for (int32_t i = 0; i < classes; i++) /* pairs (0, 1), (0, 2), ..., (1, 2), ... */
        for (int32_t j = i + 1; j < classes; j++)
            votes[*each++ > 0.0f ? i : j] += 1.0f;
    return votes;
}

/* Return the smoothed sample n. The first stored sample is repeated before it. */
static double smoothed(const fc_past *p, int32_t channel, int64_t n)
{
    const double *const volts = p->volts + channel * p->capacity;
    const uint32_t begin = (uint32_t)p->begin, mask = (uint32_t)(p->capacity - 1);
    const int32_t first = (int32_t)(n - p->begin) - FC_SVM_LOOKAHEAD;
    double y = 0.0;
    UNROLL
    for (int32_t k = 0; k < 5; k++)
        y += SMOOTHING[k] * volts[(begin + (uint32_t)(first + k > 0 ? first + k : 0)) & mask];
    return y;
}

/* Cut out the window from sample `first` on. Return FC_DONE, or why it cannot be used. */
static int32_t cut(const fc_svm *m, const fc_past *p, int32_t channel, int64_t first, float *x)
{
    const fc_svm_numbers *const n = m->numbers;
    const int64_t end = first - n->guard, early = end - n->baseline;
    const int64_t start = early > p->begin ? early : p->begin;
    double baseline = 0.0;
    bool varies = false;
    if (end - start < n->least)
        return FC_TOO_EARLY;
    for (int64_t k = start; k < end; k++)
        baseline += smoothed(p, channel, k);
    baseline /= (double)(end - start);
    for (int32_t k = 0; k < m->samples; k++) {
        const double volts = smoothed(p, channel, first + k) - baseline;
        if (!(fabs(volts) < 1e38))
            return FC_NO_SIGNAL;
        x[k] = (float)volts;
        varies |= x[k] != x[0];
    }
    return varies ? FC_DONE : FC_NO_SIGNAL;
}

static double undo_logarithm(double x)
{
    return fc_exp(fc_bounded(x, -LOGARITHM_MOST, LOGARITHM_MOST));
}

int32_t fc_svm_predict(const fc_svm *m, const fc_past *past, int32_t channel, int64_t first,
                       float *room, fc_svm_estimate *out)
{
    FC_ASSERT(m != NULL && past != NULL && room != NULL && out != NULL);
    const fc_svm_numbers *const n = m->numbers;
    const int32_t reason = cut(m, past, channel, first, room);
    const float *const outputs = reason == FC_DONE ? fc_svm_outputs(m, room) : NULL;
    if (outputs == NULL)
        return reason != FC_DONE ? reason : FC_NOT_FINITE;
    int32_t best = 0, k = 0;
    for (int32_t i = 1; i < n->class_count; i++) /* in a tie the first class wins */
        best = outputs[i] > outputs[best] ? i : best;
    const double value = n->class_count > 0 ? m->classes[best] : outputs[0] * n->scale + n->mean;
    if (!(fabs(value) < 1e9))
        return FC_NOT_FINITE;
    while (k < n->edges && value >= m->edge[k])
        k++;
    out->value = out->low = out->high = value;
    if (n->edges >= 0) {
        out->low = fc_bounded(value - m->half_width[k], n->lowest, n->highest);
        out->high = fc_bounded(value + m->half_width[k], n->lowest, n->highest);
    }
    if (n->is_logarithmic) {
        out->value = undo_logarithm(out->value);
        out->low = undo_logarithm(out->low);
        out->high = undo_logarithm(out->high);
    }
    return FC_DONE;
}
