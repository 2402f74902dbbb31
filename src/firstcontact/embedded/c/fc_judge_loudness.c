#include "fc_exact.h"
#include "fc_judge_loudness.h"

#include <math.h>

#include "fc_math.h"

#define C fc_judge_constants

/* Linear prediction by Levinson's recursion: weights of the newest sample and of those before. */
static void predict(const double *lag, double *weight)
{
    double error = lag[0];
    weight[0] = 1.0;
    for (int32_t m = 1; m <= FC_ORDER; m++) {
        double turn = lag[m];
        for (int32_t k = 1; k < m; k++)
            turn += weight[k] * lag[m - k];
        const double reflected = -turn / error;
        for (int32_t a = 1, b = m - 1; a <= b; a++, b--) {
            const double first = weight[a], last = weight[b];
            weight[a] = first + reflected * last;
            weight[b] = last + reflected * first;
        }
        weight[m] = reflected;
        error *= 1.0 - reflected * reflected;
    }
}

static void peak_start(fc_peak *p)
{
    for (int32_t k = 0; k < FC_QUIET; k++)
        p->value[k] = p->suffix[k] = -INFINITY;
    p->prefix = p->top = -INFINITY;
    p->at = 0;
}

static inline void peak_take(fc_peak *p, double x, int32_t n)
{
    if (p->at == n) {
        double top = -INFINITY;
        for (int32_t k = n - 1; k >= 0; k--)
            p->suffix[k] = top = p->value[k] > top ? p->value[k] : top;
        p->at = 0;
        p->prefix = -INFINITY;
    }
    p->value[p->at++] = x;
    p->prefix = x > p->prefix ? x : p->prefix;
    p->top = p->at < n && p->suffix[p->at] > p->prefix ? p->suffix[p->at] : p->prefix;
}

void fc_judge_settle(fc_judge *j, const double *quiet)
{
    double lag[FC_ORDER + 1], mean = 0.0, squares = 0.0;
    for (int32_t k = 0; k <= FC_ORDER; k++) {
        lag[k] = 0.0;
        for (int32_t i = k; i < FC_STEADY; i++)
            lag[k] += quiet[i - k] * quiet[i];
        lag[k] /= FC_STEADY;
        j->weight[k] = 0.0;
    }
    if (lag[0] > 0.0) {
        lag[0] *= 1.0 + C.ridge;
        predict(lag, j->weight);
        for (int32_t pass = 0; pass < 2; pass++)
            for (int32_t i = FC_ORDER; i < FC_STEADY; i++) {
                double left = 0.0;
                for (int32_t k = 0; k <= FC_ORDER; k++)
                    left += j->weight[k] * quiet[i - k];
                if (pass == 0)
                    mean += left / (FC_STEADY - FC_ORDER);
                else
                    squares += (left - mean) * (left - mean);
            }
        const double sigma = sqrt(squares / (FC_STEADY - FC_ORDER));
        for (int32_t k = 0; k <= FC_ORDER; k++)
            j->weight[k] = sigma > 0.0 ? j->weight[k] / sigma : 0.0;
    }
    for (int32_t k = 0; k < FC_RING; k++)
        j->sum[k] = j->square[k] = j->left[k] = j->new_square[k] = 0.0;
    peak_start(&j->high);
    peak_start(&j->low);
    peak_start(&j->loud);
    j->step = 0;
}

void fc_judge_take(fc_judge *j, const double *past, uint32_t n)
{
    const uint32_t at = n % FC_RING, before = (n - 1) % FC_RING;
    const double x = past[at];
    double left = j->weight[0] * x;
    if (at >= FC_ORDER) {
        const double *const newest = past + at;
        for (int32_t k = 1; k <= FC_ORDER; k += 4) {
            left = fma(j->weight[k], newest[-k], left);
            left = fma(j->weight[k + 1], newest[-k - 1], left);
            left = fma(j->weight[k + 2], newest[-k - 2], left);
            left = fma(j->weight[k + 3], newest[-k - 3], left);
        }
    } else {
        for (uint32_t k = 1; k <= FC_ORDER; k++)
            left = fma(j->weight[k], past[(n - k) % FC_RING], left);
    }
    if (n < FC_ORDER)
        left = 0.0; /* what went before is not known yet */
    j->sum[at] = j->sum[before] + x;
    j->square[at] = j->square[before] + x * x;
    j->new_square[at] = left * left;
    j->left[at] = j->left[before] + left * left;
    if (n < (uint32_t)C.recent)
        return;
    const uint32_t quiet = (n - (uint32_t)C.recent) % FC_RING;
    peak_take(&j->high, past[quiet], FC_QUIET);
    peak_take(&j->low, -past[quiet], FC_QUIET);
    peak_take(&j->loud, j->new_square[quiet], FC_QUIET - FC_ORDER);
}

void fc_judge_step(fc_judge *j)
{
    const uint32_t at = ++j->step % FC_LOOKS;
    j->look[at].high = j->high.top;
    j->look[at].low = -j->low.top;
    j->look[at].loud = j->loud.top;
    j->look[at].score = INFINITY; /* not known yet */
}

/* Sum over samples from a to before b of a growing sum. */
static double between(const double *grown, uint32_t a, uint32_t b)
{
    return grown[(b - 1) % FC_RING] - grown[(a - 1) % FC_RING];
}

/* Mean square around a mean, from a to before b. */
static double power(const fc_judge *j, double mean, uint32_t a, uint32_t b)
{
    const double n = (double)(b - a);
    return (between(j->square, a, b) - 2.0 * mean * between(j->sum, a, b)) / n + mean * mean;
}

static double root(double level)
{
    return sqrt(level > 0.0 ? level : 0.0) + C.floor;
}

/* Levels of a look that ends before sample end, as C.line weighs their logarithms. */
static void levels(const fc_judge *j, const double *past, uint32_t end, uint32_t look, double *level)
{
    const uint32_t start = end - FC_LOOK, recent = end - (uint32_t)C.recent;
    const uint32_t newest = end - (uint32_t)C.lengths[FC_PARTS - 1];
    const double mean = between(j->sum, start, recent) / FC_QUIET;
    double *const other = level + FC_LEVELS;
    double top = 0.0, loud = 0.0, sum = 0.0, left = 0.0;
    uint32_t k = end;
    for (int32_t p = 0; p < FC_PARTS; p++) {
        const uint32_t first = end - (uint32_t)C.lengths[p];
        while (k != first) {
            const uint32_t at = --k % FC_RING;
            const double away = past[at] - mean, square = away * away, more = j->new_square[at];
            sum += square;
            left += more;
            top = square > top ? square : top;
            loud = more > loud ? more : loud;
        }
        const double n = (double)C.lengths[p];
        level[p] = sum / n;
        other[p] = left / n;
    }
    const double above = j->look[look].high - mean, below = mean - j->look[look].low;
    const double quiet = above > below ? above : below;
    level[FC_PARTS] = power(j, mean, start, recent);
    level[FC_PARTS + 1] = power(j, mean, recent, newest);
    level[FC_PARTS + 2] = top;
    level[FC_PARTS + 3] = quiet * quiet;
    other[FC_PARTS] = between(j->left, start + FC_ORDER, recent) / (FC_QUIET - FC_ORDER);
    other[FC_PARTS + 1] = between(j->left, recent, newest) / (double)(newest - recent);
    other[FC_PARTS + 2] = loud;
    other[FC_PARTS + 3] = j->look[look].loud;
}

/* What a look says: above 0 for a contact. Rough logarithms do where the sign is beyond doubt. */
static double score(const fc_judge *j, const double *past, uint32_t end, uint32_t look)
{
    double level[2 * FC_LEVELS], rough = C.bias, out = C.bias;
    levels(j, past, end, look, level);
    for (int32_t k = 0; k < 2 * FC_LEVELS; k++) {
        level[k] = root(level[k]);
        rough = fma(C.line[k], fc_log_rough(level[k]), rough);
    }
    if (fabs(rough) > C.doubt)
        return rough;
    for (int32_t k = 0; k < 2 * FC_LEVELS; k++)
        out += C.line[k] * fc_log(level[k]);
    return out;
}

/* All looks must agree: one that does not spares the windows that it belongs to their judgement. */
bool fc_judge_fires(fc_judge *j, const double *past, uint32_t end)
{
    for (uint32_t k = 0; k < FC_LOOKS; k++)
        if (j->look[(j->step - k) % FC_LOOKS].score <= 0.0)
            return false;
    for (uint32_t k = 0; k < FC_LOOKS; k++) {
        const uint32_t look = (j->step - k) % FC_LOOKS;
        if (!(j->look[look].score < INFINITY))
            j->look[look].score = score(j, past, end - k * FC_STEP, look);
        if (j->look[look].score <= 0.0)
            return false;
    }
    return true;
}
