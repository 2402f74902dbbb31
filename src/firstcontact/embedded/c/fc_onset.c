#include "fc_exact.h"
#include "fc_onset.h"

#include "fc_detector_sizes.h"
#include "fc_math.h"

enum { LEAST_LOUD = 3, FIRST = FC_WINDOW - FC_SEARCH > LEAST_LOUD ? FC_WINDOW - FC_SEARCH : LEAST_LOUD };

static double held(double variance)
{
    return variance > 1e-6 ? variance : 1e-6;
}

uint32_t fc_onset(const double *past, uint32_t end)
{
    const int32_t n = FC_WINDOW, start = (int32_t)end - n;
    double quiet[FC_WINDOW], loud[FC_WINDOW], sum = 0.0, squares = 0.0, least = 0.0;
    float rough[FC_WINDOW], floor = 0.0f;
    int32_t best = -1;
    /* Sums before each split, in the place of what they become. */
    for (int32_t k = 0; k < n; k++) {
        const double x = past[(uint32_t)(start + k) % FC_RING];
        quiet[k] = sum;
        loud[k] = squares;
        sum += x;
        squares += x * x;
    }
    for (int32_t split = FIRST; split <= n - LEAST_LOUD; split++) {
        const double each = 1.0 / split, other = 1.0 / (n - split);
        const double a = quiet[split] * each, b = (sum - quiet[split]) * other;
        quiet[split] = held(loud[split] * each - a * a);
        loud[split] = held((squares - loud[split]) * other - b * b);
        rough[split] = (float)split * fc_log_rough(quiet[split]) +
                       (float)(n - split - 1) * fc_log_rough(loud[split]);
        floor = split == FIRST || rough[split] < floor ? rough[split] : floor;
    }
    /* Rough logarithms leave few that can be the least. */
    for (int32_t split = FIRST; split <= n - LEAST_LOUD; split++) {
        if (rough[split] > floor + 1e-4f * (float)n)
            continue;
        const double aic =
            split * fc_log(quiet[split]) + (n - split - 1) * fc_log(loud[split]);
        if (best < 0 || aic < least) {
            least = aic;
            best = split;
        }
    }
    return (uint32_t)(n - best);
}
