/* Exponential and logarithm in plain arithmetic, so that every machine computes the same bits.
   Compile with -ffp-contract=off and without -ffast-math. All arguments are inputs without a unit. */
#ifndef FC_MATH_H
#define FC_MATH_H

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__FAST_MATH__)
#error "compile without -ffast-math: other machines would compute other bits"
#endif
#if FLT_EVAL_METHOD < 0 || FLT_EVAL_METHOD == 1 || FLT_EVAL_METHOD == 2
#error "compile with -mfpmath=sse: other machines would compute other bits"
#endif
/* A negative size stops the compiler: with -fsingle-precision-constant, or a double of 32 bits. */
typedef char fc_doubles_have_64_bits[sizeof(0.1) == 8 ? 1 : -1];

/* GCC fuses products and sums by default where the processor can. Results would differ. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("fp-contract=off")
#elif defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

/* On a computer, the compiler makes one version for each vector unit. All give the same bits. */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__GLIBC__)
#define FC_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define FC_WIDE
#endif

/* On a microcontroller, GCC repeats the body of a loop, which saves a tenth of the instructions. */
#if defined(__GNUC__) && !defined(__clang__) && defined(__arm__)
#define FC_UNROLL _Pragma("GCC unroll 4")
#else
#define FC_UNROLL
#endif

/* Return x within bounds. NaN stays NaN. */
static inline double fc_bounded(double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}

/* Return exp(x) with a relative error below 4e-16. x must be at most 700; below -700 it is 0. */
static inline double fc_exp(double x)
{
    if (!(x > -700.0))
        return x == x ? 0.0 : x;
    /* exp(x) is 2^n exp(r). Adding and subtracting 1.5 * 2^52 rounds to the integer n. */
    const double shifted = x * 1.44269504088896340736 + 6755399441055744.0;
    const double n = shifted - 6755399441055744.0;
    const double r = (x - n * 6.93147180369123816490e-01) - n * 1.90821492927058770002e-10;
    double y = 1.0 / 6227020800.0;
    y = y * r + 1.0 / 479001600.0;
    y = y * r + 1.0 / 39916800.0;
    y = y * r + 1.0 / 3628800.0;
    y = y * r + 1.0 / 362880.0;
    y = y * r + 1.0 / 40320.0;
    y = y * r + 1.0 / 5040.0;
    y = y * r + 1.0 / 720.0;
    y = y * r + 1.0 / 120.0;
    y = y * r + 1.0 / 24.0;
    y = y * r + 1.0 / 6.0;
    y = y * r + 0.5;
    y = y * r + 1.0;
    y = y * r + 1.0;
    const uint64_t power = (uint64_t)(uint32_t)((int32_t)n + 1023) << 52;
    double scale;
    memcpy(&scale, &power, sizeof scale);
    return y * scale;
}

/* Return exp(x) with a relative error below 3e-7 (Cephes). x is clipped to -80 and 80. */
static inline float fc_expf(float x)
{
    if (fabsf(x) > 80.0f)
        x = x < 0.0f ? -80.0f : 80.0f;
    const float shifted = x * 1.44269504088896341f + 12582912.0f, n = shifted - 12582912.0f;
    const float r = (x - n * 0.693359375f) + n * 2.12194440e-4f;
    float y = 1.9875691500e-4f;
    y = y * r + 1.3981999507e-3f;
    y = y * r + 8.3334519073e-3f;
    y = y * r + 4.1665795894e-2f;
    y = y * r + 1.6666665459e-1f;
    y = y * r + 5.0000001201e-1f;
    y = (y * (r * r) + r) + 1.0f;
    uint32_t power; /* the lowest bits of `shifted` are n */
    float scale;
    memcpy(&power, &shifted, sizeof power);
    power = (power + 127u) << 23;
    memcpy(&scale, &power, sizeof scale);
    return y * scale;
}

/* 64 pairs: 1 / m at the middle of each 64th from 1 to 2, and minus the logarithm of this number. */
extern const double fc_log_table[128];

/* Return ln(x) with an error below 5e-14. x must be a normal number above 0. */
static inline double fc_log(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    const uint32_t high = (uint32_t)(bits >> 32);
    const double *const pair = fc_log_table + 2 * ((high >> 14) & 63u);
    bits = (uint64_t)((high & 0xfffffu) | 0x3ff00000u) << 32 | (uint32_t)bits;
    double m;
    memcpy(&m, &bits, sizeof m);
    const double r = m * pair[0] - 1.0, s = r * r;
    const double series = r + s * ((-0.5 + r * (1.0 / 3)) + s * (-0.25 + r * 0.2));
    return ((int32_t)(high >> 20) - 1023) * 0.69314718055994530942 + (pair[1] + series);
}

#endif
