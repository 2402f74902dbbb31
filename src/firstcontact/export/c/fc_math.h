/* Exponential and logarithm in plain arithmetic: the same bits on every machine, and a third of
   the instructions of libm's. */
#ifndef FC_MATH_H
#define FC_MATH_H

#include <math.h>
#include <stdint.h>
#include <string.h>

/* The root of a number that is not below 0: the one instruction, where a compiler would ask after it
   for an errno that nobody reads. */
static inline double fc_sqrt(double x)
{
#if defined(__GNUC__) && defined(__ARM_FP) && (__ARM_FP & 8) && !defined(__aarch64__)
    double y;
    __asm__("vsqrt.f64 %P0, %P1" : "=w"(y) : "w"(x));
    return y;
#else
    return sqrt(x);
#endif
}

/* exp(x), relative error below 3e-7; 0 below -87, infinite above 88, NaN for NaN. */
static inline float fc_exp(float x)
{
    if (!(x > -87.0f))
        return x == x ? 0.0f : x;
    if (x > 88.0f)
        return INFINITY;
    /* 2^(n + r) with |r| <= 1/2; n by adding and taking off 1.5 * 2^23, whose low bits then are n. */
    const float turned = fmaf(x, 1.44269504f, 12582912.0f), n = turned - 12582912.0f;
    const float r = fmaf(x, 1.92596299e-8f, fmaf(x, 1.44269504f, -n));
    float y = fmaf(1.32254e-3f, r, 9.675669e-3f);
    y = fmaf(y, r, 5.550864e-2f);
    y = fmaf(y, r, 2.402213e-1f);
    y = fmaf(y, r, 6.9314694e-1f);
    y = fmaf(y, r, 1.0f);
    uint32_t power, bits;
    memcpy(&power, &turned, sizeof power);
    memcpy(&bits, &y, sizeof bits);
    bits += power << 23;
    memcpy(&y, &bits, sizeof y);
    return y;
}

/* 64 pairs: an inverse near 1 / m in the middle of each 64th from 1 to 2, and minus its logarithm. */
extern const double fc_log_table[128];

/* ln(x) of a normal x above 0, error below 5e-14. */
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

/* (log2(x) + 1023) 2^20 of the same, by up to FC_COARSELY too small: a straight line between
   powers of 2, which is what a number's upper half is. */
#define FC_COARSELY 90300.0
static inline double fc_log2_coarse(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (double)(int32_t)(bits >> 32);
}

/* ln(x) of the same, error below 2e-5 for x from 1e-12 to 1e12: where more is not needed. */
static inline float fc_log_rough(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    const uint32_t high = (uint32_t)(bits >> 32), part = (high & 0xfffffu) << 3 | 0x3f800000u;
    float m;
    memcpy(&m, &part, sizeof m);
    const float t = m - 1.0f;
    float y = fmaf(2.9808765e-2f, t, -1.2995720e-1f);
    y = fmaf(y, t, 2.8382319e-1f);
    y = fmaf(y, t, -4.8969910e-1f);
    y = fmaf(y, t, 9.9916643e-1f);
    y = fmaf(y, t, 1.1447098e-5f);
    return fmaf((float)((int32_t)(high >> 20) - 1023), 0.69314718f, y);
}

#endif
