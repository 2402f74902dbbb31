/* Exponential and logarithm in plain arithmetic: the same bits on every machine, and a third of
   the instructions of libm's. */
#ifndef FC_MATH_H
#define FC_MATH_H

#include <stdint.h>
#include <string.h>

/* exp(x), relative error below 2e-7; 0 below -87, infinite above 88, NaN for NaN. */
static inline float fc_exp(float x)
{
    if (!(x > -87.0f))
        return x == x ? 0.0f : x;
    if (x > 88.0f) {
        const uint32_t infinite = 0x7f800000u;
        float y;
        memcpy(&y, &infinite, sizeof y);
        return y;
    }
    /* x = n ln 2 + r with |r| <= ln 2 / 2; n by adding and taking off 1.5 * 2^23. */
    const float turned = x * 1.44269504f + 12582912.0f;
    const float n = turned - 12582912.0f;
    const float r = (x - n * 0.693359375f) + n * 2.12194440e-4f;
    const float p =
        ((((1.9875691e-4f * r + 1.3981999e-3f) * r + 8.3334519e-3f) * r + 4.1665796e-2f) * r +
         1.6666665e-1f) * r + 5.0000001e-1f;
    const float y = (p * r) * r + r + 1.0f;
    uint32_t bits;
    float power;
    bits = (uint32_t)((int32_t)n + 127) << 23;
    memcpy(&power, &bits, sizeof power);
    return y * power;
}

/* ln(x) of a normal x above 0, relative error below 1e-15 or so. */
static inline double fc_log(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    int32_t high = (int32_t)(bits >> 32);
    /* x = 2^n m, m from sqrt(1/2) to sqrt(2). */
    const int32_t n = (high - 0x3fe6a09e) >> 20;
    bits = (uint64_t)(uint32_t)(high - n * 0x100000) << 32 | (uint32_t)bits;
    double m;
    memcpy(&m, &bits, sizeof m);
    const double s = (m - 1.0) / (m + 1.0);
    const double z = s * s;
    /* 2 atanh(s); the series' next term is below 2e-16. */
    const double p = z * (1.0 / 3 + z * (1.0 / 5 + z * (1.0 / 7 + z * (1.0 / 9 + z * (1.0 / 11 +
                     z * (1.0 / 13 + z * (1.0 / 15 + z * (1.0 / 17 + z / 19))))))));
    return n * 0.69314718055994530942 + 2.0 * (s + s * p);
}

#endif
