#include "fc_exact.h"
#include "fc_layers.h"

#include <math.h>
#include <stdbool.h>

#include "fc_math.h"

static float logistic(float x)
{
    return 1.0f / (1.0f + fc_exp(x < -60.0f ? 60.0f : -x));
}

void fc_compress_run(const fc_compress *s, const float *in, float *out)
{
    const float each = (float)s->each;
    for (int32_t k = 0; k < s->size; k++) {
        const float x = in[k] * each;
        const double size = fabs((double)x);
        const double y = fc_log(size + sqrt(size * size + 1.0));
        /* Beyond what float32 holds there is no answer, as on the host. */
        out[k] = x - x == 0.0f ? (float)(((x < 0.0f ? -y : y) - s->mean) * s->slope) : NAN;
    }
}

/* One sample of four outputs: weights of one output lie n apart from those of the next. */
static void four(const float *w, int32_t apart, const float *bias, const float *x, int32_t n,
                 float *out)
{
    const float *const b = w + apart, *const c = b + apart, *const d = c + apart;
    float p = bias[0], q = bias[1], r = bias[2], s = bias[3];
    for (int32_t k = 0; k < n; k++) {
        p = fmaf(w[k], x[k], p);
        q = fmaf(b[k], x[k], q);
        r = fmaf(c[k], x[k], r);
        s = fmaf(d[k], x[k], s);
    }
    out[0] = p;
    out[1] = q;
    out[2] = r;
    out[3] = s;
}

/* Two samples of four outputs: each weight is read once for both. */
static void eight(const float *w, int32_t apart, const float *bias, const float *x, const float *y,
                  int32_t n, float *out, float *next)
{
    const float *const b = w + apart, *const c = b + apart, *const d = c + apart;
    float p = bias[0], q = bias[1], r = bias[2], s = bias[3];
    float e = p, f = q, g = r, h = s;
    for (int32_t k = 0; k < n; k++) {
        const float u = w[k], v = b[k], i = c[k], j = d[k], l = x[k], m = y[k];
        p = fmaf(u, l, p);
        q = fmaf(v, l, q);
        r = fmaf(i, l, r);
        s = fmaf(j, l, s);
        e = fmaf(u, m, e);
        f = fmaf(v, m, f);
        g = fmaf(i, m, g);
        h = fmaf(j, m, h);
    }
    out[0] = p;
    out[1] = q;
    out[2] = r;
    out[3] = s;
    next[0] = e;
    next[1] = f;
    next[2] = g;
    next[3] = h;
}

void fc_conv_run(const fc_conv *s, const float *in, float *out)
{
    const int32_t wide = s->taps * s->inputs, reach = s->taps / 2;
    const int32_t length = (s->samples - 1) / s->stride + 1;
    for (int32_t t = 0; t < length;) {
        /* Taps from low to before high meet a sample; two samples go together where all do. */
        const int32_t start = t * s->stride - reach, after = start + s->stride;
        const int32_t low = start < 0 ? -start : 0;
        const int32_t left = s->samples - start, high = left < s->taps ? left : s->taps;
        const int32_t n = (high - low) * s->inputs;
        const bool both = t + 1 < length && start >= 0 && after + s->taps <= s->samples;
        const float *const x = in + (start + low) * s->inputs;
        const float *w = s->weight + low * s->inputs;
        float *const to = out + t * s->outputs;
        int32_t o = 0;
        for (; o + 4 <= s->outputs; o += 4, w += 4 * wide)
            if (both)
                eight(w, wide, s->bias + o, x, x + s->stride * s->inputs, n, to + o,
                      to + s->outputs + o);
            else
                four(w, wide, s->bias + o, x, n, to + o);
        for (; o < s->outputs; o++, w += wide)
            for (int32_t k = 0; k <= both; k++) {
                const float *const seen = x + k * s->stride * s->inputs;
                float sum = s->bias[o];
                for (int32_t i = 0; i < n; i++)
                    sum = fmaf(w[i], seen[i], sum);
                to[k * s->outputs + o] = sum;
            }
        t += both ? 2 : 1;
    }
}

void fc_depthwise_run(const fc_depthwise *s, const float *in, float *out)
{
    const int32_t length = (s->samples - 1) / s->stride + 1;
    for (int32_t t = 0; t < length; t++, out += s->channels) {
        for (int32_t c = 0; c < s->channels; c++)
            out[c] = s->bias[c];
        for (int32_t k = 0; k < s->taps; k++) {
            const int32_t at = t * s->stride - s->taps / 2 + k;
            const float *const w = s->weight + k * s->channels, *const x = in + at * s->channels;
            if (at < 0 || at >= s->samples)
                continue;
            for (int32_t c = 0; c < s->channels; c++)
                out[c] = fmaf(w[c], x[c], out[c]);
        }
    }
}

void fc_silu_run(const fc_silu *s, const float *in, float *out)
{
    for (int32_t k = 0; k < s->size; k++)
        out[k] = in[k] * logistic(in[k]);
}

void fc_gate_run(const fc_gate *s, const float *in, const float *by, float *out)
{
    for (int32_t c = 0; c < s->channels; c++) {
        const float share = logistic(by[c]);
        for (int32_t k = c; k < s->samples * s->channels; k += s->channels)
            out[k] = in[k] * share;
    }
}

void fc_plus_run(const fc_plus *s, const float *in, const float *other, float *out)
{
    for (int32_t k = 0; k < s->size; k++)
        out[k] = in[k] + other[k];
}

void fc_means_run(const fc_means *s, const float *in, float *out)
{
    for (int32_t c = 0; c < s->channels; c++) {
        float sum = 0.0f;
        for (int32_t k = c; k < s->samples * s->channels; k += s->channels)
            sum += in[k];
        out[c] = sum / (float)s->samples;
    }
}
