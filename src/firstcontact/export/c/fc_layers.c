#include "fc_layers.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "fc_math.h"

/* x / (1 + exp(-by)), relative error below 5e-6; by beyond 60 on either side, or no number, is
   taken for 60 there. */
static inline float shared(float x, float by)
{
    /* exp(-by) = 2^(n + r); n by adding and taking off 1.5 * 2^23, whose low bits then hold it. */
    const float held = fminf(fmaxf(by, -60.0f), 60.0f);
    const float turned = fmaf(held, -1.44269504f, 12582912.0f), n = turned - 12582912.0f;
    const float r = fmaf(held, -1.44269504f, -n);
    float y = fmaf(9.5677385e-3f, r, 5.5917498e-2f);
    y = fmaf(y, r, 2.4024811e-1f);
    y = fmaf(y, r, 6.931219e-1f);
    y = fmaf(y, r, 9.999992e-1f);
    uint32_t power, bits;
    memcpy(&power, &turned, sizeof power);
    memcpy(&bits, &y, sizeof bits);
    bits += power << 23;
    memcpy(&y, &bits, sizeof y);
    return x / (1.0f + y);
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

/* Written out where it is called, with what is known there. */
#if defined(__GNUC__)
#define FC_INLINE inline __attribute__((always_inline))
#else
#define FC_INLINE inline
#endif

/* Four sums that grow side by side. */
typedef struct {
    float p, q, r, s;
} four;

static inline void grow(four *sum, four w, float x)
{
    sum->p = fmaf(w.p, x, sum->p);
    sum->q = fmaf(w.q, x, sum->q);
    sum->r = fmaf(w.r, x, sum->r);
    sum->s = fmaf(w.s, x, sum->s);
}

static inline void put(float *out, four sum)
{
    out[0] = sum.p;
    out[1] = sum.q;
    out[2] = sum.r;
    out[3] = sum.s;
}

/* One sample of all outputs in fours; weights of one output lie apart from those of the next. */
static void one(const fc_conv *s, const float *w, const float *x, int32_t n, float *out)
{
    const int32_t apart = s->taps * s->inputs;
    const float *b = s->bias;
    for (const float *const end = b + s->outputs / 4 * 4; b < end; b += 4, out += 4) {
        const float *const v = w + apart, *const u = v + apart, *const t = u + apart;
        four sum = {b[0], b[1], b[2], b[3]};
        for (int32_t k = 0; k < n; k++)
            grow(&sum, (four){w[k], v[k], u[k], t[k]}, x[k]);
        put(out, sum);
        w = t + apart;
    }
}

/* Four samples of them, or five: each weight is read once for all, and sums stay in registers. */
static FC_INLINE void side(const fc_conv *s, const float *w, const float *x, int32_t n, bool five,
                        float *out)
{
    const int32_t apart = s->taps * s->inputs, further = s->stride * s->inputs;
    const float *b = s->bias;
    for (const float *const end = b + s->outputs / 4 * 4; b < end; b += 4, out += 4) {
        const float *const v = w + apart, *const u = v + apart, *const t = u + apart;
        const float *const y = x + further, *const z = y + further;
        const float *const i = z + further, *const j = i + further * five;
        four c = {b[0], b[1], b[2], b[3]}, d = c, e = c, f = c, g = c;
        for (int32_t k = 0; k < n; k++) {
            const four each = {w[k], v[k], u[k], t[k]};
            grow(&c, each, x[k]);
            grow(&d, each, y[k]);
            grow(&e, each, z[k]);
            grow(&f, each, i[k]);
            if (five)
                grow(&g, each, j[k]);
        }
        float *to = out;
        put(to, c);
        put(to += s->outputs, d);
        put(to += s->outputs, e);
        put(to += s->outputs, f);
        if (five)
            put(to + s->outputs, g);
        w = t + apart;
    }
}

void fc_conv_run(const fc_conv *s, const float *in, float *out)
{
    const int32_t wide = s->taps * s->inputs, reach = s->taps / 2;
    const int32_t length = (s->samples - 1) / s->stride + 1;
    /* Taps of outputs before this one all meet a sample, unless they begin before the first. */
    const int32_t whole = (s->samples - s->taps + reach) / s->stride + 1;
    for (int32_t t = 0, many; t < length; t += many, out += many * s->outputs) {
        const int32_t start = t * s->stride - reach, low = start < 0 ? -start : 0;
        const int32_t left = s->samples - start, high = left < s->taps ? left : s->taps;
        const int32_t n = (high - low) * s->inputs, more = start < 0 ? 0 : whole - t;
        const float *const x = in + (start + low) * s->inputs;
        const float *const w = s->weight + low * s->inputs;
        many = more > 4 && more % 4 != 0 ? 5 : more >= 4 ? 4 : 1;
        if (many == 5)
            side(s, w, x, n, true, out);
        else if (many == 4)
            side(s, w, x, n, false, out);
        else
            one(s, w, x, n, out);
        for (int32_t o = s->outputs / 4 * 4; o < s->outputs; o++)
            for (int32_t k = 0; k < many; k++) {
                const float *const seen = x + k * s->stride * s->inputs;
                float sum = s->bias[o];
                for (int32_t i = 0; i < n; i++)
                    sum = fmaf(w[o * wide + i], seen[i], sum);
                out[k * s->outputs + o] = sum;
            }
    }
}

/* A sample of each channel that all of three taps meet. */
static void three(const fc_depthwise *s, const float *x, float *out)
{
    const int32_t n = s->channels;
    const float *const w = s->weight, *const v = w + n, *const u = v + n;
    const float *const y = x + n, *const z = y + n;
    for (int32_t c = 0; c < n; c++)
        out[c] = fmaf(u[c], z[c], fmaf(v[c], y[c], fmaf(w[c], x[c], s->bias[c])));
}

void fc_depthwise_run(const fc_depthwise *s, const float *in, float *out)
{
    const int32_t length = (s->samples - 1) / s->stride + 1;
    for (int32_t t = 0; t < length; t++, out += s->channels) {
        const int32_t start = t * s->stride - s->taps / 2;
        if (s->taps == 3 && start >= 0 && start + 3 <= s->samples) {
            three(s, in + start * s->channels, out);
            continue;
        }
        for (int32_t c = 0; c < s->channels; c++)
            out[c] = s->bias[c];
        for (int32_t k = 0; k < s->taps; k++) {
            const int32_t at = start + k;
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
    int32_t k = 0;
    for (; k + 2 <= s->size; k += 2) {
        out[k] = shared(in[k], in[k]);
        out[k + 1] = shared(in[k + 1], in[k + 1]);
    }
    if (k < s->size)
        out[k] = shared(in[k], in[k]);
}

void fc_gate_run(const fc_gate *s, const float *in, const float *by, float *out)
{
    /* Shares lie where the first sample comes to lie at last. */
    for (int32_t c = 0; c < s->channels; c++)
        out[c] = by[c] == by[c] ? shared(1.0f, by[c]) : by[c];
    for (int32_t t = s->samples - 1; t >= 0; t--)
        for (int32_t c = 0; c < s->channels; c++)
            out[t * s->channels + c] = in[t * s->channels + c] * out[c];
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
