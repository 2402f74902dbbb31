#include "fc_pitch.h"

#include "fc_math.h"

enum { HALF = FC_TURN / 2, QUARTER = FC_TURN / 4, SMOOTH = 61 };
/* Power, in squared counts of the converter, that is far below any noise. */
static const double LEAST_POWER = 1e-3;
static const float LOWEST_LINE = -1.0f;

/* Return cosine and negative sine of k / FC_TURN of a turn, for k up to FC_TURN / 2. */
static inline void turn(const float *sine, int32_t k, float *re, float *im)
{
    *re = k <= QUARTER ? sine[QUARTER - k] : -sine[k - QUARTER];
    *im = -(k <= QUARTER ? sine[k] : sine[2 * QUARTER - k]);
}

/* Compute the Fourier transform of HALF complex numbers in place. */
static void transform(const float *sine, float (*z)[2])
{
    for (int32_t i = 1, j = 0; i < HALF; i++) {
        int32_t bit = HALF >> 1;
        for (; j & bit; bit >>= 1)
            j ^= bit;
        j ^= bit;
        if (i < j) {
            const float re = z[i][0], im = z[i][1];
            z[i][0] = z[j][0];
            z[i][1] = z[j][1];
            z[j][0] = re;
            z[j][1] = im;
        }
    }
    for (int32_t length = 2; length <= HALF; length *= 2) {
        const int32_t half = length / 2, step = FC_TURN / length;
        for (int32_t k = 0; k < half; k++) {
            float re, im;
            turn(sine, k * step, &re, &im);
            for (int32_t start = k; start < HALF; start += length) {
                float *const a = z[start], *const b = z[start + half];
                const float x = b[0] * re - b[1] * im, y = b[0] * im + b[1] * re;
                b[0] = a[0] - x;
                b[1] = a[1] - y;
                a[0] += x;
                a[1] += y;
            }
        }
    }
}

/* Return the power of line k of FC_TURN real numbers, from the transform of their pairs. */
static double power(const float *sine, float (*z)[2], int32_t k)
{
    const float *const a = z[k % HALF], *const b = z[(HALF - k) % HALF];
    const float even_re = (a[0] + b[0]) / 2, even_im = (a[1] - b[1]) / 2;
    const float odd_re = (a[1] + b[1]) / 2, odd_im = (b[0] - a[0]) / 2;
    float re, im;
    turn(sine, k, &re, &im);
    const double x = even_re + (odd_re * re - odd_im * im);
    const double y = even_im + (odd_re * im + odd_im * re);
    return x * x + y * y;
}

void fc_spectrum(const fc_pitch *e, const float *signal, float *work, float *lines)
{
    float(*const z)[2] = (float(*)[2])work;
    double mean = 0.0, sum = 0.0;
    for (int32_t k = 0; k < e->samples; k++)
        mean += signal[k];
    mean /= e->samples;
    for (int32_t k = 0; k < FC_TURN; k++)
        work[k] = k < e->samples ? (float)(signal[k] - mean) * e->fade[k] : 0.0f;
    transform(e->sine, z);
    double level[FC_LINES];
    for (int32_t k = 0; k < FC_LINES; k++) {
        const double below = power(e->sine, z, e->cell[k]);
        const double above = power(e->sine, z, e->cell[k] + 1);
        level[k] = fc_log(below + (above - below) * e->part[k] + LEAST_POWER);
    }
    for (int32_t k = -SMOOTH / 2; k <= SMOOTH / 2; k++)
        sum += level[k > 0 ? k : 0];
    mean = 0.0;
    for (int32_t k = 0; k < FC_LINES; k++) {
        const double above = level[k] - sum / SMOOTH;
        const int32_t first = k - SMOOTH / 2, next = k + SMOOTH / 2 + 1;
        lines[k] = above > LOWEST_LINE ? (float)above : LOWEST_LINE;
        mean += lines[k];
        sum += level[next < FC_LINES ? next : FC_LINES - 1] - level[first > 0 ? first : 0];
    }
    mean /= FC_LINES;
    for (int32_t k = 0; k < FC_LINES; k++)
        lines[k] -= (float)mean;
}

static float deviation(const float *x)
{
    double mean = 0.0, squares = 0.0;
    for (int32_t k = 0; k < FC_LINES; k++)
        mean += x[k];
    mean /= FC_LINES;
    for (int32_t k = 0; k < FC_LINES; k++)
        squares += (x[k] - mean) * (x[k] - mean);
    return (float)sqrt(squares / FC_LINES);
}

void fc_shift(const float *lines, const float *reference, int32_t *shift, float *correlation)
{
    const float scale = deviation(lines) * deviation(reference) + 1e-9f;
    *shift = 0;
    *correlation = -INFINITY;
    for (int32_t s = -FC_SHIFT_MOST; s <= FC_SHIFT_MOST; s++) {
        const int32_t first = s < 0 ? -s : 0, last = s > 0 ? FC_LINES - s : FC_LINES;
        /* Four sums side by side, which a processor adds at the same time. */
        float a = 0.0f, b = 0.0f, c = 0.0f, d = 0.0f;
        const float *x = lines + first + s, *y = reference + first;
        const float *const end = reference + last;
        for (; y + 4 <= end; x += 4, y += 4) {
            a += x[0] * y[0];
            b += x[1] * y[1];
            c += x[2] * y[2];
            d += x[3] * y[3];
        }
        for (; y < end; x++, y++)
            a += *x * *y;
        const float sum = (a + b) + (c + d);
        const float overlap = (float)sqrt((double)(last - first) * FC_LINES);
        const float fit = sum / overlap / scale;
        if (fit > *correlation) {
            *correlation = fit;
            *shift = s;
        }
    }
}
