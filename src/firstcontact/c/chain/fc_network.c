#include "fc_network.h"

#include "fc_assert.h"
#include "fc_math.h"

/* Only Thumb code loads any two registers at once. */
#if defined(__ARM_FEATURE_SIMD32) && defined(__thumb2__)
#define FC_PRODUCTS_IN_PAIRS
#include <arm_acle.h>
#endif

/* Standard deviations from the mean at which inputs are clipped. */
static const float FARTHEST = 6.0f;
/* Shore A is CENTRE + UNIT times an output. Bounds of ln(standard deviation / UNIT). */
static const double CENTRE = 40.0, UNIT = 40.0, MEAN_SCALE = 0.6, NARROWEST = -4.0, WIDEST = 2.0;

/* Round n numbers to 15 bits. Return the unit of the integers. */
static float round_all(const float *x, int32_t n, int16_t *rounded)
{
    float most = 0.0f;
    FC_UNROLL
    for (int32_t k = 0; k < n; k++) {
        const float size = fabsf(x[k]);
        most = size > most ? size : most;
    }
    const float each = most > 1e-30f ? 32767.0f / most : 0.0f;
    FC_UNROLL
    for (int32_t k = 0; k < n; k++) {
        /* Adding 1.5 * 2^23 rounds. The lowest bits of the sum are then the integer. */
        const float shifted = x[k] * each + 12582912.0f;
        uint32_t bits;
        memcpy(&bits, &shifted, sizeof bits);
        rounded[k] = (int16_t)(uint16_t)bits;
    }
    for (int32_t k = n; k % 4 != 0; k++)
        rounded[k] = 0;
    return most / 32767.0f;
}

#if defined(FC_PRODUCTS_IN_PAIRS)
/* Four numbers, which one instruction loads. The compiler would take three for it and the pointer. */
typedef struct {
    int16x2_t low, high;
} four;

static inline four next_four(const int16_t **at)
{
    four x;
    __asm__("ldrd %0, %1, [%2], #8" : "=r"(x.low), "=r"(x.high), "+r"(*at) : : "memory");
    return x;
}

static inline int32_t add_products(four a, four b, int32_t sum)
{
    return __smlad(a.high, b.high, __smlad(a.low, b.low, sum));
}

/* Multiply four rows at a time, so that each input is loaded once for all four. */
static void multiply(const fc_matrix *m, const int16_t *x, int32_t *sums)
{
    const int32_t columns = (m->columns + 3) / 4 * 4;
    int32_t i = 0;
    for (; i + 4 <= m->rows; i += 4) {
        const int16_t *a = m->weight + i * columns, *b = a + columns, *c = b + columns;
        const int16_t *d = c + columns, *y = x;
        int32_t p = 0, q = 0, r = 0, s = 0;
        FC_UNROLL
        while (y != x + columns) {
            const four inputs = next_four(&y);
            p = add_products(next_four(&a), inputs, p);
            q = add_products(next_four(&b), inputs, q);
            r = add_products(next_four(&c), inputs, r);
            s = add_products(next_four(&d), inputs, s);
        }
        sums[i] = p;
        sums[i + 1] = q;
        sums[i + 2] = r;
        sums[i + 3] = s;
    }
    for (; i < m->rows; i++) {
        const int16_t *a = m->weight + i * columns, *y = x;
        int32_t sum = 0;
        while (y != x + columns)
            sum = add_products(next_four(&a), next_four(&y), sum);
        sums[i] = sum;
    }
}
#else
FC_WIDE static void multiply(const fc_matrix *m, const int16_t *restrict x, int32_t *restrict sums)
{
    const int32_t columns = (m->columns + 3) / 4 * 4;
    for (int32_t i = 0; i < m->rows; i++) {
        const int16_t *const row = m->weight + i * columns;
        int32_t sum = 0;
        for (int32_t k = 0; k < columns; k++)
            sum += (int32_t)row[k] * x[k];
        sums[i] = sum;
    }
}
#endif

/* Multiply `x` by a matrix. */
static void apply(const fc_matrix *m, const float *x, fc_network_room *room, float *out)
{
    const float unit = round_all(x, m->columns, room->rounded);
    multiply(m, room->rounded, room->sums);
    FC_UNROLL
    for (int32_t i = 0; i < m->rows; i++)
        out[i] = (float)room->sums[i] * (m->scale[i] * unit);
}

/* Add the bias, and apply the SiLU. */
FC_WIDE static void silu(float *restrict x, const float *restrict bias, int32_t n)
{
    FC_UNROLL
    for (int32_t k = 0; k < n; k++) {
        const float y = x[k] + bias[k];
        x[k] = y / (1.0f + fc_expf(-y));
    }
}

/* Compute mean and standard deviation of a mixture of normal distributions. */
static void moments(const float *raw, double *mean_of_all, double *spread_of_all)
{
    double sum = 0.0, value = 0.0, square = 0.0;
    float most = raw[0];
    for (int32_t k = 1; k < FC_COMPONENTS; k++)
        most = raw[k] > most ? raw[k] : most;
    for (int32_t k = 0; k < FC_COMPONENTS; k++) {
        const double weight = fc_exp((double)raw[k] - most);
        const double mean = raw[FC_COMPONENTS + k] * (UNIT * MEAN_SCALE) + CENTRE;
        const double sd
            = UNIT * fc_exp(fc_bounded(raw[2 * FC_COMPONENTS + k], NARROWEST, WIDEST));
        sum += weight;
        value += weight * mean;
        square += weight * (sd * sd + mean * mean);
    }
    value /= sum;
    const double variance = square / sum - value * value;
    *mean_of_all = value;
    *spread_of_all = sqrt(variance > 1e-4 ? variance : 1e-4);
}

void fc_network_predict(const fc_network *n, const float *rig_term, fc_network_room *room,
                        double *mean, double *spread)
{
    FC_ASSERT(n != NULL && rig_term != NULL && room != NULL && mean != NULL && spread != NULL);
    float *const x = room->values, raw[3 * FC_COMPONENTS];
    for (int32_t k = 0; k < n->inputs; k++) {
        const float y = (x[k] - n->mean[k]) / n->sd[k];
        x[k] = y > -FARTHEST ? (y < FARTHEST ? y : FARTHEST) : -FARTHEST; /* NaN becomes finite */
    }
    for (int32_t i = 0; i < FC_LAYERS; i++) {
        const fc_layer *const layer = n->layers + i;
        apply(&layer->into, x, room, room->thin);
        for (int32_t k = 0; i == FC_RIG_LAYER && k < layer->into.rows; k++)
            room->thin[k] += rig_term[k];
        apply(&layer->out, room->thin, room, x);
        silu(x, layer->bias, layer->out.rows);
    }
    const int32_t last = n->layers[FC_LAYERS - 1].out.rows;
    for (int32_t i = 0; i < 3 * FC_COMPONENTS; i++) {
        float sum = n->output_bias[i];
        FC_UNROLL
        for (int32_t k = 0; k < last; k++)
            sum += n->output[i * last + k] * x[k];
        raw[i] = sum;
    }
    moments(raw, mean, spread);
}
