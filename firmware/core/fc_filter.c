#include "fc_filter.h"

#include <string.h>

static uint16_t clipped(uint16_t count)
{
    return count < FC_ADC_COUNTS ? count : (uint16_t)(FC_ADC_COUNTS - 1);
}

void fc_smooth_init(fc_smooth *s)
{
    s->y = -1;
}

int16_t fc_smooth_step(fc_smooth *s, uint16_t count)
{
    const int32_t x = (int32_t)clipped(count) * FC_SUBCOUNTS;
    s->y = s->y < 0 ? x : (s->y + x) >> 1;
    return (int16_t)s->y;
}

void fc_means_init(fc_means *m)
{
    memset(m, 0, sizeof *m);
}

/* Return the reading of a taxel alone in its column. `mean` is its own mean, `others` the sum of the
   means of the column's other taxels.

   With conductances g of the taxels and G of the divider, a reading is u = g / (G + sum of all g), as
   a share of the supply. So u / (1 - sum of the other u) = g / (G + g). */
static int16_t alone(uint32_t mean, uint32_t others)
{
    const uint32_t full = FC_ADC_COUNTS * FC_SUBCOUNTS, top = (FC_ADC_COUNTS - 1) * FC_SUBCOUNTS;
    const uint32_t left = others < full ? full - others : 1;
    const uint32_t value = (mean * full + left / 2) / left;
    return (int16_t)(value < top ? value : top);
}

void fc_means_step(fc_means *m, uint8_t taxel, uint16_t count, int16_t out[FC_TAXELS])
{
    const uint16_t x = clipped(count);
    uint16_t *const reading = m->reading[taxel];
    if (!m->read[taxel]) {
        for (uint8_t j = 0; j < FC_READINGS; j++)
            reading[j] = x;
        m->sum[taxel] = (uint16_t)(x * FC_READINGS);
        m->read[taxel] = true;
    }
    m->sum[taxel] = (uint16_t)(m->sum[taxel] - reading[m->oldest] + x);
    reading[m->oldest] = x;
    if (taxel == FC_TAXELS - 1)
        m->oldest = (uint8_t)((m->oldest + 1) % FC_READINGS);
    uint32_t mean[FC_TAXELS], column[FC_COLUMNS] = {0};
    for (uint8_t k = 0; k < FC_TAXELS; k++) {
        mean[k] = m->sum[k] * (uint32_t)(FC_SUBCOUNTS / FC_READINGS);
        column[k % FC_COLUMNS] += mean[k];
    }
    for (uint8_t k = 0; k < FC_TAXELS; k++)
        out[k] = alone(mean[k], column[k % FC_COLUMNS] - mean[k]);
}
