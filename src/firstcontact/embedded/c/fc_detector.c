#include "fc_exact.h"
#include "fc_detector.h"

#include <math.h>

#include "fc_math.h"
#include "fc_onset.h"

void fc_detector_gap(fc_detector *d, uint32_t next)
{
    d->next = next;
    d->count = 0;
    d->window_end = FC_STEADY + FC_STEP;
}

void fc_detector_start(fc_detector *d, uint32_t next)
{
    fc_detector_gap(d, next);
    for (int32_t c = 0; c < FC_CHANNELS; c++)
        d->channel[c].latched = false;
}

/* Mean and sigma of a channel; infinite for one that does not move, of which a range knows exactly. */
static void measure(fc_channel *c)
{
    double sum = 0.0, squares = 0.0, low = c->steady[0], high = low;
    for (int32_t k = 0; k < FC_STEADY; k++) {
        const double v = c->steady[k];
        sum += v;
        low = v < low ? v : low;
        high = v > high ? v : high;
    }
    c->mean = sum / FC_STEADY;
    for (int32_t k = 0; k < FC_STEADY; k++)
        squares += (c->steady[k] - c->mean) * (c->steady[k] - c->mean);
    c->sigma = high > low ? sqrt(squares / FC_STEADY) : INFINITY;
}

static double normal(const fc_channel *c, double volts)
{
    return (volts - c->mean) / c->sigma;
}

static void keep(fc_channel *c, uint32_t n, double x)
{
    c->past[n % FC_RING] = c->past[n % FC_RING + FC_RING] = x;
}

/* One after the newest of so many samples; FC_RING of them lie before it. */
static const double *newest(const fc_channel *c, uint32_t count)
{
    return c->past + FC_RING + count % FC_RING;
}

static void settle(fc_channel *c)
{
    measure(c);
    for (int32_t k = 0; k < FC_STEADY; k++)
        c->steady[k] = normal(c, c->steady[k]);
    fc_judge_settle(&c->judge, c->steady);
    for (uint32_t n = 0; n < FC_STEADY; n++) {
        keep(c, n, c->steady[n]);
        if (n > FC_STEP && (FC_STEADY - 1 - n) % FC_STEP == 0)
            fc_judge_step(&c->judge, newest(c, n + 1), n + 1);
    }
}

/* Whether any channel was loud in the newest step: else no window is worth a judgement. */
static bool awake(const fc_detector *d)
{
    for (int32_t c = 0; c < FC_CHANNELS; c++) {
        const double *const end = newest(&d->channel[c], d->count);
        for (const double *x = end - FC_STEP; x < end; x++)
            if (fc_judge_wakes(fabs(*x)))
                return true;
    }
    return false;
}

static int32_t judge(fc_detector *d, fc_contact *contacts)
{
    int32_t found = 0;
    if (!awake(d))
        return 0;
    for (int32_t k = 0; k < FC_CHANNELS; k++) {
        fc_channel *const c = &d->channel[k];
        const double *const end = newest(c, d->count);
        if (c->latched || !(c->sigma < INFINITY) || !fc_judge_fires(&c->judge, end, d->count))
            continue;
        c->latched = true;
        const fc_contact contact = {k, d->next - fc_onset(end), d->next - 1};
        int32_t place = found++;
        for (; place > 0 && contacts[place - 1].sample > contact.sample; place--)
            contacts[place] = contacts[place - 1];
        contacts[place] = contact;
    }
    return found;
}

int32_t fc_detector_take(fc_detector *d, const double *volts, fc_contact *contacts)
{
    for (int32_t k = 0; k < FC_CHANNELS; k++)
        if (!(volts[k] - volts[k] == 0.0)) {
            fc_detector_gap(d, d->next + 1);
            return 0;
        }
    const uint32_t n = d->count++;
    d->next++;
    if (n < FC_STEADY) {
        for (int32_t k = 0; k < FC_CHANNELS; k++) {
            d->channel[k].steady[n] = volts[k];
            if (d->count == FC_STEADY)
                settle(d->channel + k);
        }
        return 0;
    }
    for (int32_t k = 0; k < FC_CHANNELS; k++)
        keep(d->channel + k, n, normal(d->channel + k, volts[k]));
    if (d->count != d->window_end)
        return 0;
    d->window_end += FC_STEP;
    /* A channel whose contact was told is not judged again before it settles anew. */
    for (int32_t k = 0; k < FC_CHANNELS; k++)
        if (!d->channel[k].latched)
            fc_judge_step(&d->channel[k].judge, newest(d->channel + k, d->count), d->count);
    return judge(d, contacts);
}
