#include "kernels.h"

#include <math.h>
#include <string.h>

/* Prediction error of one look, after its first ORDER samples. */
WIDE static void unpredicted(const double *restrict x, const double *restrict weight, int32_t n,
                             double *restrict out)
{
    for (int32_t i = ORDER; i < n; i++)
        out[i] = weight[0] * x[i];
    for (int32_t k = 1; k <= ORDER; k++) {
        const double w = weight[k];
        for (int32_t i = ORDER; i < n; i++)
            out[i] += w * x[i - k];
    }
}

static double largest(double top, double x)
{
    return x > top ? x : top;
}

/* Add the features of one signal, squared samples, times their weights. */
static double part_score(const fc_detector *d, const double *power, int32_t first, int32_t n,
                         const double *line)
{
    const int32_t recent = n - d->lengths[PARTS], newest = n - d->lengths[PARTS - 1];
    double quiet = 0.0, between = 0.0, sum = 0.0, quiet_top = 0.0, top = 0.0, logs[EACH + 1];
    int32_t i = 0;
    for (; i < recent; i++) {
        quiet += power[i];
        quiet_top = largest(quiet_top, power[i]);
    }
    for (; i < newest; i++)
        between += power[i];
    i = n;
    for (int32_t p = 0; p < PARTS; p++) {
        for (; i > n - d->lengths[p]; i--) {
            sum += power[i - 1];
            top = largest(top, power[i - 1]);
        }
        logs[1 + p] = sum / d->lengths[p];
    }
    logs[0] = quiet / (recent - first);
    logs[PARTS + 1] = between / (newest - recent);
    logs[PARTS + 2] = top;
    logs[PARTS + 3] = quiet_top;
    for (int32_t k = 0; k <= EACH; k++)
        logs[k] = log(sqrt(logs[k]) + d->floor);
    double out = logs[0] * line[0];
    for (int32_t k = 1; k <= PARTS + 1; k++)
        out += (logs[k] - logs[0]) * line[k];
    return out + (logs[PARTS + 2] - logs[PARTS + 3]) * line[EACH - 1];
}

/* Score of a look of n samples, in sigmas: above 0 for a contact. */
static double look_score(const fc_detector *d, const double *x, int32_t n, const double *weights)
{
    double power[WINDOW_MOST], quiet = 0.0, out;
    const int32_t recent = n - d->lengths[PARTS];
    for (int32_t i = 0; i < recent; i++)
        quiet += x[i];
    quiet /= recent;
    for (int32_t i = 0; i < n; i++)
        power[i] = (x[i] - quiet) * (x[i] - quiet);
    out = part_score(d, power, 0, n, d->line);
    for (int32_t i = 0; i < ORDER; i++)
        power[i] = 0.0;
    unpredicted(x, weights, n, power);
    for (int32_t i = ORDER; i < n; i++)
        power[i] *= power[i];
    return out + part_score(d, power, ORDER, n, d->line + EACH) + d->line[2 * EACH];
}

/* Return true if all looks of a window, which ends with sample number - 1, are above 0. */
static bool fires(const fc_detector *d, const double *window, int64_t number, const double *weights,
                  double (*memory)[2])
{
    const int32_t length = d->window - (d->looks - 1) * d->step;
    for (int32_t look = d->looks - 1; look >= 0; look--) {
        const int64_t end = number - (int64_t)(d->looks - 1 - look) * d->step;
        double *const entry = memory[(uint64_t)(end / d->step) % LOOKS_MOST];
        if (entry[0] != (double)end) {
            entry[0] = (double)end;
            entry[1] = look_score(d, window + look * d->step, length, weights);
        }
        if (!(entry[1] > 0.0))
            return false;
    }
    return true;
}

/* Position of the split of a window that best separates quiet from loud (Maeda 1985). */
static int32_t onset(const double *x, int32_t n, int32_t search)
{
    enum { LEAST_LOUD = 3 };
    const int32_t first = n - search > LEAST_LOUD ? n - search : LEAST_LOUD;
    double sum = 0.0, squares = 0.0, all = 0.0, all_squares = 0.0, least = INFINITY;
    int32_t best = first;
    for (int32_t i = 0; i < n; i++) {
        all += x[i];
        all_squares += x[i] * x[i];
    }
    for (int32_t k = 1; k <= n - LEAST_LOUD; k++) {
        sum += x[k - 1];
        squares += x[k - 1] * x[k - 1];
        if (k < first)
            continue;
        const double left = k, right = n - k, a = sum / left, b = (all - sum) / right;
        const double quiet = largest(1e-6, squares / left - a * a);
        const double loud = largest(1e-6, (all_squares - squares) / right - b * b);
        const double aic = left * log(quiet) + (right - 1.0) * log(loud);
        if (aic < least) {
            least = aic;
            best = k;
        }
    }
    return best;
}

/* Return true if any finger is loud in the newest step before `end`. */
static bool wakes(const fc_detector *d, const fc_closing *c, const double *past, int32_t end)
{
    for (int32_t i = end - d->step; i < end; i++)
        for (int32_t f = 0; f < c->fingers; f++)
            if (c->sigma[f] > 0.0
                && fabs((past[i * c->fingers + f] - c->mean[f]) / c->sigma[f]) > d->awake)
                return true;
    return false;
}

void fc_judge(const fc_detector *d, const fc_closing *c, const double *past, int64_t first,
              int32_t end, int32_t count, int32_t *onsets)
{
    double window[WINDOW_MOST];
    for (int32_t k = 0; k < count; k++, end += d->step) {
        for (int32_t f = 0; f < c->fingers; f++)
            onsets[k * c->fingers + f] = -1;
        if (!wakes(d, c, past, end))
            continue;
        const int32_t start = end - d->window;
        for (int32_t f = 0; f < c->fingers; f++) {
            if (!c->is_judged[f] || !(c->sigma[f] > 0.0))
                continue;
            for (int32_t i = 0; i < d->window; i++)
                window[i] = (past[(start + i) * c->fingers + f] - c->mean[f]) / c->sigma[f];
            if (fires(d, window, first + end, c->weights + f * (ORDER + 1),
                      (double(*)[2])c->memory + f * LOOKS_MOST))
                onsets[k * c->fingers + f] = start + onset(window, d->window, d->search);
        }
    }
}

static double median_of_steps(const double *x, ptrdiff_t stride)
{
    double sorted[STEPS];
    for (int32_t i = 0; i < STEPS; i++) {
        const double value = x[i * stride];
        int32_t place = i;
        for (; place > 0 && (sorted[place - 1] > value || isnan(sorted[place - 1])); place--)
            sorted[place] = sorted[place - 1];
        sorted[place] = value;
    }
    return sorted[STEPS / 2];
}

/* Return true if the median power of STEPS steps around their common mean is below the limit. */
static bool is_calm(const double *sums, int32_t fingers, int32_t step, const double *limit)
{
    for (int32_t f = 0; f < fingers; f++) {
        double power[STEPS];
        const double mean = median_of_steps(sums + f, 2 * fingers) / step;
        for (int32_t i = 0; i < STEPS; i++) {
            const double total = sums[i * 2 * fingers + f];
            const double squares = sums[i * 2 * fingers + fingers + f];
            power[i] = (squares - 2 * mean * total) / step + mean * mean;
        }
        if (!(median_of_steps(power, 1) <= limit[f] * limit[f]))
            return false;
    }
    return true;
}

void fc_quiet_steps(const double *volts, int32_t width, int32_t fingers, int32_t step,
                    int32_t steps, double *sums, int64_t known, const double *limit,
                    uint8_t *is_quiet)
{
    const int32_t row = 2 * fingers;
    double *const newest = sums + (STEPS - 1) * row;
    for (int32_t s = 0; s < steps; s++) {
        memmove(sums, sums + row, sizeof(double) * (size_t)((STEPS - 1) * row));
        for (int32_t f = 0; f < row; f++)
            newest[f] = 0.0;
        for (int32_t i = 0; i < step; i++, volts += width)
            for (int32_t f = 0; f < fingers; f++) {
                newest[f] += volts[f];
                newest[fingers + f] += volts[f] * volts[f];
            }
        is_quiet[s] = ++known >= STEPS && is_calm(sums, fingers, step, limit);
    }
}
