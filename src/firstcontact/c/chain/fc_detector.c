#include "fc_detector.h"

#include <string.h>

#include "fc_assert.h"
#include "fc_math.h"

/* A later steady state replaces the earlier one if its sigma is below this share of the earlier. */
static const double QUIETER = 0.9;
/* Share of white noise that regularises the linear prediction. */
static const double RIDGE = 1e-3;
/* A new linear prediction takes as long as so many looks. */
enum { LOOKS_OF_PREDICTION = 4 };

void fc_detector_restart(fc_detector *d, int64_t first)
{
    d->is_settled = false;
    d->settles = first + d->constants->steady;
    d->next = d->settles + d->constants->step;
}

/* Measure mean and sigma of n samples before `end`. */
static void measure(const fc_past *past, int32_t channel, int64_t end, int32_t n, double *mean,
                    double *sigma)
{
    const double first = fc_past_at(past, channel, end - n);
    double sum = 0.0, squares = 0.0;
    bool varies = false;
    for (int64_t k = end - n; k < end; k++) {
        const double x = fc_past_at(past, channel, k);
        sum += x;
        varies |= x != first;
    }
    *mean = sum / n;
    for (int64_t k = end - n; k < end; k++) {
        const double x = fc_past_at(past, channel, k) - *mean;
        squares += x * x;
    }
    *sigma = varies ? sqrt(squares / n) : 0.0;
}

/* Return the error of predicting x[i] from the samples before it. weights[0] scales x[i].
   Four weights at a time, so that sums are loaded and stored less often. */
FC_WIDE static void prediction_error(const double *restrict x, const double *restrict weights,
                                     int32_t n, double *restrict out)
{
    for (int32_t i = FC_ORDER; i < n; i++)
        out[i] = weights[0] * x[i];
    for (int32_t k = 1; k <= FC_ORDER; k += 4) {
        const double a = weights[k], b = weights[k + 1], c = weights[k + 2], d = weights[k + 3];
        for (int32_t i = FC_ORDER; i < n; i++)
            out[i] = (((out[i] + a * x[i - k]) + b * x[i - k - 1]) + c * x[i - k - 2])
                     + d * x[i - k - 3];
    }
}

/* Solve the Yule-Walker equations by Levinson's recursion. */
void fc_fit_prediction(const double *x, int32_t n, double *error, double *weights)
{
    double lags[FC_ORDER + 1], previous[FC_ORDER + 1], left, mean = 0.0, squares = 0.0;
    memset(weights, 0, sizeof(double) * (FC_ORDER + 1));
    for (int32_t k = 0; k <= FC_ORDER; k++) {
        lags[k] = 0.0;
        for (int32_t i = k; i < n; i++)
            lags[k] += x[i - k] * x[i];
        lags[k] /= n;
    }
    if (!(lags[0] > 0.0))
        return;
    lags[0] *= 1.0 + RIDGE;
    weights[0] = 1.0;
    left = lags[0];
    for (int32_t k = 1; k <= FC_ORDER; k++) {
        double sum = lags[k];
        for (int32_t j = 1; j < k; j++)
            sum += weights[j] * lags[k - j];
        const double reflection = -sum / left;
        memcpy(previous, weights, sizeof previous);
        for (int32_t j = 1; j < k; j++)
            weights[j] = previous[j] + reflection * previous[k - j];
        weights[k] = reflection;
        left *= 1.0 - reflection * reflection;
    }
    prediction_error(x, weights, n, error);
    for (int32_t i = FC_ORDER; i < n; i++)
        mean += error[i];
    mean /= n - FC_ORDER;
    for (int32_t i = FC_ORDER; i < n; i++)
        squares += (error[i] - mean) * (error[i] - mean);
    const double sigma = sqrt(squares / (n - FC_ORDER));
    for (int32_t k = 0; k <= FC_ORDER; k++)
        weights[k] = sigma > 0.0 ? weights[k] / sigma : 0.0;
}

/* Fit the prediction to the steady state before `end`, whose mean and sigma are known. */
static void learn(fc_detector *d, const fc_past *past, int32_t channel, int64_t end)
{
    const int32_t n = d->constants->steady;
    if (d->constants->kind != FC_DETECTOR_LOGISTIC || !(d->sigma[channel] > 0.0))
        return;
    double *const x = d->window;
    d->effort += LOOKS_OF_PREDICTION;
    for (int32_t i = 0; i < n; i++)
        x[i] = (fc_past_at(past, channel, end - n + i) - d->mean[channel]) / d->sigma[channel];
    fc_fit_prediction(x, n, d->work, d->weights[channel]);
    for (int32_t k = 0; k < FC_LOOKS_MOST; k++)
        d->looks[channel][k].end = -1;
}

/* Pass the steady state before `end` to the program, in sigmas. */
static void pass_steady_state(fc_detector *d, const fc_past *past, int64_t end)
{
    if (d->constants->kind != FC_DETECTOR_PROGRAM)
        return;
    const int32_t n = d->constants->steady;
    for (int32_t i = 0; i < n; i++)
        for (int32_t c = 0; c < d->channels; c++)
            d->window[i * d->channels + c]
                = d->sigma[c] > 0.0
                      ? (fc_past_at(past, c, end - n + i) - d->mean[c]) / d->sigma[c] : 0.0;
    d->program.settled(d->program.context, d->window);
}

void fc_detector_settle(fc_detector *d, const fc_past *past, int64_t end)
{
    FC_ASSERT(d != NULL && past != NULL && end >= 0);
    for (int32_t c = 0; c < d->channels; c++) {
        measure(past, c, end, d->constants->steady, d->mean + c, d->sigma + c);
        learn(d, past, c, end);
    }
    d->is_settled = true;
    pass_steady_state(d, past, end);
}

void fc_detector_resettle(fc_detector *d, const fc_past *past, int64_t end)
{
    bool any = false;
    for (int32_t c = 0; c < d->channels; c++) {
        double mean, sigma;
        measure(past, c, end, d->constants->steady, &mean, &sigma);
        if (!(sigma > 0.0 && sigma < QUIETER * d->sigma[c]))
            continue;
        d->mean[c] = mean;
        d->sigma[c] = sigma;
        learn(d, past, c, end);
        any = true;
    }
    if (any)
        pass_steady_state(d, past, end);
}

static double larger(double a, double b)
{
    return b > a ? b : a;
}

/* Write the loudness features of one signal. `power` holds the squares of its samples, without the
   first `first` ones. */
static void loudness(const fc_detector_constants *k, const double *power, int32_t first, int32_t n,
                     double *features)
{
    const int32_t recent = n - k->lengths[FC_PARTS], newest = n - k->lengths[FC_PARTS - 1];
    double quiet = 0.0, between = 0.0, sum = 0.0, quiet_top = 0.0, top = 0.0;
    double logs[FC_LEVELS + 1];
    int32_t i = 0;
    for (; i < recent; i++) {
        quiet += power[i];
        quiet_top = larger(quiet_top, power[i]);
    }
    for (; i < newest; i++)
        between += power[i];
    i = n;
    for (int32_t p = 0; p < FC_PARTS; p++) {
        for (; i > n - k->lengths[p]; i--) {
            sum += power[i - 1];
            top = larger(top, power[i - 1]);
        }
        logs[1 + p] = sum / k->lengths[p];
    }
    logs[0] = quiet / (recent - first);
    logs[FC_PARTS + 1] = between / (newest - recent);
    logs[FC_PARTS + 2] = top;
    logs[FC_PARTS + 3] = quiet_top;
    for (int32_t j = 0; j <= FC_LEVELS; j++)
        logs[j] = fc_log(sqrt(logs[j]) + k->floor);
    features[0] = logs[0];
    for (int32_t j = 1; j <= FC_PARTS + 1; j++)
        features[j] = logs[j] - logs[0];
    features[FC_LEVELS - 1] = logs[FC_PARTS + 2] - logs[FC_PARTS + 3];
}

void fc_look_features(const fc_detector_constants *k, const double *x, int32_t n,
                      const double *weights, double *power, double *features)
{
    const int32_t recent = n - k->lengths[FC_PARTS];
    double quiet = 0.0;
    for (int32_t i = 0; i < recent; i++)
        quiet += x[i];
    quiet /= recent;
    for (int32_t i = 0; i < n; i++)
        power[i] = (x[i] - quiet) * (x[i] - quiet);
    loudness(k, power, 0, n, features);
    memset(power, 0, sizeof(double) * FC_ORDER);
    prediction_error(x, weights, n, power);
    for (int32_t i = FC_ORDER; i < n; i++)
        power[i] *= power[i];
    loudness(k, power, FC_ORDER, n, features + FC_LEVELS);
}

/* Return the score of a look of n samples, in sigmas. A score above 0 shows a contact. */
static double look_score(const fc_detector_constants *k, const double *x, int32_t n,
                         const double *weights, double *power)
{
    double features[2 * FC_LEVELS], score = 0.0;
    fc_look_features(k, x, n, weights, power, features);
    for (int32_t j = 0; j < 2 * FC_LEVELS; j++)
        score += features[j] * k->line[j];
    return score + k->line[2 * FC_LEVELS];
}

/* Return the place of the look that ends before sample `end`; the oldest one if it is not stored. */
static fc_look *place_of_look(fc_look *looks, int64_t end)
{
    fc_look *oldest = looks;
    for (fc_look *look = looks; look < looks + FC_LOOKS_MOST; look++) {
        if (look->end == end)
            return look;
        oldest = look->end < oldest->end ? look : oldest;
    }
    return oldest;
}

/* Return true if all looks of a window show a contact. Neighbouring windows share looks. */
static bool looks_agree(fc_detector *d, const double *window, int64_t window_end, int32_t channel)
{
    const fc_detector_constants *const k = d->constants;
    const int32_t length = k->window - (k->looks - 1) * k->step;
    for (int32_t look = k->looks - 1; look >= 0; look--) {
        const int64_t end = window_end - (int64_t)(k->looks - 1 - look) * k->step;
        fc_look *const place = place_of_look(d->looks[channel], end);
        if (place->end != end) {
            d->effort++;
            place->end = end;
            place->score
                = look_score(k, window + look * k->step, length, d->weights[channel], d->work);
        }
        if (!(place->score > 0.0))
            return false;
    }
    return true;
}

/* Return the index that best separates quiet from loud samples (Maeda 1985, Zisin 38, 365). It
   minimises k log var(x[:k]) + (n - k - 1) log var(x[k:]). */
static int32_t onset(const double *x, int32_t n, int32_t search)
{
    const int32_t first = n - search > FC_LEAST_LOUD ? n - search : FC_LEAST_LOUD;
    double sum = 0.0, squares = 0.0, all = 0.0, all_squares = 0.0, least = 0.0;
    int32_t best = -1;
    for (int32_t i = 0; i < n; i++) {
        all += x[i];
        all_squares += x[i] * x[i];
    }
    for (int32_t k = 1; k <= n - FC_LEAST_LOUD; k++) {
        sum += x[k - 1];
        squares += x[k - 1] * x[k - 1];
        if (k < first)
            continue;
        /* A millionth of the steady variance keeps the logarithm of a flat part finite. */
        const double left = k, right = n - k, a = sum / left, b = (all - sum) / right;
        const double quiet = larger(1e-6, squares / left - a * a);
        const double loud = larger(1e-6, (all_squares - squares) / right - b * b);
        const double criterion = left * fc_log(quiet) + (right - 1.0) * fc_log(loud);
        if (best < 0 || criterion < least) {
            least = criterion;
            best = k;
        }
    }
    return best;
}

/* Return true if any of the newest samples of a channel deviates far from its mean. */
static bool is_awake(const fc_detector *d, const fc_past *past, int32_t channel)
{
    for (int64_t k = past->end - d->constants->step; k < past->end; k++) {
        const double away = fc_past_at(past, channel, k) - d->mean[channel];
        if (fabs(away / d->sigma[channel]) > d->constants->threshold)
            return true;
    }
    return false;
}

void fc_detector_judge(fc_detector *d, const fc_past *past, const bool *is_skipped, int64_t *onsets)
{
    FC_ASSERT(d != NULL && past != NULL && onsets != NULL);
    const fc_detector_constants *const k = d->constants;
    const int64_t start = past->end - k->window;
    uint8_t fired[FC_CHANNELS_MOST] = {0};
    bool awake[FC_CHANNELS_MOST], any = k->kind == FC_DETECTOR_PROGRAM;
    d->next += k->step;
    for (int32_t c = 0; c < d->channels; c++) {
        onsets[c] = -1;
        awake[c] = !any && d->sigma[c] > 0.0 && is_awake(d, past, c);
    }
    for (int32_t c = 0; c < d->channels; c++)
        any |= awake[c];
    if (!any)
        return;
    for (int32_t c = 0; c < d->channels; c++) {
        double *const window = d->window + c * k->window;
        const bool is_alive = d->sigma[c] > 0.0;
        for (int32_t i = 0; i < k->window; i++)
            window[i] = is_alive ? (fc_past_at(past, c, start + i) - d->mean[c]) / d->sigma[c] : 0.0;
        if (!is_alive || is_skipped[c])
            continue;
        if (k->kind == FC_DETECTOR_THRESHOLD)
            fired[c] = awake[c];
        else if (k->kind == FC_DETECTOR_LOGISTIC)
            fired[c] = looks_agree(d, window, past->end, c);
    }
    if (k->kind == FC_DETECTOR_PROGRAM)
        d->program.judge(d->program.context, d->window, fired);
    for (int32_t c = 0; c < d->channels; c++)
        if (fired[c] && d->sigma[c] > 0.0 && !is_skipped[c])
            onsets[c] = start + onset(d->window + c * k->window, k->window, k->search);
}
