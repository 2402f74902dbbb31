#include "fc_exact.h"
#include "fc_judge_kernel.h"

#include <math.h>

#include "fc_math.h"
#include "fc_steps.h"

#define C fc_judge_constants

/* TOGETHER: vectors whose answers are kept at once. */
enum { RECENT = FC_WINDOW - 2 * FC_STEP, NEWEST = FC_WINDOW - FC_STEP, TOGETHER = 64 };

static double mean_of(const double *x, int32_t from, int32_t to)
{
    double sum = 0.0;
    for (int32_t k = from; k < to; k++)
        sum += x[k];
    return sum / (to - from);
}

/* Of each part: how loud it is; and by how much the newest two steps exceed what was before. */
static void loudness(const double *x, double *f, double *beyond)
{
    double before = 0.0, top = 0.0;
    for (int32_t p = 0; p < 3 * FC_SPANS; p++) {
        const int32_t from = C.span[p], to = C.span[p + 1];
        double sum = 0.0;
        for (int32_t k = from; k < to; k++) {
            sum = fma(x[k], x[k], sum);
            top = fmax(top, fabs(x[k]));
        }
        f[p] = fc_log(fc_sqrt(sum / (to - from)) + C.floor);
        if (p == FC_SPANS - 1) { /* the quiet part ends here */
            before = top;
            top = 0.0;
        }
    }
    *beyond = fc_log(top + C.floor) - fc_log(before + C.floor);
}

static double bent(double x)
{
    const double y = fc_log(fabs(x) + fc_sqrt(x * x + 1.0));
    return x < 0.0 ? -y : y;
}

/* x: a window around the mean of its quiet part; slope: its differences. */
static void features(const double *x, const double *slope, double *f)
{
    for (int32_t k = NEWEST; k < FC_WINDOW; k++)
        *f++ = bent(x[k]);
    for (int32_t k = 0; k < FC_COARSE; k++)
        *f++ = bent(mean_of(x, C.coarse[k], C.coarse[k + 1]));
    double *const beyond = f + 6 * FC_SPANS;
    loudness(x, f, beyond);
    loudness(slope, f + 3 * FC_SPANS, beyond + 1);
}

bool fc_judge_fires(fc_judge *j, const double *end, uint32_t count)
{
    double x[FC_WINDOW], slope[FC_WINDOW], f[FC_SEEN], out = C.bias;
    float seen[FC_SEEN], near[TOGETHER];
    (void)j, (void)count;
    const double quiet = mean_of(end - FC_WINDOW, 0, RECENT);
    for (int32_t k = 0; k < FC_WINDOW; k++) {
        x[k] = end[k - FC_WINDOW] - quiet;
        slope[k] = k > 0 ? x[k] - x[k - 1] : 0.0;
    }
    features(x, slope, f);
    for (int32_t k = 0; k < FC_SEEN; k++)
        seen[k] = (float)((f[k] - C.mean[k]) * C.slope[k]);
    for (int32_t from = 0, n; from < C.vectors; from += n) {
        n = C.vectors - from < TOGETHER ? C.vectors - from : TOGETHER;
        const fc_rbf some = {n, FC_SEEN, C.gamma, C.steep + from * FC_SEEN, C.norms + from};
        fc_rbf_run(&some, seen, near);
        for (int32_t i = 0; i < n; i++)
            out = fma(C.weight[from + i], near[i], out);
    }
    return out > 0.0;
}
