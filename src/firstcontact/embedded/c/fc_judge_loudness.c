#include "fc_exact.h"
#include "fc_judge_loudness.h"

#include <math.h>

#include "fc_math.h"

#define C fc_judge_constants
#define LN2 0.69314718055994530942
#define OCTAVE (LN2 / 1048576.0) /* of coarse logarithms */

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

static void peak_start(fc_peak *p, int32_t n, int32_t at)
{
    for (int32_t k = 0; k <= n; k++)
        p->value[k] = -INFINITY;
    p->since = -INFINITY;
    p->at = at;
}

/* The largest with one more. */
static inline double peak_take(fc_peak *p, double x, int32_t n)
{
    if (p->at == n) {
        double top = -INFINITY;
        for (int32_t k = n - 1; k >= 0; k--)
            p->value[k] = top = fmax(p->value[k], top);
        p->at = 0;
        p->since = -INFINITY;
    }
    p->value[p->at++] = x;
    p->since = fmax(p->since, x);
    return fmax(p->since, p->value[p->at]);
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
        j->grown[k].sum = j->grown[k].square = j->grown[k].left = j->grown[k].fresh = 0.0;
    for (int32_t k = 0; k < 2 * FC_STEPS; k++)
        j->extremes[k] = (fc_extremes){-INFINITY, INFINITY, 0.0};
    /* Rounds end one after the other, which spreads what is done then. */
    peak_start(&j->high, FC_QUIET_STEPS, 0);
    peak_start(&j->low, FC_QUIET_STEPS, FC_QUIET_STEPS / 2);
    peak_start(&j->loud, FC_FRESH_STEPS, 0);
    j->step = j->barred = 0;
    for (int32_t p = 0; p < FC_PARTS; p++)
        j->share[p] = 1.0 / C.lengths[p];
    j->share[FC_PARTS] = 1.0 / (FC_RECENT - C.lengths[FC_PARTS - 1]);
    double sum = 0.0, size = 0.0;
    for (int32_t k = 0; k < 2 * FC_LEVELS; k++) {
        sum += C.line[k];
        size += fabs(C.line[k]);
    }
    j->base = C.bias - OCTAVE * (1023.0 * 1048576.0 - 0.5 * FC_COARSELY) * sum;
    j->blur = OCTAVE * 0.5 * FC_COARSELY * size;
}

/* What of the two samples before end their past does not foretell. */
static inline void two(const double *w, const double *end, double *first, double *second)
{
    double a = w[0] * end[-2], b = w[0] * end[-1];
#define TAP(k) b = fma(w[k], end[-1 - (k)], b), a = fma(w[k], end[-2 - (k)], a)
    TAP(1), TAP(2), TAP(3), TAP(4), TAP(5), TAP(6);
    TAP(7), TAP(8), TAP(9), TAP(10), TAP(11), TAP(12);
#undef TAP
    *first = a;
    *second = b;
}

static inline double one(const double *weight, const double *end)
{
    double left = 0.0;
    for (int32_t k = 0; k <= FC_ORDER; k++)
        left = fma(weight[k], end[-k - 1], left);
    return left;
}

/* One sample more of the sums, and of a step's extremes. */
static inline void grow(fc_judge *j, fc_grown *all, fc_extremes *e, double x, double left, uint32_t n)
{
    all->fresh = left * left;
    all->sum += x;
    all->square = fma(x, x, all->square);
    all->left += all->fresh;
    j->grown[n % FC_RING] = *all;
    e->high = fmax(e->high, x);
    e->low = fmin(e->low, x);
    e->loud = fmax(e->loud, all->fresh);
}

void fc_judge_step(fc_judge *j, const double *end, uint32_t count)
{
    fc_grown all = j->grown[(count - FC_STEP - 1) % FC_RING];
    fc_extremes e = {-INFINITY, INFINITY, 0.0};
    const double *x = end - FC_STEP;
    uint32_t n = count - FC_STEP;
    for (; x + 1 < end; x += 2, n += 2) {
        double first, second;
        two(j->weight, x + 2, &first, &second);
        grow(j, &all, &e, x[0], first, n);
        grow(j, &all, &e, x[1], second, n + 1);
    }
    if (x < end)
        grow(j, &all, &e, *x, one(j->weight, end), n);
    const uint32_t step = j->step++, at = step % FC_STEPS, look = j->step % FC_LOOKS;
    j->extremes[at] = e;
    j->extremes[at + FC_STEPS] = e;
    const fc_extremes *const quiet = j->extremes + (step - FC_AFTER_QUIET) % FC_STEPS;
    j->look[look].quiet.high = peak_take(&j->high, quiet->high, FC_QUIET_STEPS);
    j->look[look].quiet.low = -peak_take(&j->low, -quiet->low, FC_QUIET_STEPS);
    j->look[look].quiet.loud = peak_take(&j->loud, quiet->loud, FC_FRESH_STEPS);
    j->look[look].score = INFINITY; /* not known yet */
}

/* Sums of all before a sample. */
static inline const fc_grown *before(const fc_judge *j, uint32_t sample)
{
    return j->grown + (sample - 1) % FC_RING;
}

/* Mean square between two samples around a mean, less the square of the mean. */
static inline double power(const fc_grown *a, const fc_grown *b, double twice, double share)
{
    return ((b->square - a->square) - twice * (b->sum - a->sum)) * share;
}

static inline void widen(fc_extremes *e, double high, double low, double loud)
{
    e->high = fmax(e->high, high);
    e->low = fmin(e->low, low);
    e->loud = fmax(e->loud, loud);
}

/* Extremes of the newest samples of a look: those that lie in no whole step, and the steps. */
static inline fc_extremes newest(const fc_judge *j, const double *end, uint32_t count, uint32_t step)
{
    const uint32_t n = (uint32_t)C.lengths[FC_PARTS - 1], whole = n / FC_STEP;
    fc_extremes e = {-INFINITY, INFINITY, 0.0};
    for (uint32_t k = n; k > whole * FC_STEP; k--)
        widen(&e, end[-(int32_t)k], end[-(int32_t)k], j->grown[(count - k) % FC_RING].fresh);
    const fc_extremes *const last = j->extremes + step % FC_STEPS + FC_STEPS;
    for (const fc_extremes *s = last - whole; s < last; s++)
        widen(&e, s->high, s->low, s->loud);
    return e;
}

/* Of its quiet part: whole steps, and the samples at either end that lie in none. */
static inline fc_extremes quietest(const fc_judge *j, const double *end, uint32_t count, uint32_t step)
{
    enum {
        LATE = FC_AFTER_QUIET * FC_STEP,
        EARLY = FC_LOOK - FC_LOOK % FC_STEP,
        FRESH = FC_LOOK - FC_ORDER - (FC_LOOK - FC_ORDER) % FC_STEP
    };
    fc_extremes e = j->look[step % FC_LOOKS].quiet;
    for (int32_t k = FC_LOOK; k > EARLY; k--)
        widen(&e, end[-k], end[-k], 0.0);
    for (uint32_t k = FC_LOOK - FC_ORDER; k > FRESH; k--)
        e.loud = fmax(e.loud, j->grown[(count - k) % FC_RING].fresh);
    for (int32_t k = LATE; k > FC_RECENT; k--)
        widen(&e, end[-k], end[-k], j->grown[(count - (uint32_t)k) % FC_RING].fresh);
    return e;
}

/* A score by coarse logarithms, and what it is of: a level above its floor for each of C.line. */
typedef struct {
    double sum, level[2 * FC_LEVELS];
} fc_seen;

static inline void note(fc_seen *seen, int32_t k, double power)
{
    seen->level[k] = fc_sqrt(fmax(power, 0.0)) + C.floor;
    seen->sum = fma(C.line[k], fc_log2_coarse(seen->level[k]), seen->sum);
}

static void levels(const fc_judge *j, const double *end, uint32_t count, uint32_t step, fc_seen *seen)
{
    const fc_grown *const last = before(j, count), *const start = before(j, count - FC_LOOK);
    const fc_grown *const recent = before(j, count - FC_RECENT), *from = last;
    const double mean = (recent->sum - start->sum) / FC_QUIET, twice = 2.0 * mean;
    const double square = mean * mean, share = j->share[FC_PARTS];
    enum { OTHER = FC_LEVELS };
    seen->sum = 0.0;
    for (int32_t p = 0; p < FC_PARTS; p++) {
        from = before(j, count - (uint32_t)C.lengths[p]);
        note(seen, p, power(from, last, twice, j->share[p]) + square);
        note(seen, OTHER + p, (last->left - from->left) * j->share[p]);
    }
    const fc_grown *const fresh = before(j, count - (FC_LOOK - FC_ORDER));
    note(seen, FC_PARTS, power(start, recent, twice, 1.0 / FC_QUIET) + square);
    note(seen, FC_PARTS + 1, power(recent, from, twice, share) + square);
    note(seen, OTHER + FC_PARTS, (recent->left - fresh->left) * (1.0 / (FC_QUIET - FC_ORDER)));
    note(seen, OTHER + FC_PARTS + 1, (from->left - recent->left) * share);
    const fc_extremes loud = newest(j, end, count, step), quiet = quietest(j, end, count, step);
    const double top = fmax(loud.high - mean, mean - loud.low);
    const double most = fmax(quiet.high - mean, mean - quiet.low);
    note(seen, FC_PARTS + 2, top * top);
    note(seen, FC_PARTS + 3, most * most);
    note(seen, OTHER + FC_PARTS + 2, loud.loud);
    note(seen, OTHER + FC_PARTS + 3, quiet.loud);
}

/* What a look says: above 0 for a contact. Coarse logarithms do where the sign is beyond doubt,
   and rough ones almost anywhere else. */
static double score(const fc_judge *j, const double *end, uint32_t count, uint32_t step)
{
    fc_seen seen;
    double rough = C.bias, out = C.bias;
    levels(j, end, count, step, &seen);
    const double coarse = fma(OCTAVE, seen.sum, j->base);
    if (fabs(coarse) > j->blur)
        return coarse;
    for (int32_t k = 0; k < 2 * FC_LEVELS; k++)
        rough = fma(C.line[k], fc_log_rough(seen.level[k]), rough);
    if (fabs(rough) > C.doubt)
        return rough;
    for (int32_t k = 0; k < 2 * FC_LEVELS; k++)
        out += C.line[k] * fc_log(seen.level[k]);
    return out;
}

/* All looks must agree: one that does not spares the windows that it belongs to their judgement. */
bool fc_judge_fires(fc_judge *j, const double *end, uint32_t count)
{
    if (j->step < j->barred)
        return false;
    for (uint32_t k = 0; k < FC_LOOKS; k++) {
        const uint32_t step = j->step - k, look = step % FC_LOOKS;
        if (!(j->look[look].score < INFINITY))
            j->look[look].score = score(j, end - k * FC_STEP, count - k * FC_STEP, step);
        if (j->look[look].score <= 0.0) {
            j->barred = step + FC_LOOKS;
            return false;
        }
    }
    return true;
}
