#include "fc_exact.h"
#include "fc_anytime.h"

#include <math.h>
#include <stddef.h>

#include "fc_math.h"

/* Amplitudes below this share of the level count as this. */
static const double LEAST = 1e-4;
/* Unit of the network's answers, and bounds of the logarithm of its spreads. */
static const double BELIEVED = 0.5;
static const double CENTRE = 40.0, UNIT = 40.0, MEAN_SCALE = 0.6;
static const float NARROW = -4.0f, WIDE = 2.0f, FARTHEST = 6.0f;

static float numbers[FC_NUMBERS + 1], along[FC_DIRECTIONS], body[FC_HIDDEN + FC_FOUND];
static float query[FC_FOUND], hidden[FC_WIDEST];
static int16_t rounded[FC_WIDEST + FC_NUMBERS + 3];

static double bounded(double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}

static void touched(fc_touch *t, float volts)
{
    if (!(volts - volts == 0.0f))
        t->broken = true;
    t->lowest = volts < t->lowest ? volts : t->lowest;
    t->highest = volts > t->highest ? volts : t->highest;
}

/* How fast the hand closes, from the motor's pitch: believed where it sounds as usual. */
static void listen(const fc_anytime *m, fc_touch *t, const float *before)
{
    double speed, alike;
    if (!FC_LISTENS || t->rig->motor == NULL || t->broken)
        return;
    fc_pitch_listen(m->ear, t->rig->motor, before, &speed, &alike);
    if (alike > BELIEVED) {
        t->beside[0] = (float)(4.0 * bounded(speed, -1.0, 1.0));
        t->beside[1] = 1.0f;
    }
    t->beside[2] = (float)alike;
}

void fc_anytime_begin(const fc_anytime *m, fc_touch *t, const float *before, int32_t finger)
{
    double mean = 0.0, squares = 0.0;
    const int32_t quiet = FC_BEFORE / 2;
    t->rig = NULL;
    for (int32_t k = 0; k < m->rigs; k++)
        if (m->rig[k].finger == finger || (t->rig == NULL && m->rig[k].finger < 0))
            t->rig = m->rig + k;
    t->samples = 0;
    t->broken = false;
    t->lowest = t->highest = before[0];
    for (int32_t k = 0; k < FC_BEFORE; k++) {
        touched(t, before[k]);
        mean += k < quiet ? (double)before[k] / quiet : 0.0;
    }
    for (int32_t k = 0; k < quiet; k++)
        squares += (before[k] - mean) * (before[k] - mean);
    for (int32_t k = 0; k < FC_BESIDE; k++)
        t->beside[k] = 0.0f;
    listen(m, t, before);
    const double noise = sqrt(squares / quiet);
    t->loud = t->broken ? 0.0 : fc_log((noise > 1e-7 ? noise : 1e-7) / t->rig->level);
}

void fc_anytime_take(fc_touch *t, float volts)
{
    if (t->samples == FC_LONGEST)
        return;
    touched(t, volts);
    const double v = t->rig->sign * (double)volts;
    t->v[t->samples] = v;
    if (!t->broken) {
        const double size = fc_log(1.0 + fabs(v) * (2.0 / t->rig->level)) / 2.0;
        t->scaled[t->samples] = (float)(v < 0.0 ? -size : size);
    }
    t->samples++;
}

/* The shape of the contact so far; returns its peak. Traits: features, noise, how long it is flat. */
static double features(const fc_touch *t, double *f)
{
    const int32_t n = t->samples;
    const double *const v = t->v, level = t->rig->level, floor = LEAST * level;
    double top = v[0], rise = 0.0, energy = 0.0, moment = 0.0, rough = 0.0, low = 1.0;
    int32_t at = 0, tenth = 0, half = 0, width = 0, low_at, flat = 0;
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
            flat += v[k + 1] == v[k];
        }
    }
    if (n < FC_LONGEST && top < 0.0) { /* what is not there yet counts as 0 */
        top = 0.0;
        at = n;
    }
    const double peak = top > floor ? top : floor;
    low_at = at;
    for (int32_t k = 0; k < FC_LONGEST; k++) {
        const double relative = k < n ? v[k] / peak : 0.0;
        tenth += k <= at && relative < 0.1;
        half += k <= at && relative < 0.5;
        width += relative > 0.5;
        if (k > at && k < n && (low_at == at || relative < low)) {
            low = relative;
            low_at = k;
        }
    }
    const double whole = energy + LEAST * LEAST * level * level;
    const double last = v[n - 1] / peak, earlier = v[n > 4 ? n - 4 : 0] / peak;
    const double scale = FC_LONGEST / 74.0;
    f[0] = fc_log(peak / level);
    f[1] = fc_log((rise > floor ? rise : floor) / level);
    f[2] = at / (20.0 * scale) - 1.0;
    f[3] = tenth / (10.0 * scale) - 0.5;
    f[4] = half / (10.0 * scale) - 0.5;
    f[5] = width / (20.0 * scale) - 0.5;
    f[6] = fc_log(rough / whole + 1e-4) + 2.0;
    f[7] = low;
    f[8] = low_at / (40.0 * scale) - 1.0;
    f[9] = fc_log(sqrt(whole / n) / level);
    f[10] = moment / whole / (20.0 * scale) - 1.0;
    f[11] = n / (37.0 * scale) - 1.0;
    f[12] = last;
    f[13] = last - earlier;
    f[FC_FEATURES] = t->loud;
    f[FC_FEATURES + 1] = 10.0 * flat / (n - 1);
    return peak;
}

static void inputs(const fc_anytime *m, const fc_touch *t, double peak, const double *f)
{
    for (int32_t k = 0; k < FC_LONGEST; k++) {
        const bool there = k < t->samples;
        numbers[k] = there ? t->scaled[k] : 0.0f;
        numbers[FC_LONGEST + k] = there ? (float)(t->v[k] / peak) : 0.0f;
        numbers[2 * FC_LONGEST + k] = there ? 1.0f : 0.0f;
    }
    for (int32_t k = 0; k < FC_FEATURES; k++)
        numbers[3 * FC_LONGEST + k] = (float)f[k];
    for (int32_t k = 0; k < FC_BESIDE; k++)
        numbers[3 * FC_LONGEST + FC_FEATURES + k] = t->beside[k];
    for (int32_t k = 0; k < FC_NUMBERS; k++) {
        const float x = (numbers[k] - m->mean[k]) * m->each[k];
        numbers[k] = x < -FARTHEST ? -FARTHEST : x > FARTHEST ? FARTHEST : x;
    }
}

/* Two thin layers in place of one; bias of the first where it is the rig's. */
static void thin(const fc_whole *layer, const float *in, const float *bias, float *out)
{
    float unit = fc_round(in, layer[0].inputs, rounded);
    fc_whole_run(layer, rounded, unit, bias, along);
    unit = fc_round(along, layer[1].inputs, rounded);
    fc_whole_run(layer + 1, rounded, unit, NULL, out);
}

static void silu(float *x, int32_t n)
{
    for (int32_t k = 0; k < n; k++)
        x[k] = x[k] / (1.0f + fc_exp(x[k] < -60.0f ? 60.0f : -x[k]));
}

/* Each head weighs the rig's levels by how well they fit, and gives what they hold. */
static void look(const fc_rig *rig, int32_t stage, const float *asked, float *found)
{
    enum { EACH = FC_FOUND / FC_HEADS };
    const float root = sqrtf((float)EACH);
    for (int32_t h = 0; h < FC_HEADS; h++) {
        const int32_t place = (stage * FC_HEADS + h) * rig->levels * EACH;
        const float *const keys = rig->keys + place, *const values = rig->values + place;
        float share[FC_LEVELS_MOST], most = -INFINITY, sum = 0.0f;
        for (int32_t l = 0; l < rig->levels; l++) {
            float fit = 0.0f;
            for (int32_t k = 0; k < EACH; k++)
                fit += asked[h * EACH + k] * keys[l * EACH + k];
            share[l] = fit / root;
            most = share[l] > most ? share[l] : most;
        }
        for (int32_t k = 0; k < EACH; k++)
            found[h * EACH + k] = 0.0f;
        for (int32_t l = 0; l < rig->levels; l++) {
            share[l] = fc_exp(share[l] - most);
            sum += share[l];
        }
        for (int32_t l = 0; l < rig->levels; l++)
            for (int32_t k = 0; k < EACH; k++)
                found[h * EACH + k] += share[l] / sum * values[l * EACH + k];
    }
}

static bool strange(const fc_anytime *m, const fc_rig *rig, int32_t stage, const double *f)
{
    double away[FC_TRAITS], distance = 0.0, share = 0.0, length = 0.0;
    if (rig->levels == 0 && f[FC_TRAITS - 1] > 10.0 * m->still)
        return true;
    for (int32_t k = 0; k < FC_TRAITS; k++)
        away[k] = f[k] - m->usual[stage * FC_TRAITS + k];
    away[11] = 0.0; /* at a stage all have the same length */
    for (int32_t i = 0; i < FC_TRAITS; i++) {
        const float *const row = m->whitening + (stage * FC_TRAITS + i) * FC_TRAITS;
        double y = 0.0;
        for (int32_t k = 0; k < FC_TRAITS; k++)
            y += row[k] * away[k];
        distance += y * y;
        /* peak, steepest rise, power and noise: they move together when the gain changes */
        const double gain = (double)row[0] + row[1] + row[9] + row[14];
        share += y * gain;
        length += gain * gain;
    }
    if (rig->levels == 0) { /* no level: the gain that makes the contact least strange */
        distance -= share * share / (length > 1e-60 ? length : 1e-60);
        distance = distance > 0.0 ? distance : 0.0;
    }
    return sqrt(distance) > m->limit[stage];
}

/* Mean and spread of a mixture of normals. */
static void moments(const float *raw, fc_running *a)
{
    double sum = 0.0, value = 0.0, square = 0.0;
    float most = raw[0];
    for (int32_t k = 1; k < FC_COMPONENTS; k++)
        most = raw[k] > most ? raw[k] : most;
    for (int32_t k = 0; k < FC_COMPONENTS; k++) {
        const float spread = raw[2 * FC_COMPONENTS + k];
        const double weight = fc_exp(raw[k] - most);
        const double mean = raw[FC_COMPONENTS + k] * (UNIT * MEAN_SCALE) + CENTRE;
        const double sd = UNIT * fc_exp(spread < NARROW ? NARROW : spread > WIDE ? WIDE : spread);
        sum += weight;
        value += weight * mean;
        square += weight * (sd * sd + mean * mean);
    }
    a->value = value / sum;
    const double variance = square / sum - a->value * a->value;
    a->spread = sqrt(variance > 1e-4 ? variance : 1e-4);
}

fc_status fc_anytime_answer(const fc_anytime *m, const fc_touch *t, fc_running *a)
{
    double f[FC_TRAITS];
    float raw[3 * FC_COMPONENTS];
    int32_t stage = 0;
    if (t->broken || t->samples < m->shortest || !(t->highest > t->lowest))
        return FC_UNUSABLE;
    while (stage < m->stages - 1 && m->stage[stage] < t->samples)
        stage++;
    inputs(m, t, features(t, f), f);
    thin(m->query1, numbers, NULL, body);
    silu(body, FC_HIDDEN);
    thin(m->query2, body, NULL, query);
    look(t->rig, stage, query, body + FC_HIDDEN);
    thin(m->body1, body, t->rig->along + stage * m->body1[0].outputs, hidden);
    silu(hidden, m->body1[1].outputs);
    thin(m->body2, hidden, NULL, hidden);
    silu(hidden, m->body2[1].outputs);
    thin(m->body3, hidden, NULL, hidden);
    silu(hidden, m->body3[1].outputs);
    fc_dense_run(&m->answer, hidden, raw);
    moments(raw, a);
    const double half = m->factor[stage] * a->spread;
    a->value = bounded(a->value, 0.0, 100.0);
    a->low = bounded(a->value - half, 0.0, 100.0);
    a->high = bounded(a->value + half, 0.0, 100.0);
    a->strange = strange(m, t->rig, stage, f);
    /* No number less itself is 0 but a finite one. */
    return a->value - a->value == 0.0 && half - half == 0.0 ? FC_ANSWER : FC_NO_ANSWER;
}
