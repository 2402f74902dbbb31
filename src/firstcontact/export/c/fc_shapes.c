#include "fc_shapes.h"

#include <math.h>

#include "fc_math.h"

enum { TAPS = 9, HIGH = 3 }; /* taps of MiniRocket's kernels; by so much the high three exceed -1 */

void fc_over_peak_run(const fc_over_peak *s, const float *in, float *out)
{
    float peak = 0.0f;
    for (int32_t k = 0; k < s->size; k++) {
        const float size = fabsf(in[k]);
        peak = size > peak ? size : peak;
    }
    for (int32_t k = 0; k < s->size; k++)
        out[k] = in[k] / peak;
}

void fc_powers_run(const fc_powers *s, const float *in, float *out)
{
    for (int32_t k = 0; k < s->lines; k++)
        out[k] = in[k] * in[k] + in[s->lines + k] * in[s->lines + k];
}

void fc_level_free_run(const fc_level_free *s, const float *in, float *out)
{
    double sum = 0.0, mean = 0.0;
    for (int32_t k = 0; k < s->size; k++)
        sum += in[k];
    for (int32_t k = 0; k < s->size; k++) {
        const double log = fc_log(in[k] / sum + s->floor);
        mean += log / s->size;
        out[k] = (float)log;
    }
    for (int32_t k = 0; k < s->size; k++)
        out[k] -= (float)mean;
}

void fc_course_run(const fc_course *s, const float *in, float *out)
{
    const int32_t n = s->samples, last = n * s->channels;
    const float *const x = in + s->channel;
    double largest = 0.0, total = 0.0, steps = 0.0, before = 0.0;
    int32_t turns = 0, peak = 0;
    for (int32_t k = 0; k < last; k++) {
        const double size = fabs((double)in[k]);
        largest = size > largest ? size : largest;
    }
    double top = -1.0;
    for (int32_t k = 0; k < n; k++) {
        const double v = x[k * s->channels] / largest, step = v - before;
        total += v * v;
        if (k > 0) {
            steps += step * step;
            turns += (v > 0.0) - (v < 0.0) != (before > 0.0) - (before < 0.0);
        }
        if (fabs(v) > top) {
            top = fabs(v);
            peak = k;
        }
        before = v;
    }
    for (int32_t q = 0; q < s->quantiles; q++) {
        double energy = 0.0;
        int32_t waiting = 0;
        for (int32_t k = 0; k < n; k++) {
            const double v = x[k * s->channels] / largest;
            energy += v * v;
            waiting += energy < s->quantile[q] * total;
        }
        out[q] = (float)((double)waiting / n);
    }
    out += s->quantiles;
    out[0] = (float)((double)turns / (n - 1));
    out[1] = (float)fc_log((steps > 1e-300 ? steps : 1e-300) / total);
    out[2] = (float)((double)peak / n);
}

/* One tap of the window, its channels end to end; 0 outside. */
static inline double tap(const fc_shares_above *s, const float *in, int32_t at)
{
    if (at < 0 || at >= s->samples * s->channels)
        return 0.0;
    return in[at % s->samples * s->channels + at / s->samples];
}

/* In double: there no sum lies so near a bias that the order of its terms decides. */
void fc_shares_above_run(const fc_shares_above *s, const float *in, float *out)
{
    const int32_t n = s->samples * s->channels, per_dilation = 84 * s->each;
    double power = 0.0;
    for (int32_t k = 0; k < n; k++)
        power += (double)in[k] * in[k];
    const double rms = sqrt(power / n);
    for (int32_t k = 0; k < s->dilations * per_dilation; k++)
        out[k] = 0.0f;
    for (int32_t d = 0; d < s->dilations; d++) {
        const float *const biases = s->bias + d * per_dilation;
        float *const counts = out + d * per_dilation;
        for (int32_t t = 0; t < n; t++) {
            double high[TAPS], sum = 0.0;
            for (int32_t k = 0; k < TAPS; k++) {
                const double x = tap(s, in, t + (k - TAPS / 2) * s->dilation[d]) / rms;
                high[k] = HIGH * x;
                sum += x;
            }
            const float *bias = biases;
            float *count = counts;
            for (int32_t a = 0; a < TAPS; a++)
                for (int32_t b = a + 1; b < TAPS; b++)
                    for (int32_t c = b + 1; c < TAPS; c++) {
                        const double y = high[a] + high[b] + high[c] - sum;
                        for (int32_t k = 0; k < s->each; k++, count++)
                            *count += y > (double)*bias++ ? 1.0f : 0.0f;
                    }
        }
    }
    for (int32_t k = 0; k < s->dilations * per_dilation; k++)
        out[k] = out[k] / (float)n;
    out[s->dilations * per_dilation] = (float)fc_log(rms);
}
