#include "fc_exact.h"
#include "fc_judge_kernel.h"

#include <math.h>

#include "fc_math.h"

#define C fc_judge_constants

enum { RECENT = FC_WINDOW - 2 * FC_STEP, NEWEST = FC_WINDOW - FC_STEP };

static double mean_of(const double *x, int32_t from, int32_t to)
{
    double sum = 0.0;
    for (int32_t k = from; k < to; k++)
        sum += x[k];
    return sum / (to - from);
}

static double loudness(const double *x, int32_t from, int32_t to)
{
    double sum = 0.0;
    for (int32_t k = from; k < to; k++)
        sum += x[k] * x[k];
    return fc_log(sqrt(sum / (to - from)) + C.floor);
}

static double top(const double *x, int32_t from, int32_t to)
{
    double most = 0.0;
    for (int32_t k = from; k < to; k++) {
        const double size = fabs(x[k]);
        most = size > most ? size : most;
    }
    return fc_log(most + C.floor);
}

static double bent(double x)
{
    const double y = fc_log(fabs(x) + sqrt(x * x + 1.0));
    return x < 0.0 ? -y : y;
}

/* x: a window around the mean of its quiet part; slope: its differences. */
static void features(const double *x, const double *slope, double *f)
{
    for (int32_t k = NEWEST; k < FC_WINDOW; k++)
        *f++ = bent(x[k]);
    for (int32_t k = 0; k < FC_COARSE; k++)
        *f++ = bent(mean_of(x, C.coarse[k], C.coarse[k + 1]));
    for (int32_t k = 0; k < 3 * FC_SPANS; k++)
        *f++ = loudness(x, C.span[k], C.span[k + 1]);
    for (int32_t k = 0; k < 3 * FC_SPANS; k++)
        *f++ = loudness(slope, C.span[k], C.span[k + 1]);
    *f++ = top(x, RECENT, FC_WINDOW) - top(x, 0, RECENT);
    *f = top(slope, RECENT, FC_WINDOW) - top(slope, 0, RECENT);
}

bool fc_judge_fires(fc_judge *j, const double *end, uint32_t count)
{
    double x[FC_WINDOW], slope[FC_WINDOW], f[FC_SEEN], out = C.bias;
    (void)j, (void)count;
    for (int32_t k = 0; k < FC_WINDOW; k++)
        x[k] = end[k - FC_WINDOW];
    const double quiet = mean_of(x, 0, RECENT);
    for (int32_t k = 0; k < FC_WINDOW; k++) {
        x[k] -= quiet;
        slope[k] = k > 0 ? x[k] - x[k - 1] : 0.0;
    }
    features(x, slope, f);
    for (int32_t k = 0; k < FC_SEEN; k++)
        f[k] = (f[k] - C.mean[k]) * C.slope[k];
    for (int32_t i = 0; i < C.vectors; i++) {
        const float *const v = C.support + i * FC_SEEN;
        double far = 0.0;
        for (int32_t k = 0; k < FC_SEEN; k++) {
            const double away = f[k] - (double)v[k];
            far = fma(away, away, far);
        }
        if (far * C.gamma < 700.0) /* else next to nothing, at the price of an underflow */
            out += C.weight[i] * exp(-C.gamma * far);
    }
    return out > 0.0;
}
