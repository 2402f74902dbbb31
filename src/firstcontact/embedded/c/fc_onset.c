#include "fc_onset.h"

#include "fc_detector_sizes.h"
#include "fc_math.h"

enum { LEAST_LOUD = 3 };

static double held(double variance)
{
    return variance > 1e-6 ? variance : 1e-6;
}

uint32_t fc_onset(const double *past, uint32_t end)
{
    const int32_t n = FC_WINDOW, start = (int32_t)end - n;
    const int32_t first = n - FC_SEARCH > LEAST_LOUD ? n - FC_SEARCH : LEAST_LOUD;
    double all = 0.0, squares = 0.0, left = 0.0, left_squares = 0.0, least = 0.0;
    int32_t best = -1;
    for (int32_t k = 0; k < n; k++) {
        const double x = past[(uint32_t)(start + k) % FC_RING];
        all += x;
        squares += x * x;
    }
    for (int32_t k = 0; k < n - LEAST_LOUD; k++) {
        const double x = past[(uint32_t)(start + k) % FC_RING];
        left += x;
        left_squares += x * x;
        const int32_t split = k + 1, rest = n - split;
        if (split < first)
            continue;
        const double a = left / split, b = (all - left) / rest;
        const double quiet = held(left_squares / split - a * a);
        const double loud = held((squares - left_squares) / rest - b * b);
        const double aic = split * fc_log(quiet) + (rest - 1) * fc_log(loud);
        if (best < 0 || aic < least) {
            least = aic;
            best = split;
        }
    }
    return (uint32_t)(n - best);
}
