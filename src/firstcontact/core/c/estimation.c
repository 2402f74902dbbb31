#include "kernels.h"

#include <math.h>

static const double LEAST = 1e-4, STILL = 0.5;
static const double CENTRE = 40.0, UNIT = 40.0, MEAN_SCALE = 0.6;
static const float NARROWEST = -4.0f, WIDEST = 2.0f, FARTHEST = 6.0f;
static const double LARGEST = 10.0, LENGTH = 2.0, LINEAR = 1.0, NOISE = 0.3;

enum { LENGTH_FEATURE = 11 };

static double bounded(double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}

/* Add the products of inputs and rows of weights. Outputs side by side need no sum in a register. */
WIDE static void add_products(const float *restrict weight, const float *restrict x, int32_t inputs,
                              int32_t outputs, float *restrict out)
{
    int32_t k = 0;
    for (; k + 4 <= inputs; k += 4, weight += 4 * outputs) {
        const float *const a = weight, *const b = a + outputs, *const c = b + outputs,
                           *const d = c + outputs;
        const float p = x[k], q = x[k + 1], r = x[k + 2], s = x[k + 3];
        for (int32_t j = 0; j < outputs; j++)
            out[j] += (a[j] * p + b[j] * q) + (c[j] * r + d[j] * s);
    }
    for (; k < inputs; k++, weight += outputs)
        for (int32_t j = 0; j < outputs; j++)
            out[j] += weight[j] * x[k];
}

static void run(const fc_layer *layer, const float *bias, const float *x, float *out)
{
    for (int32_t j = 0; j < layer->outputs; j++)
        out[j] = bias[j];
    add_products(layer->weight, x, layer->inputs, layer->outputs, out);
}

static void silu(float *x, int32_t n)
{
    for (int32_t j = 0; j < n; j++)
        x[j] = x[j] / (1.0f + expf(x[j] < -60.0f ? 60.0f : -x[j]));
}

static float scaled(const fc_network *n, int32_t k, double x)
{
    const float y = ((float)x - n->mean[k]) / n->sd[k];
    return y < -FARTHEST ? -FARTHEST : y > FARTHEST ? FARTHEST : y;
}

void fc_network_prepare(fc_network *n)
{
    for (int32_t k = 0; k < 3 * POINTS; k++)
        n->absent[k] = scaled(n, k, 0.0);
    for (int32_t j = 0; j < n->query1.outputs; j++)
        n->rest[j] = n->query1.bias[j];
    add_products(n->query1.weight, n->absent, 3 * POINTS, n->query1.outputs, n->rest);
}

/* Features of the contact so far, then noise and share of repeated samples. Return the peak. */
static double features(const double *v, int32_t n, double level, double noise, double *f)
{
    const double least = LEAST * level, scale = POINTS / 74.0;
    double top = v[0], rise = 0.0, energy = 0.0, moment = 0.0, rough = 0.0, low = 1.0;
    int32_t at = 0, tenth = 0, half = 0, width = 0, flat = 0;
    for (int32_t k = 0; k < n; k++) {
        const double square = v[k] * v[k];
        energy += square;
        moment += square * k;
        if (v[k] > top) {
            top = v[k];
            at = k;
        }
        if (k + 1 < n) {
            const double step = v[k + 1] - v[k];
            rise = step > rise ? step : rise;
            rough += step * step;
            flat += step == 0.0;
        }
    }
    if (n < POINTS && top < 0.0) { /* samples that are not there yet count as 0 */
        top = 0.0;
        at = n;
    }
    const double peak = top > least ? top : least;
    int32_t low_at = at;
    for (int32_t k = 0; k < POINTS; k++) {
        const double relative = k < n ? v[k] / peak : 0.0;
        tenth += k <= at && relative < 0.1;
        half += k <= at && relative < 0.5;
        width += relative > 0.5;
        if (k > at && k < n && (low_at == at || relative < low)) {
            low = relative;
            low_at = k;
        }
    }
    const double total = energy + LEAST * LEAST * level * level;
    const double last = v[n - 1] / peak, earlier = v[n > 4 ? n - 4 : 0] / peak;
    f[0] = log(peak / level);
    f[1] = log((rise > least ? rise : least) / level);
    f[2] = at / (20.0 * scale) - 1.0;
    f[3] = tenth / (10.0 * scale) - 0.5;
    f[4] = half / (10.0 * scale) - 0.5;
    f[5] = width / (20.0 * scale) - 0.5;
    f[6] = log(rough / total + 1e-4) + 2.0;
    f[7] = low;
    f[8] = low_at / (40.0 * scale) - 1.0;
    f[9] = log(sqrt(total / n) / level);
    f[10] = moment / total / (20.0 * scale) - 1.0;
    f[LENGTH_FEATURE] = n / (37.0 * scale) - 1.0;
    f[12] = last;
    f[13] = last - earlier;
    f[FEATURES] = noise;
    f[FEATURES + 1] = 10.0 * ((double)flat / (n - 1));
    return peak;
}

/* First layer: what absent samples give, and the differences of those that are there. */
static void first_layer(const fc_network *n, double level, const double *v, int32_t valid, double peak,
                        const double *f, const double *beside, float *out)
{
    const fc_layer *const layer = &n->query1;
    float x[POINTS];
    for (int32_t j = 0; j < layer->outputs; j++)
        out[j] = n->rest[j];
    for (int32_t wave = 0; wave < 3; wave++) {
        const int32_t at = wave * POINTS;
        for (int32_t k = 0; k < valid; k++) {
            const double size = log1p(fabs(v[k]) * (2.0 / level)) / 2.0;
            const double y = wave == 0 ? copysign(size, v[k]) : wave == 1 ? v[k] / peak : 1.0;
            x[k] = scaled(n, at + k, y) - n->absent[at + k];
        }
        add_products(layer->weight + at * layer->outputs, x, valid, layer->outputs, out);
    }
    for (int32_t k = 0; k < FEATURES + BESIDE; k++)
        x[k] = scaled(n, 3 * POINTS + k, k < FEATURES ? f[k] : beside[k - FEATURES]);
    add_products(layer->weight + 3 * POINTS * layer->outputs, x, FEATURES + BESIDE, layer->outputs,
                 out);
    silu(out, layer->outputs);
}

/* Each head weighs the levels of the rig. */
static void attend(const fc_network *n, const fc_rig *r, int32_t stage, const float *query, float *out)
{
    const int32_t levels = r->levels, each = n->query2.outputs / HEADS;
    const float root = sqrtf((float)each);
    const int32_t other = (n->body1.inputs - n->query1.outputs) / HEADS;
    for (int32_t h = 0; h < HEADS; h++) {
        const float *const keys = r->keys + (stage * HEADS + h) * levels * each;
        const float *const values = r->values + (stage * HEADS + h) * levels * other;
        float share[LEVELS_MOST], most = -INFINITY, sum = 0.0f;
        for (int32_t l = 0; l < levels; l++) {
            float fit = 0.0f;
            for (int32_t k = 0; k < each; k++)
                fit += query[h * each + k] * keys[l * each + k];
            share[l] = fit / root;
            most = share[l] > most ? share[l] : most;
        }
        for (int32_t l = 0; l < levels; l++) {
            share[l] = expf(share[l] - most);
            sum += share[l];
        }
        for (int32_t k = 0; k < other; k++)
            out[h * other + k] = 0.0f;
        for (int32_t l = 0; l < levels; l++)
            for (int32_t k = 0; k < other; k++)
                out[h * other + k] += share[l] / sum * values[l * other + k];
    }
}

/* Mean and spread of a mixture of normal distributions. */
static void moments(const float *raw, double *mean_of_all, double *spread_of_all)
{
    double sum = 0.0, value = 0.0, square = 0.0, most = raw[0];
    for (int32_t k = 1; k < COMPONENTS; k++)
        most = raw[k] > most ? raw[k] : most;
    for (int32_t k = 0; k < COMPONENTS; k++) {
        const double weight = exp(raw[k] - most), spread = raw[2 * COMPONENTS + k];
        const double mean = raw[COMPONENTS + k] * (UNIT * MEAN_SCALE) + CENTRE;
        const double sd = UNIT * exp(bounded(spread, NARROWEST, WIDEST));
        sum += weight;
        value += weight * mean;
        square += weight * (sd * sd + mean * mean);
    }
    value /= sum;
    const double variance = square / sum - value * value;
    *mean_of_all = value;
    *spread_of_all = sqrt(variance > 1e-4 ? variance : 1e-4);
}

/* k' A k, and A is (n, n). */
WIDE static double quadratic(const double *restrict a, const double *restrict k, int32_t n)
{
    double product[KNOWN_MOST], out = 0.0;
    for (int32_t j = 0; j < n; j++)
        product[j] = 0.0;
    for (int32_t i = 0; i < n; i++, a += n)
        for (int32_t j = 0; j < n; j++)
            product[j] += a[j] * k[i];
    for (int32_t j = 0; j < n; j++)
        out += product[j] * k[j];
    return out;
}

/* Mix the prediction with the regression's, weighted by the inverse of their variances. */
static void refine(const fc_regression *r, int32_t stage, const double *f, double first_beside,
                   double *value, double *spread)
{
    const int32_t n = r->n;
    double x[KNOWN], kernel[KNOWN_MOST], square = 0.0, sum = 0.0;
    for (int32_t k = 0; k < KNOWN; k++) {
        const double y = bounded(k < FEATURES ? f[k] : first_beside, -LARGEST, LARGEST);
        x[k] = (y - r->mean[stage * KNOWN + k]) / r->sd[stage * KNOWN + k];
        square += x[k] * x[k];
    }
    for (int32_t i = 0; i < n; i++)
        kernel[i] = 0.0;
    for (int32_t k = 0; k < KNOWN; k++)
        for (int32_t i = 0; i < n; i++)
            kernel[i] += r->known[(stage * KNOWN + k) * n + i] * x[k];
    for (int32_t i = 0; i < n; i++) {
        const double apart = r->squares[stage * n + i] + square - 2.0 * kernel[i];
        const double smooth = exp((apart > 0.0 ? apart : 0.0) * (-1.0 / (2.0 * LENGTH * LENGTH * KNOWN)));
        kernel[i] = 1.0 + kernel[i] * (LINEAR / KNOWN) + smooth;
        sum += kernel[i] * r->weights[stage * n + i];
    }
    const double prior = 2.0 + LINEAR * square / KNOWN;
    const double left = prior - quadratic(r->inverse + (ptrdiff_t)stage * n * n, kernel, n);
    const double other = bounded(r->centre + r->unit * sum, 0.0, 100.0);
    const double own = r->unit * sqrt((left > 0.0 ? left : 0.0) + NOISE) * r->scale[stage];
    const double share = own * own / (own * own + *spread * *spread);
    const double variance = share * *spread * *spread + (1.0 - share) * own * own;
    const double difference = *value - other;
    const double mixed = share * *value + (1.0 - share) * other;
    *spread = sqrt(variance + share * (1.0 - share) * difference * difference);
    *value = mixed;
}

static bool is_out_of_range(const fc_network *n, bool has_level, int32_t stage, const double *f)
{
    double away[TRAITS], distance = 0.0, share = 0.0, length = 0.0;
    if (!has_level && f[TRAITS - 1] > 10.0 * STILL)
        return true;
    for (int32_t k = 0; k < TRAITS; k++)
        away[k] = f[k] - n->usual[stage * TRAITS + k];
    away[LENGTH_FEATURE] = 0.0; /* at a stage all have the same length */
    for (int32_t i = 0; i < TRAITS; i++) {
        const double *const row = n->whitening + (stage * TRAITS + i) * TRAITS;
        double y = 0.0, gain = 0.0;
        for (int32_t k = 0; k < TRAITS; k++) {
            y += row[k] * away[k];
            gain += row[k] * n->gain[k];
        }
        distance += y * y;
        share += y * gain;
        length += gain * gain;
    }
    if (!has_level) { /* no level: the gain with the smallest distance */
        distance -= share * share / (length > 1e-60 ? length : 1e-60);
        distance = distance > 0.0 ? distance : 0.0;
    }
    return sqrt(distance) > n->limit[stage];
}

void fc_predict(const fc_network *n, const fc_rig *r, const float *signal, int32_t valid,
                int32_t stage, const double *beside, double noise, fc_estimate *out)
{
    double v[POINTS] = {0.0}, f[TRAITS], value, spread;
    float body[2 * UNITS_MOST], query[UNITS_MOST], hidden[UNITS_MOST], next[UNITS_MOST];
    float raw[3 * COMPONENTS];
    for (int32_t k = 0; k < valid; k++)
        v[k] = r->sign * (double)signal[k];
    const double peak = features(v, valid, r->level, noise, f);
    first_layer(n, r->level, v, valid, peak, f, beside, body);
    run(&n->query2, n->query2.bias, body, query);
    attend(n, r, stage, query, body + n->query1.outputs);
    run(&n->body1, r->along + stage * n->body1.outputs, body, hidden);
    silu(hidden, n->body1.outputs);
    run(&n->body2, n->body2.bias, hidden, next);
    silu(next, n->body2.outputs);
    run(&n->body3, n->body3.bias, next, hidden);
    silu(hidden, n->body3.outputs);
    run(&n->answer, n->answer.bias, hidden, raw);
    moments(raw, &value, &spread);
    if (r->regression.n > 0)
        refine(&r->regression, stage, f, beside[0], &value, &spread);
    const double half = spread * n->factors[stage];
    out->is_finite = isfinite(value + half);
    out->value = bounded(value, 0.0, 100.0);
    out->low = bounded(out->value - half, 0.0, 100.0);
    out->high = bounded(out->value + half, 0.0, 100.0);
    out->half_width = half;
    out->is_out_of_range = is_out_of_range(n, r->levels > 0, stage, f);
}
