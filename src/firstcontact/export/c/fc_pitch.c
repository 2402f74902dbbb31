#include "fc_exact.h"
#include "fc_pitch.h"

#include <math.h>

#include "fc_math.h"

/* A spectrum of 2048 lines of fewer than 256 samples falls apart into eight of 256 lines, of which
   three mirror three others. */
enum { LINES = 256, PARTS = 5, WHOLE = 2048, QUARTER = WHOLE / 4, SMOOTH = 61 };
static const float FLOOR = -1.0f;

static float re[LINES], im[LINES], power[WHOLE / 2 + 2], level[FC_POINTS];
/* The spectrum with silence on both sides of it, and room for the last four shifts. */
static float heard[FC_POINTS + 2 * FC_FARTHEST + 8];

/* Fourier transform in place, radix 2; line k comes to lie where k's bits are reversed. */
static void transform(const fc_ear *ear)
{
    for (int32_t half = LINES / 2, step = WHOLE / LINES; half > 0; half /= 2, step *= 2)
        for (int32_t k = 0; k < half; k++) {
            const float c = ear->turn[k * step + QUARTER], s = ear->turn[k * step];
            for (int32_t i = k; i < LINES; i += 2 * half) {
                const int32_t j = i + half;
                const float a = re[i] - re[j], b = im[i] - im[j];
                re[i] += re[j];
                im[i] += im[j];
                re[j] = fmaf(a, c, b * s);
                im[j] = fmaf(b, c, -(a * s));
            }
        }
}

static uint32_t reversed(uint32_t k)
{
    k = (k & 0x55) << 1 | (k >> 1 & 0x55);
    k = (k & 0x33) << 2 | (k >> 2 & 0x33);
    return (k & 15) << 4 | k >> 4;
}

static void spectrum(const fc_ear *ear, const float *quiet)
{
    double mean = 0.0;
    for (int32_t k = 0; k < FC_HEARD; k++)
        mean += quiet[k];
    mean /= FC_HEARD;
    for (int32_t part = 0; part < PARTS; part++) {
        for (int32_t k = 0; k < LINES; k++) {
            const float v = k < FC_HEARD ? (float)(quiet[k] - mean) * ear->fade[k] : 0.0f;
            const uint32_t turn = (uint32_t)(k * part) % WHOLE;
            re[k] = v * ear->turn[turn + QUARTER];
            im[k] = -v * ear->turn[turn];
        }
        transform(ear);
        for (uint32_t k = 0; k < LINES; k++) {
            const uint32_t line = 8 * reversed(k) + (uint32_t)part;
            if (line > WHOLE / 2 && part % 4 == 0)
                continue; /* mirrors one of its own */
            power[line > WHOLE / 2 ? WHOLE - line : line] = re[k] * re[k] + im[k] * im[k];
        }
    }
}

/* Lines above the smooth part of the spectrum; their deviation. */
static double lines(const fc_ear *ear, float *out)
{
    const int32_t last = FC_POINTS - 1, half = SMOOTH / 2;
    double sum = 0.0, mean = 0.0, squares = 0.0;
    for (int32_t k = 0; k < FC_POINTS; k++) {
        const float *const at = power + ear->cell[k];
        const double there = at[0] + (at[1] - at[0]) * ear->part[k];
        level[k] = fc_log_rough(there + 1e-3);
    }
    for (int32_t k = -half; k <= half; k++)
        sum += level[k < 0 ? 0 : k];
    for (int32_t k = 0; k < FC_POINTS; k++) {
        const float line = level[k] - (float)(sum / SMOOTH);
        out[k] = line > FLOOR ? line : FLOOR;
        mean += out[k];
        sum += level[k + half + 1 > last ? last : k + half + 1] - level[k < half ? 0 : k - half];
    }
    mean /= FC_POINTS;
    for (int32_t k = 0; k < FC_POINTS; k++) {
        out[k] -= (float)mean;
        squares += (double)out[k] * out[k];
    }
    return sqrt(squares / FC_POINTS);
}

/* Products of the reference with x and with x one, two and three points further. Four points at a
   time, so that each number is read once for all four. */
static void four(const float *reference, const float *x, float *out)
{
    float a = 0.0f, b = 0.0f, c = 0.0f, d = 0.0f, s = x[0], t = x[1], u = x[2];
    int32_t k = 0;
    for (; k + 4 <= FC_POINTS; k += 4, x += 4) {
        const float *const r = reference + k;
        const float v = x[3], w = x[4], y = x[5], z = x[6];
        a = fmaf(r[3], v, fmaf(r[2], u, fmaf(r[1], t, fmaf(r[0], s, a))));
        b = fmaf(r[3], w, fmaf(r[2], v, fmaf(r[1], u, fmaf(r[0], t, b))));
        c = fmaf(r[3], y, fmaf(r[2], w, fmaf(r[1], v, fmaf(r[0], u, c))));
        d = fmaf(r[3], z, fmaf(r[2], y, fmaf(r[1], w, fmaf(r[0], v, d))));
        s = w;
        t = y;
        u = z;
    }
    for (; k < FC_POINTS; k++, x++) {
        a = fmaf(reference[k], x[0], a);
        b = fmaf(reference[k], x[1], b);
        c = fmaf(reference[k], x[2], c);
        d = fmaf(reference[k], x[3], d);
    }
    out[0] = a;
    out[1] = b;
    out[2] = c;
    out[3] = d;
}

void fc_pitch_listen(const fc_ear *ear, const fc_motor *motor, const float *quiet, double *speed,
                     double *alike)
{
    float *const own = heard + FC_FARTHEST;
    float best = -INFINITY;
    int32_t found = 0;
    spectrum(ear, quiet);
    const double deviation = lines(ear, own);
    for (int32_t shift = -FC_FARTHEST; shift <= FC_FARTHEST; shift += 4) {
        float near[4];
        four(motor->reference, own + shift, near);
        for (int32_t k = shift; k < shift + 4 && k <= FC_FARTHEST; k++) {
            const float like = near[k - shift] * ear->each[k < 0 ? -k : k];
            if (like > best) {
                best = like;
                found = k;
            }
        }
    }
    const double like = best / (deviation * motor->deviation + 1e-9);
    *speed = found * ear->step - motor->usual;
    *alike = like < 0.0 ? 0.0 : like > 1.0 ? 1.0 : like;
}
