#include "fc_exact.h"
#include "fc_whole.h"

#include <math.h>
#include <string.h>

#if defined(__ARM_FEATURE_SIMD32)
#include <arm_acle.h>
#endif

/* a[0] b[0] + a[1] b[1] + sum: one instruction on a Cortex-M7. */
static inline int32_t pair(const int16_t *a, const int16_t *b, int32_t sum)
{
#if defined(__ARM_FEATURE_SIMD32)
    int16x2_t x, y;
    memcpy(&x, a, sizeof x);
    memcpy(&y, b, sizeof y);
    return __smlad(x, y, sum);
#else
    return sum + a[0] * b[0] + a[1] * b[1];
#endif
}

float fc_round(const float *x, int32_t n, int16_t *rounded)
{
    float most = 0.0f;
    for (int32_t k = 0; k < n; k++) {
        const float size = fabsf(x[k]);
        most = size > most ? size : most;
    }
    const float each = most > 1e-30f ? 32767.0f / most : 0.0f;
    for (int32_t k = 0; k < n; k++) {
        const float y = x[k] * each;
        rounded[k] = (int16_t)(y < 0.0f ? y - 0.5f : y + 0.5f);
    }
    for (int32_t k = n; k % 4 != 0; k++)
        rounded[k] = 0;
    return most / 32767.0f;
}

void fc_whole_run(const fc_whole *s, const int16_t *rounded, float unit, const float *bias,
                  float *out)
{
    const int32_t columns = (s->inputs + 3) / 4 * 4;
    const float *const own = bias != NULL ? bias : s->bias;
    int32_t i = 0;
    for (; i + 4 <= s->outputs; i += 4) {
        const int16_t *a = s->weight + i * columns, *b = a + columns, *c = b + columns;
        const int16_t *d = c + columns, *x = rounded;
        const int16_t *const end = rounded + columns;
        int32_t sum[4] = {0, 0, 0, 0};
        for (; x != end; x += 4, a += 4, b += 4, c += 4, d += 4) {
            sum[0] = pair(a + 2, x + 2, pair(a, x, sum[0]));
            sum[1] = pair(b + 2, x + 2, pair(b, x, sum[1]));
            sum[2] = pair(c + 2, x + 2, pair(c, x, sum[2]));
            sum[3] = pair(d + 2, x + 2, pair(d, x, sum[3]));
        }
        for (int32_t j = 0; j < 4; j++)
            out[i + j] = (float)sum[j] * (s->scale[i + j] * unit) + own[i + j];
    }
    for (; i < s->outputs; i++) {
        int32_t sum = 0;
        for (int32_t k = 0; k < columns; k += 2)
            sum = pair(s->weight + i * columns + k, rounded + k, sum);
        out[i] = (float)sum * (s->scale[i] * unit) + own[i];
    }
}
