#include "fc_pitch.h"

#include <string.h>

#include "fc_math.h"

enum { HALF = FC_TURN / 2, QUARTER = FC_TURN / 4, SMOOTH = 61 };
/* Peaks are wider than so many points: a first search for the best shift uses each of them alone. */
enum { EACH = 4 };
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
            FC_UNROLL
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
    memset(work, 0, sizeof(float) * FC_TURN);
    for (int32_t k = 0; k < e->samples; k++)
        work[k] = (float)(signal[k] - mean) * e->fade[k];
    transform(e->sine, z);
    double level[FC_LINES], below = 0.0, above = 0.0;
    int32_t line = -2; /* of `below`; neighbouring points share lines */
    for (int32_t k = 0; k < FC_LINES; k++) {
        const int32_t cell = e->cell[k];
        if (cell != line) {
            below = cell == line + 1 ? above : power(e->sine, z, cell);
            above = power(e->sine, z, cell + 1);
            line = cell;
        }
        level[k] = fc_log(below + (above - below) * e->part[k] + LEAST_POWER);
    }
    for (int32_t k = -SMOOTH / 2; k <= SMOOTH / 2; k++)
        sum += level[k > 0 ? k : 0];
    mean = 0.0;
    for (int32_t k = 0; k < FC_LINES; k++) {
        const double peak = level[k] - sum / SMOOTH;
        const int32_t first = k - SMOOTH / 2, next = k + SMOOTH / 2 + 1;
        lines[k] = peak > LOWEST_LINE ? (float)peak : LOWEST_LINE;
        mean += lines[k];
        sum += level[next < FC_LINES ? next : FC_LINES - 1] - level[first > 0 ? first : 0];
    }
    mean /= FC_LINES;
    for (int32_t k = 0; k < FC_LINES; k++)
        lines[k] -= (float)mean;
}

static float deviation(const float *x)
{
    double sum = 0.0, squares = 0.0;
    for (int32_t k = 0; k < FC_LINES; k++) {
        sum += x[k];
        squares += (double)x[k] * x[k];
    }
    const double mean = sum / FC_LINES, variance = squares / FC_LINES - mean * mean;
    return variance > 0.0 ? (float)sqrt(variance) : 0.0f;
}

/* Correlation of n points at a shift, without the scale of the spectra. */
static float fit_at(const float *lines, const float *reference, int32_t n, int32_t shift)
{
    const int32_t first = shift < 0 ? -shift : 0, last = shift > 0 ? n - shift : n;
    /* Four sums side by side, which a processor adds at the same time. */
    float a = 0.0f, b = 0.0f, c = 0.0f, d = 0.0f;
    const float *x = lines + first + shift, *y = reference + first;
    const float *const end = reference + last;
    FC_UNROLL
    for (; y + 4 <= end; x += 4, y += 4) {
        a += x[0] * y[0];
        b += x[1] * y[1];
        c += x[2] * y[2];
        d += x[3] * y[3];
    }
    for (; y < end; x++, y++)
        a += *x * *y;
    return ((a + b) + (c + d)) / (float)sqrt((double)(last - first) * n);
}

/* Find the shift from `first` to `last` that fits best. Return the correlation there. */
static float best_fit(const float *lines, const float *reference, int32_t n, int32_t first,
                      int32_t last, int32_t *shift)
{
    float most = -INFINITY;
    for (int32_t s = first; s <= last; s++) {
        const float fit = fit_at(lines, reference, n, s);
        if (fit > most) {
            most = fit;
            *shift = s;
        }
    }
    return most;
}

void fc_shift(const float *lines, const float *reference, int32_t *shift, float *correlation)
{
    float few[FC_LINES / EACH], few_of_reference[FC_LINES / EACH];
    int32_t rough = 0;
    for (int32_t k = 0; k < FC_LINES / EACH; k++) {
        few[k] = lines[EACH * k];
        few_of_reference[k] = reference[EACH * k];
    }
    best_fit(few, few_of_reference, FC_LINES / EACH, -FC_SHIFT_MOST / EACH, FC_SHIFT_MOST / EACH,
             &rough);
    rough *= EACH;
    const int32_t low = rough - EACH + 1, high = rough + EACH - 1;
    *shift = 0;
    const float most = best_fit(lines, reference, FC_LINES, low > -FC_SHIFT_MOST ? low : -FC_SHIFT_MOST,
                                high < FC_SHIFT_MOST ? high : FC_SHIFT_MOST, shift);
    *correlation = most / (deviation(lines) * deviation(reference) + 1e-9f);
}
