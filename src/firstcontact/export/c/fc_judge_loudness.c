#include "fc_exact.h"
#include "fc_judge_loudness.h"

#include <math.h>

#include "fc_math.h"

#define C fc_judge_constants
#define LN2 0.69314718055994530942
#define OCTAVE (LN2 / 1048576.0) /* of coarse logarithms */

/* Linear prediction by Levinson's recursion: weights of the newest sample and of those before.
   Returns what is left of lag[0]. */
static double predict(const double *lag, double *weight)
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
    return error;
}

/* As if it had taken the last n: one field of steps up to last, its sign turned or not, in a round
   that is at place at. Returns the largest. */
static double peak_recall(fc_peak *p, const double *last, double sign, int32_t n, int32_t at)
{
    enum { EACH = sizeof(fc_extremes) / sizeof(double) };
    double top = -INFINITY;
    p->at = at;
    for (int32_t k = at - 1; k >= 0; k--, last -= EACH) {
        p->value[k] = sign * *last;
        top = fmax(top, p->value[k]);
    }
    p->since = top;
    top = -INFINITY;
    for (int32_t k = n - 1; k >= at; k--, last -= EACH)
        p->value[k] = top = fmax(top, sign * *last);
    p->value[n] = -INFINITY; /* of none */
    return fmax(p->since, top);
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

void fc_judge_hear(fc_judge *j, const double *steady, uint32_t n)
{
    const double x = steady[n];
    if (n == 0)
        for (int32_t k = 0; k <= FC_ORDER; k++)
            j->lag[k] = 0.0;
    if (n < FC_ORDER) {
        for (uint32_t k = 1; k <= n; k++)
            j->lag[k] = fma(steady[n - k], x, j->lag[k]);
        return;
    }
#define LAG(k) j->lag[k] = fma(steady[n - (k)], x, j->lag[k])
    LAG(1), LAG(2), LAG(3), LAG(4), LAG(5), LAG(6);
    LAG(7), LAG(8), LAG(9), LAG(10), LAG(11), LAG(12);
#undef LAG
}

/* Weights that leave of the steady state a sigma of 1. No sample is filtered again for it: with
   nothing around the samples, the filter leaves in all what Levinson's recursion says, less the
   ridge's share; and what of that lies beyond either end takes only the samples there. */
static void foretell(fc_judge *j, const double *steady, double mean, double spread)
{
    double head[FC_ORDER], tail[FC_ORDER], lag[FC_ORDER + 1], beyond = 0.0, ends = 0.0, size = 0.0;
    double *const w = j->weight;
    for (int32_t k = 0; k < FC_ORDER; k++) {
        head[k] = steady[k] - mean;
        tail[k] = steady[FC_STEADY - 1 - k] - mean;
    }
    /* Of distances from the mean: those that have no partner at either end sum up to ends. */
    lag[0] = spread * (1.0 + C.ridge);
    for (int32_t k = 1; k <= FC_ORDER; k++) {
        ends += head[k - 1] + tail[k - 1];
        lag[k] = j->lag[k] - mean * ((FC_STEADY - k) * mean - ends);
    }
    double power = predict(lag, w), sum = 0.0;
    for (int32_t n = 0; n < FC_ORDER; n++) {
        double first = 0.0, last = 0.0;
        for (int32_t k = 0; k <= n; k++) {
            first = fma(w[n - k], head[k], first);
            last = fma(w[FC_ORDER - n + k], tail[k], last);
        }
        sum -= first + last;
        beyond += first * first + last * last;
    }
    for (int32_t k = 0; k <= FC_ORDER; k++)
        size = fma(w[k], w[k], size);
    sum /= FC_STEADY - FC_ORDER;
    power -= C.ridge * spread * size + beyond;
    power = power / (FC_STEADY - FC_ORDER) - sum * sum;
    const double scale = power > 0.0 ? sqrt(spread / FC_STEADY / power) : 0.0;
    for (int32_t k = 0; k <= FC_ORDER; k++)
        w[k] *= scale;
}

void fc_judge_settle(fc_judge *j, const double *steady, double mean, double spread)
{
    if (spread > 0.0)
        foretell(j, steady, mean, spread);
    else
        for (int32_t k = 0; k <= FC_ORDER; k++)
            j->weight[k] = 0.0;
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
    fc_grown *const now = j->grown + n % FC_RING;
    now->sum = all->sum;
    now->square = all->square;
    now->left = all->left;
    now->fresh = all->fresh;
    e->high = fmax(e->high, x);
    e->low = fmin(e->low, x);
    e->loud = fmax(e->loud, all->fresh);
}

static inline void widen(fc_extremes *e, double high, double low, double loud)
{
    e->high = fmax(e->high, high);
    e->low = fmin(e->low, low);
    e->loud = fmax(e->loud, loud);
}

static inline void note_step(fc_judge *j, const fc_extremes *e)
{
    fc_extremes *const at = j->extremes + j->step++ % FC_STEPS, *const again = at + FC_STEPS;
    at->high = again->high = e->high;
    at->low = again->low = e->low;
    at->loud = again->loud = e->loud;
}

/* A step's samples: sums that grow from those before it, and the step's extremes. */
static inline void heard(fc_judge *j, fc_grown *all, const double *end, uint32_t n)
{
    fc_extremes e = {-INFINITY, INFINITY, 0.0};
    const double *x = end - FC_STEP;
    for (; x + 1 < end; x += 2, n += 2) {
        double first, second;
        two(j->weight, x + 2, &first, &second);
        grow(j, all, &e, x[0], first, n);
        grow(j, all, &e, x[1], second, n + 1);
    }
    if (x < end)
        grow(j, all, &e, *x, one(j->weight, end), n);
    note_step(j, &e);
}

/* The quiet part of the look that ends with a step takes one step more. */
static inline void grow_quiet(fc_judge *j, uint32_t step)
{
    const uint32_t look = step % FC_LOOKS;
    const fc_extremes *const quiet = j->extremes + (step - 1 - FC_AFTER_QUIET) % FC_STEPS;
    j->look[look].quiet.high = peak_take(&j->high, quiet->high, FC_QUIET_STEPS);
    j->look[look].quiet.low = -peak_take(&j->low, -quiet->low, FC_QUIET_STEPS);
    j->look[look].quiet.loud = peak_take(&j->loud, quiet->loud, FC_FRESH_STEPS);
    j->look[look].score = INFINITY; /* not known yet */
}

/* What is left of the samples before end, squared. */
static void recall_left(fc_judge *j, const double *end)
{
    const double *const w = j->weight, *x = end - FC_FORETOLD * FC_STEP;
    uint32_t n = FC_STEADY - FC_FORETOLD * FC_STEP;
    for (uint32_t k = FC_STEADY - FC_RECALLED * FC_STEP; k < n; k++)
        j->grown[k % FC_RING].fresh = 0.0;
    for (; x + 4 <= end; x += 4, n += 4) {
        double a = w[0] * x[0], b = w[0] * x[1], c = w[0] * x[2], d = w[0] * x[3];
#define TAP(k) a = fma(w[k], x[-(k)], a), b = fma(w[k], x[1 - (k)], b), c = fma(w[k], x[2 - (k)], c), \
               d = fma(w[k], x[3 - (k)], d)
        TAP(1), TAP(2), TAP(3), TAP(4), TAP(5), TAP(6);
        TAP(7), TAP(8), TAP(9), TAP(10), TAP(11), TAP(12);
#undef TAP
        j->grown[n % FC_RING].fresh = a * a;
        j->grown[(n + 1) % FC_RING].fresh = b * b;
        j->grown[(n + 2) % FC_RING].fresh = c * c;
        j->grown[(n + 3) % FC_RING].fresh = d * d;
    }
    for (; x < end; x++, n++) {
        const double left = one(w, x + 1);
        j->grown[n % FC_RING].fresh = left * left;
    }
}

void fc_judge_recall(fc_judge *j, const double *end)
{
    enum { FIRST = FC_RECALLED - FC_LOOKS + 2 }; /* step that ends the first window's first look */
    double sum = 0.0, square = 0.0, left = 0.0;
    uint32_t n = FC_STEADY - FC_RECALLED * FC_STEP;
    recall_left(j, end);
    for (const double *x = end - FC_RECALLED * FC_STEP; x < end;) {
        fc_extremes e = {-INFINITY, INFINITY, 0.0};
        for (int32_t k = 0; k < FC_STEP; k++, x++, n++) {
            fc_grown *const now = j->grown + n % FC_RING;
            now->sum = sum += *x;
            now->square = square = fma(*x, *x, square);
            now->left = left += now->fresh;
            widen(&e, *x, *x, now->fresh);
        }
        note_step(j, &e);
    }
    const fc_extremes *const last = j->extremes + (FIRST - 1 - FC_AFTER_QUIET);
    fc_extremes *const quiet = &j->look[FIRST % FC_LOOKS].quiet;
    /* Rounds end one after the other, which spreads what is done then. */
    quiet->high = peak_recall(&j->high, &last->high, 1.0, FC_QUIET_STEPS, 0);
    quiet->low = -peak_recall(&j->low, &last->low, -1.0, FC_QUIET_STEPS, FC_QUIET_STEPS / 2);
    quiet->loud = peak_recall(&j->loud, &last->loud, 1.0, FC_FRESH_STEPS, 0);
    j->look[FIRST % FC_LOOKS].score = INFINITY;
    for (uint32_t step = FIRST + 1; step <= FC_RECALLED; step++)
        grow_quiet(j, step);
}

void fc_judge_step(fc_judge *j, const double *end, uint32_t count)
{
    fc_grown all = j->grown[(count - FC_STEP - 1) % FC_RING];
    heard(j, &all, end, count - FC_STEP);
    grow_quiet(j, j->step);
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
