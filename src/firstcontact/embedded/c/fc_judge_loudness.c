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
        for (int32_t k = 1; k <= FC_ORDER; k++)
            left += j->weight[k] * newest[-k];
    } else {
        for (uint32_t k = 1; k <= FC_ORDER; k++)
            left += j->weight[k] * past[(n - k) % FC_RING];
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

static double logarithm(double level)
{
    return fc_log(sqrt(level > 0.0 ? level : 0.0) + C.floor);
}

/* What a look that ends before sample end says: above 0 for a contact. */
static double score(const fc_judge *j, const double *past, uint32_t end, uint32_t look)
{
    const uint32_t start = end - FC_LOOK, recent = end - (uint32_t)C.recent;
    const uint32_t newest = end - (uint32_t)C.lengths[FC_PARTS - 1];
    const double mean = between(j->sum, start, recent) / FC_QUIET;
    const double *line = C.line, *const other = C.line + FC_LEVELS;
    double top = 0.0, loud = 0.0, sum = 0.0, left = 0.0, out = C.bias;
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
        out += line[p] * logarithm(sum / n) + other[p] * logarithm(left / n);
    }
    const double above = j->look[look].high - mean, below = mean - j->look[look].low;
    const double quiet = above > below ? above : below;
    line += FC_PARTS;
    out += line[0] * logarithm(power(j, mean, start, recent)) +
           line[1] * logarithm(power(j, mean, recent, newest)) + line[2] * logarithm(top) +
           line[3] * logarithm(quiet * quiet);
    line = other + FC_PARTS;
    out += line[0] * logarithm(between(j->left, start + FC_ORDER, recent) / (FC_QUIET - FC_ORDER)) +
           line[1] * logarithm(between(j->left, recent, newest) / (double)(newest - recent)) +
           line[2] * logarithm(loud) + line[3] * logarithm(j->look[look].loud);
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
