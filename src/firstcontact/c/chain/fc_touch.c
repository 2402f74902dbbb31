#include "fc_touch.h"

#include "fc_assert.h"
#include "fc_math.h"

/* Smallest amplitude, as a share of the level. Smaller ones are raised to it. */
static const double LEAST = 1e-4;
/* Smallest relative error of a measured speed. */
static const double LEAST_ERROR = 0.01;
/* Share of repeated samples above which a converter counts as dead or saturated. */
static const double STILL = 0.5;

const fc_rig *fc_touch_rig(const fc_model *m, int32_t finger)
{
    const fc_rig *rig = NULL;
    for (int32_t k = 0; k < m->sizes->rigs; k++)
        if (m->rig[k].counts->finger == finger || (rig == NULL && m->rig[k].counts->finger < 0))
            rig = m->rig + k;
    return rig;
}

int32_t fc_touch_stage(const fc_model *m, int32_t n)
{
    int32_t stage = 0;
    while (stage < m->sizes->stages - 1 && m->stage[stage] < n)
        stage++;
    return stage;
}

void fc_touch_begin(fc_touch *t, const fc_model *m, int32_t finger, const float *before,
                    fc_touch_room *room)
{
    FC_ASSERT(t != NULL && m != NULL && before != NULL && room != NULL);
    const int32_t quiet = m->sizes->before / 2;
    double mean = 0.0, squares = 0.0;
    t->model = m;
    t->rig = fc_touch_rig(m, finger);
    t->samples = 0;
    t->shift = t->correlation = 0.0f;
    for (int32_t k = 0; k < quiet; k++)
        mean += before[k];
    mean /= quiet;
    for (int32_t k = 0; k < quiet; k++)
        squares += (before[k] - mean) * (before[k] - mean);
    const double noise = sqrt(squares / quiet);
    t->noise = fc_log((noise > 1e-7 ? noise : 1e-7) / t->rig->scales->level);
    if (t->rig->counts->has_pitch) {
        float *const lines = room->spectrum + FC_TURN;
        int32_t shift;
        fc_spectrum(&m->pitch, before, room->spectrum, lines);
        fc_shift(lines, t->rig->reference, &shift, &t->correlation);
        t->shift = (float)shift;
    }
    const fc_hints none = {0.0, 0.0, NAN};
    fc_touch_hint(t, &none);
}

void fc_touch_hint(fc_touch *t, const fc_hints *hints)
{
    FC_ASSERT(t != NULL && t->rig != NULL && hints != NULL);
    const fc_rig_counts *const has = t->rig->counts;
    const fc_rig_scales *const usual = t->rig->scales;
    double speed = 0.0, alike = 0.0;
    if (has->has_pitch) {
        speed = t->shift * t->model->pitch_step - usual->usual_pitch;
        alike = fc_bounded(t->correlation, 0.0, 1.0);
    }
    if (has->has_speeds && hints->speed > 0.0) {
        /* Posterior mean of ln(speed / usual): measurement, pitch and spread of the rig's speeds. */
        const double error = hints->error > LEAST_ERROR ? hints->error : LEAST_ERROR;
        const double precision = 1.0 / (error * error);
        const double pitch_precision = alike > FC_BELIEVED && usual->heard_error > 0.0
                                           ? 1.0 / (usual->heard_error * usual->heard_error)
                                           : 0.0;
        const double measured = hints->speed > 1e-6 ? hints->speed : 1e-6;
        const double weighted
            = precision * fc_log(measured / usual->usual_speed) + pitch_precision * speed;
        speed = weighted / (precision + pitch_precision
                            + 1.0 / (usual->speed_spread * usual->speed_spread));
        alike = 1.0;
    }
    const bool has_radius = !isnan(hints->radius);
    t->hints[FC_HINT_SPEED] = alike > FC_BELIEVED ? fc_bounded(speed, -1.0, 1.0) * 4.0 : 0.0;
    t->hints[FC_HINT_HAS_SPEED] = alike > FC_BELIEVED;
    t->hints[FC_HINT_ALIKE] = alike;
    t->hints[FC_HINT_HAS_RADIUS] = has_radius;
    t->hints[FC_HINT_CURVATURE] = has_radius ? fc_log(1.0 + FC_TIP / hints->radius) : 0.0;
}

void fc_touch_take(fc_touch *t, float volts)
{
    FC_ASSERT(t != NULL && t->rig != NULL);
    if (t->samples == FC_POINTS)
        return;
    const double v = t->rig->scales->sign * (double)volts;
    /* A hard object on a soft rig gives many times the level. The logarithm bounds it. */
    const double size = fc_log(1.0 + fabs(v) * (2.0 / t->rig->scales->level)) / 2.0;
    t->volts[t->samples] = v;
    t->scaled[t->samples++] = (float)(v < 0.0 ? -size : size);
}

double fc_touch_traits(const fc_touch *t, int32_t n, double *f)
{
    FC_ASSERT(t != NULL && f != NULL && n > 1 && n <= t->samples);
    const double *const v = t->volts, level = t->rig->scales->level, least = LEAST * level;
    double top = v[0], rise = 0.0, energy = 0.0, moment = 0.0, rough = 0.0, low = 1.0;
    int32_t at = 0, tenth = 0, half = 0, width = 0, flat = 0;
    for (int32_t k = 0; k < n; k++) {
        const double square = v[k] * v[k];
        energy += square;
        moment += square * k;
        if (v[k] > top) {
            top = v[k];
            at = k;
        }
        if (k + 1 < n) {
            const double step = v[k + 1] - v[k];
            rise = step > rise ? step : rise;
            rough += step * step;
            flat += step == 0.0;
        }
    }
    if (n < FC_POINTS && top < 0.0) { /* missing samples count as 0 */
        top = 0.0;
        at = n;
    }
    const double peak = top > least ? top : least;
    int32_t low_at = at;
    for (int32_t k = 0; k < n; k++) {
        const double relative = v[k] / peak;
        tenth += k <= at && relative < 0.1;
        half += k <= at && relative < 0.5;
        width += relative > 0.5;
        if (k > at && (low_at == at || relative < low)) {
            low = relative;
            low_at = k;
        }
    }
    if (at == n) { /* the peak is the first missing sample */
        tenth++;
        half++;
    }
    const double total = energy + LEAST * LEAST * level * level;
    const double last = v[n - 1] / peak, earlier = v[n > 4 ? n - 4 : 0] / peak;
    f[FC_TRAIT_PEAK] = fc_log(peak / level);
    f[FC_TRAIT_RISE] = fc_log((rise > least ? rise : least) / level);
    f[FC_TRAIT_PEAK_AT] = at / 20.0 - 1.0;
    f[FC_TRAIT_BELOW_TENTH] = tenth / 10.0 - 0.5;
    f[FC_TRAIT_BELOW_HALF] = half / 10.0 - 0.5;
    f[FC_TRAIT_WIDTH] = width / 20.0 - 0.5;
    f[FC_TRAIT_ROUGHNESS] = fc_log(rough / total + 1e-4) + 2.0;
    f[FC_TRAIT_DIP] = low;
    f[FC_TRAIT_DIP_AT] = low_at / 40.0 - 1.0;
    f[FC_TRAIT_POWER] = fc_log(sqrt(total / n) / level);
    f[FC_TRAIT_CENTROID] = moment / total / 20.0 - 1.0;
    f[FC_TRAIT_LENGTH] = n / 37.0 - 1.0;
    f[FC_TRAIT_LAST] = last;
    f[FC_TRAIT_TREND] = last - earlier;
    f[FC_TRAIT_NOISE] = t->noise;
    f[FC_TRAIT_REPEATS] = 10.0 * ((double)flat / (n - 1));
    return peak;
}

void fc_touch_inputs(const fc_touch *t, int32_t n, float *x, double *traits)
{
    const double peak = fc_touch_traits(t, n, traits);
    for (int32_t k = 0; k < FC_POINTS; k++) {
        const bool is_valid = k < n;
        x[k] = is_valid ? t->scaled[k] : 0.0f;
        x[FC_POINTS + k] = is_valid ? (float)(t->volts[k] / peak) : 0.0f;
        x[2 * FC_POINTS + k] = is_valid ? 1.0f : 0.0f;
    }
    for (int32_t k = 0; k < FC_FEATURES; k++)
        x[3 * FC_POINTS + k] = (float)traits[k];
    for (int32_t k = 0; k < FC_HINTS; k++)
        x[3 * FC_POINTS + FC_FEATURES + k] = (float)t->hints[k];
}

/* Return the arrays of the process at a stage. `n` is the number of pinches. */
static fc_process process_at(const fc_rig *rig, int32_t stage)
{
    const int32_t n = rig->counts->pinches, count = 2 * FC_KNOWN + FC_KNOWN * n + n + n * (n + 1) / 2 + 2;
    const float *const at = (const float *)(const void *)rig->processes + stage * count;
    const fc_process p = {
        at, at + FC_KNOWN, at + 2 * FC_KNOWN, at + 2 * FC_KNOWN + FC_KNOWN * n,
        at + 2 * FC_KNOWN + FC_KNOWN * n + n, at[count - 2], at[count - 1],
    };
    return p;
}

FC_WIDE static void kernel(const fc_process *p, const double *restrict x, int32_t n,
                           double *restrict inner, double *restrict apart)
{
    for (int32_t i = 0; i < n; i++)
        inner[i] = apart[i] = 0.0;
    for (int32_t k = 0; k < FC_KNOWN; k++)
        for (int32_t i = 0; i < n; i++) {
            const double known = p->known[k * n + i], away = known - x[k];
            inner[i] += known * x[k];
            apart[i] += away * away;
        }
    for (int32_t i = 0; i < n; i++)
        inner[i] = 1.0 + inner[i] * (FC_LINEAR / FC_KNOWN)
                   + fc_exp(apart[i] * (-1.0 / (2.0 * FC_LENGTH * FC_LENGTH * FC_KNOWN)));
}

void fc_process_predict(const fc_touch *t, int32_t stage, const double *traits, double *value,
                        double *spread)
{
    const int32_t n = t->rig->counts->pinches;
    const fc_process p = process_at(t->rig, stage);
    const float *row = p.factor;
    double x[FC_KNOWN], covariance[FC_PINCHES_MOST], apart[FC_PINCHES_MOST];
    double square = 0.0, sum = 0.0, explained = 0.0;
    for (int32_t k = 0; k < FC_KNOWN; k++) {
        const double y = fc_bounded(k < FC_FEATURES ? traits[k] : t->hints[FC_HINT_SPEED], -FC_LARGEST, FC_LARGEST);
        x[k] = (y - p.mean[k]) * p.each[k];
        square += x[k] * x[k];
    }
    kernel(&p, x, n, covariance, apart);
    for (int32_t i = 0; i < n; row += ++i) {
        double y = 0.0;
        for (int32_t j = 0; j <= i; j++)
            y += row[j] * covariance[j];
        explained += y * y;
        sum += covariance[i] * p.weights[i];
    }
    const double left = 2.0 + FC_LINEAR * square / FC_KNOWN - explained;
    const fc_rig_scales *const shore_a = t->rig->scales;
    *value = fc_bounded(shore_a->centre + shore_a->unit * sum, 0.0, 100.0);
    *spread = shore_a->unit * sqrt((left > 0.0 ? left : 0.0) + FC_NOISE) * p.scale;
}

/* Average a prediction with that of the regression, weighted by the inverse variances, and subtract
 * the rig's offset. */
static void refine(const fc_touch *t, int32_t stage, const double *traits, double *value,
                   double *spread)
{
    double other, own;
    fc_process_predict(t, stage, traits, &other, &own);
    const double share = own * own / (own * own + *spread * *spread);
    const double variance = share * *spread * *spread + (1.0 - share) * own * own;
    const double apart = *value - other;
    *value = share * *value + (1.0 - share) * other - process_at(t->rig, stage).offset;
    *spread = sqrt(variance + share * (1.0 - share) * apart * apart);
}

/* Return true if the traits of a contact are out of the range of the training. */
static bool is_unfamiliar(const fc_touch *t, int32_t stage, const double *traits)
{
    const fc_model *const m = t->model;
    const float *row = m->whitening + stage * FC_TRIANGLE;
    double away[FC_TRAITS], distance = 0.0, share = 0.0, length = 0.0;
    if (!t->rig->counts->has_level && traits[FC_TRAIT_REPEATS] > 10.0 * STILL)
        return true;
    for (int32_t k = 0; k < FC_TRAITS; k++)
        away[k] = traits[k] - m->familiar[stage * FC_TRAITS + k];
    away[FC_TRAIT_LENGTH] = 0.0;
    for (int32_t i = 0; i < FC_TRAITS; row += ++i) {
        double y = 0.0, gain = 0.0;
        for (int32_t k = 0; k <= i; k++) {
            y += row[k] * away[k];
            /* Peak, rise, power and noise move together when the gain changes. */
            if (k == FC_TRAIT_PEAK || k == FC_TRAIT_RISE || k == FC_TRAIT_POWER
                || k == FC_TRAIT_NOISE)
                gain += row[k];
        }
        distance += y * y;
        share += y * gain;
        length += gain * gain;
    }
    if (!t->rig->counts->has_level) { /* the gain is unknown: use that of the smallest distance */
        distance -= share * share / (length > 1e-60 ? length : 1e-60);
        distance = distance > 0.0 ? distance : 0.0;
    }
    return sqrt(distance) > m->limit[stage];
}

bool fc_touch_predict(const fc_touch *t, int32_t n, fc_touch_room *room, fc_estimate *out)
{
    FC_ASSERT(t != NULL && room != NULL && out != NULL);
    const fc_model *const m = t->model;
    const int32_t stage = fc_touch_stage(m, n);
    const int32_t rank = m->network.layers[FC_RIG_LAYER].into.rows;
    double traits[FC_TRAITS], value, spread;
    fc_touch_inputs(t, n, room->network.values, traits);
    fc_network_predict(&m->network, t->rig->rig_terms + stage * rank, &room->network, &value,
                       &spread);
    if (t->rig->counts->pinches > 0)
        refine(t, stage, traits, &value, &spread);
    const double half = spread * m->factors[stage];
    double sum = value + half; /* the network clips its inputs, so the traits are checked, too */
    for (int32_t k = 0; k < FC_TRAITS; k++)
        sum += traits[k];
    if (!isfinite(sum))
        return false;
    value = fc_bounded(value, 0.0, 100.0);
    out->value = (float)value;
    out->low = (float)fc_bounded(value - half, 0.0, 100.0);
    out->high = (float)fc_bounded(value + half, 0.0, 100.0);
    out->half_width = (float)half;
    out->spread = (float)spread;
    out->is_out_of_range = is_unfamiliar(t, stage, traits);
    return true;
}
