#include "kernels.h"

#include <math.h>

static const double COUNT = 3.2e-3, LOWEST_LINE = -1.0;

/* Fourier transform of HALF complex numbers (re, im), in place. turn: sin of 2 pi k / (2 * HALF) for
   k up to 5 / 4 of a turn. */
static void transform(double (*z)[2], const double *turn)
{
    for (int32_t i = 1, j = 0; i < HALF; i++) {
        int32_t bit = HALF >> 1;
        for (; j & bit; bit >>= 1)
            j ^= bit;
        j ^= bit;
        if (i < j) {
            const double re = z[i][0], im = z[i][1];
            z[i][0] = z[j][0];
            z[i][1] = z[j][1];
            z[j][0] = re;
            z[j][1] = im;
        }
    }
    for (int32_t length = 2; length <= HALF; length *= 2) {
        const int32_t half = length / 2, step = 2 * HALF / length;
        for (int32_t start = 0; start < HALF; start += length)
            for (int32_t k = 0; k < half; k++) {
                const double re = turn[HALF / 2 + k * step], im = -turn[k * step];
                double *const a = z[start + k], *const b = z[start + k + half];
                const double x = b[0] * re - b[1] * im, y = b[0] * im + b[1] * re;
                b[0] = a[0] - x;
                b[1] = a[1] - y;
                a[0] += x;
                a[1] += y;
            }
    }
}

/* Power of line k of 2 * HALF real numbers, from the transform of their pairs. */
static double power(double (*z)[2], const double *turn, int32_t k)
{
    const double *const a = z[k % HALF], *const b = z[(HALF - k) % HALF];
    const double even_re = (a[0] + b[0]) / 2, even_im = (a[1] - b[1]) / 2;
    const double odd_re = (a[1] + b[1]) / 2, odd_im = (b[0] - a[0]) / 2;
    const double re = turn[HALF / 2 + k], im = -turn[k];
    const double x = even_re + odd_re * re - odd_im * im;
    const double y = even_im + odd_re * im + odd_im * re;
    return x * x + y * y;
}

static double deviation(const double *x, int32_t n)
{
    double mean = 0.0, squares = 0.0;
    for (int32_t k = 0; k < n; k++)
        mean += x[k];
    mean /= n;
    for (int32_t k = 0; k < n; k++)
        squares += (x[k] - mean) * (x[k] - mean);
    return sqrt(squares / n);
}

/* Lines above the smooth part of the spectrum, with mean 0. */
static void lines_of(const fc_ear *e, const float *signal, double *lines)
{
    double z[HALF][2], sums[LINES + SMOOTH + 1], mean = 0.0;
    for (int32_t k = 0; k < e->heard; k++)
        mean += signal[k];
    mean /= e->heard;
    for (int32_t k = 0; k < 2 * HALF; k++)
        z[k / 2][k % 2] = k < e->heard ? (signal[k] - mean) * e->fade[k] : 0.0;
    transform(z, e->turn);
    for (int32_t k = 0; k < LINES; k++) {
        const int32_t cell = e->cell[k];
        const double below = power(z, e->turn, cell) / (COUNT * COUNT);
        const double above = power(z, e->turn, cell + 1) / (COUNT * COUNT);
        lines[k] = log(below * (1.0 - e->part[k]) + above * e->part[k] + 1e-3);
    }
    sums[0] = 0.0;
    for (int32_t k = 0; k < LINES + SMOOTH - 1; k++) {
        const int32_t at = k - SMOOTH / 2;
        sums[k + 1] = sums[k] + lines[at < 0 ? 0 : at < LINES ? at : LINES - 1];
    }
    mean = 0.0;
    for (int32_t k = 0; k < LINES; k++) {
        const double above = lines[k] - (sums[k + SMOOTH] - sums[k]) / SMOOTH;
        lines[k] = above > LOWEST_LINE ? above : LOWEST_LINE;
        mean += lines[k];
    }
    mean /= LINES;
    for (int32_t k = 0; k < LINES; k++)
        lines[k] -= mean;
}

/* Correlate at all shifts; shifts[FARTHEST_SHIFT] is at 0. */
WIDE static void correlate(const double *restrict padded, const double *restrict reference,
                           double *restrict shifts)
{
    for (int32_t s = 0; s <= 2 * FARTHEST_SHIFT; s++)
        shifts[s] = 0.0;
    for (int32_t k = 0; k < LINES; k++)
        for (int32_t s = 0; s <= 2 * FARTHEST_SHIFT; s++)
            shifts[s] += padded[k + s] * reference[k];
}

void fc_listen(const fc_ear *e, const double *reference, const float *signal, int32_t *shift,
               double *alike)
{
    double padded[LINES + 2 * FARTHEST_SHIFT] = {0.0}, shifts[2 * FARTHEST_SHIFT + 1];
    double *const lines = padded + FARTHEST_SHIFT;
    lines_of(e, signal, lines);
    const double scale = deviation(lines, LINES) * deviation(reference, LINES) + 1e-9;
    *alike = -INFINITY;
    *shift = 0;
    correlate(padded, reference, shifts);
    for (int32_t s = -FARTHEST_SHIFT; s <= FARTHEST_SHIFT; s++) {
        const double even = sqrt((double)(LINES - (s < 0 ? -s : s)) * LINES);
        const double fit = shifts[s + FARTHEST_SHIFT] / even / scale;
        if (fit > *alike) {
            *alike = fit;
            *shift = s;
        }
    }
}
