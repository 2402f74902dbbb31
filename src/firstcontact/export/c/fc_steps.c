#include "fc_steps.h"

#include <math.h>
#include <stdbool.h>

#include "fc_math.h"

/* out[i] = weight[i] . x + bias[i] of eight rows side by side: each number of x is read once for
   them, and eight sums grow independently of each other. */
static void eight(const float *weight, const float *bias, int32_t inputs, const float *x, float *out)
{
    const float *const a = weight, *const b = a + inputs, *const c = b + inputs;
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

static void four(const float *weight, const float *bias, int32_t inputs, const float *x, float *out)
{
    const float *const a = weight, *const b = a + inputs;
    const float *const c = b + inputs, *const d = c + inputs;
    float p = bias[0], q = bias[1], r = bias[2], s = bias[3];
    for (int32_t k = 0; k < inputs; k++) {
        p = fmaf(a[k], x[k], p);
        q = fmaf(b[k], x[k], q);
        r = fmaf(c[k], x[k], r);
        s = fmaf(d[k], x[k], s);
    }
    out[0] = p;
    out[1] = q;
    out[2] = r;
    out[3] = s;
}

static void one(const float *weight, const float *bias, int32_t inputs, const float *x, float *out)
{
    float p = *bias;
    for (int32_t k = 0; k < inputs; k++)
        p = fmaf(weight[k], x[k], p);
    *out = p;
}

/* Of n rows, as many together as there are; the last of them are not done one by one but begin
   among those before them. */
static void rows(const float *weight, const float *bias, int32_t n, int32_t inputs, const float *x,
                 float *out)
{
    const int32_t many = n >= 8 ? 8 : n >= 4 ? 4 : 1;
    for (int32_t i = 0; i < n; i += many) {
        const int32_t from = i + many <= n ? i : n - many;
        (many == 8 ? eight : many == 4 ? four : one)(weight + from * inputs, bias + from, inputs, x,
                                                     out + from);
    }
}

void fc_shape_and_level_run(const fc_shape_and_level *s, const float *in, float *out)
{
    double power = 0.0;
    for (int32_t k = 0; k < s->samples; k++)
        power += (double)in[k] * in[k];
    const double rms = sqrt(power / s->samples);
    const float scale = (float)(1.0 / rms);
    for (int32_t k = 0; k < s->samples; k++)
        out[k] = in[k] * scale;
    const bool held = power > s->least && power < s->most;
    out[s->samples] = held ? (float)((fc_log(rms) - s->mean) * s->slope) : NAN;
}

void fc_rbf_run(const fc_rbf *s, const float *in, float *out)
{
    double square = 0.0;
    for (int32_t k = 0; k < s->inputs; k++)
        square += (double)in[k] * in[k];
    const float far = (float)(s->gamma * square);
    rows(s->steep, s->norms, s->vectors, s->inputs, in, out);
    for (int32_t i = 0; i < s->vectors; i++) {
        const float power = out[i] - far;
        out[i] = power == power ? fc_expf(power) : power;
    }
}

void fc_dense_run(const fc_dense *s, const float *in, float *out)
{
    rows(s->weight, s->bias, s->outputs, s->inputs, in, out);
}

void fc_votes_run(const fc_votes *s, const float *in, float *out)
{
    for (int32_t i = 0; i < s->classes; i++)
        out[i] = 0.0f;
    for (int32_t i = 0; i < s->classes; i++)
        for (int32_t j = i + 1; j < s->classes; j++) {
            out[*in > s->least ? i : j] += 1.0f;
            if (!(*in - *in == 0.0f))
                out[0] = NAN; /* an infinite decision speaks for nothing */
            in++;
        }
}

void fc_given_run(const fc_given *s, const float *in, float *out)
{
    (void)in;
    for (int32_t i = 0; i < s->outputs; i++)
        out[i] = s->values[i];
}

void fc_log_peak_run(const fc_log_peak *s, const float *in, float *out)
{
    float peak = 0.0f;
    for (int32_t k = 0; k < s->samples; k++) {
        const float size = fabsf(in[k]);
        peak = size > peak ? size : peak;
    }
    *out = (float)fc_log(peak);
}

void fc_parabola_run(const fc_parabola *s, const float *in, float *out)
{
    const double x = *in, y = (s->a * x + s->b) * x + s->c;
    *out = (float)(y < s->low ? s->low : y > s->high ? s->high : y);
}

void fc_nearness_run(const fc_nearness *s, const float *in, float *out)
{
    for (int32_t i = 0; i < s->outputs; i++)
        out[i] = -fabsf(*in - s->places[i]);
}

void fc_deviation_run(const fc_deviation *s, const float *in, float *out)
{
    const float *row = s->lower;
    double known = 0.0;
    for (int32_t i = 0; i < s->inputs; row += ++i) {
        float y = 0.0f;
        for (int32_t k = 0; k <= i; k++)
            y = fmaf(row[k], in[k], y);
        known += (double)y * y;
    }
    const double left = s->most - known;
    *out = (float)(s->scale * sqrt(left > s->least ? left : s->least));
}
