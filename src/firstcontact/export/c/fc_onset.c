#include "fc_exact.h"
#include "fc_onset.h"

#include "fc_detector_sizes.h"
#include "fc_math.h"

enum { LEAST_LOUD = 3, FIRST = FC_WINDOW - FC_SEARCH > LEAST_LOUD ? FC_WINDOW - FC_SEARCH : LEAST_LOUD };

typedef struct {
    double quiet, loud; /* variances before and after a split */
    double coarse;      /* what the picker weighs it by, with coarse logarithms */
} split;

/* What the picker weighs splits by, where rough logarithms do. */
static float rough(const split *s, int32_t k)
{
    return (float)k * fc_log_rough(s->quiet) + (float)(FC_WINDOW - k - 1) * fc_log_rough(s->loud);
}

static double exact(const split *s, int32_t k)
{
    return k * fc_log(s->quiet) + (FC_WINDOW - k - 1) * fc_log(s->loud);
}

/* Of samples from x to before end, and of their squares. */
static void sums(const double *x, const double *end, double *sum, double *squares)
{
    double a = 0.0, b = 0.0, c = 0.0, d = 0.0;
    for (; x + 4 <= end; x += 4) {
        a += x[0];
        b = fma(x[0], x[0], b);
        c += x[1];
        d = fma(x[1], x[1], d);
        a += x[2];
        b = fma(x[2], x[2], b);
        c += x[3];
        d = fma(x[3], x[3], d);
    }
    for (; x < end; x++) {
        a += *x;
        b = fma(*x, *x, b);
    }
    *sum = a + c;
    *squares = b + d;
}

uint32_t fc_onset(const double *end)
{
    const int32_t n = FC_WINDOW;
    const double *x = end - n + FIRST;
    split at[FC_WINDOW];
    double before, power, after, left, floor = INFINITY, least = INFINITY;
    sums(end - n, x, &before, &power);
    sums(x, end, &after, &left);
    double k = FIRST, rest = n - FIRST;
    for (split *s = at + FIRST; s <= at + n - LEAST_LOUD; s++, x++, k += 1.0, rest -= 1.0) {
        const double each = 1.0 / k, other = 1.0 / rest, a = before * each, b = after * other;
        s->quiet = fmax(power * each - a * a, 1e-6);
        s->loud = fmax(left * other - b * b, 1e-6);
        s->coarse = k * fc_log2_coarse(s->quiet) + (rest - 1.0) * fc_log2_coarse(s->loud);
        floor = fmin(floor, s->coarse);
        before += *x;
        power = fma(*x, *x, power);
        after -= *x;
        left = fma(-*x, *x, left);
    }
    /* Coarse logarithms leave few that can be the least, and rough ones fewer. */
    int32_t few[FC_WINDOW], many = 0;
    float low = INFINITY, roughly[FC_WINDOW];
    floor += FC_COARSELY * (n - 1);
    for (const split *s = at + FIRST; s <= at + n - LEAST_LOUD; s++)
        if (s->coarse <= floor)
            few[many++] = (int32_t)(s - at);
    for (int32_t i = 0; i < many; i++) {
        roughly[i] = rough(at + few[i], few[i]);
        low = fminf(low, roughly[i]);
    }
    int32_t still = 0, best = FIRST;
    for (int32_t i = 0; i < many; i++)
        if (roughly[i] <= low + 1e-4f * (float)n)
            few[still++] = few[i];
    if (still == 1)
        return (uint32_t)(n - few[0]);
    for (int32_t i = 0; i < still; i++) {
        const double aic = exact(at + few[i], few[i]);
        if (aic < least) {
            least = aic;
            best = few[i];
        }
    }
    return (uint32_t)(n - best);
}
