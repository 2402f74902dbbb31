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

/* Mean and sigma of a channel; 0 for one that does not move: a range knows exactly what is flat. */
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
    c->sigma = high > low ? sqrt(squares / FC_STEADY) : 0.0;
}

static double normal(const fc_channel *c, double volts)
{
    return c->sigma > 0.0 ? (volts - c->mean) / c->sigma : 0.0;
}

static void settle(fc_channel *c)
{
    measure(c);
    for (int32_t k = 0; k < FC_STEADY; k++)
        c->steady[k] = normal(c, c->steady[k]);
    fc_judge_settle(&c->judge, c->steady);
    for (uint32_t n = 0; n < FC_STEADY; n++) {
        c->past[n % FC_RING] = c->steady[n];
        fc_judge_take(&c->judge, c->past, n);
        if ((FC_STEADY - 1 - n) % FC_STEP == 0)
            fc_judge_step(&c->judge);
    }
}

/* Whether any channel was loud in the newest step: else no window is worth a judgement. */
static bool awake(const fc_detector *d)
{
    for (int32_t c = 0; c < FC_CHANNELS; c++)
        for (uint32_t k = 1; k <= FC_STEP; k++)
            if (fc_judge_wakes(fabs(d->channel[c].past[(d->count - k) % FC_RING])))
                return true;
    return false;
}

static int32_t judge(fc_detector *d, fc_contact *contacts)
{
    int32_t found = 0;
    if (!awake(d))
        return 0;
    for (int32_t k = 0; k < FC_CHANNELS; k++) {
        fc_channel *const c = &d->channel[k];
        if (c->latched || !(c->sigma > 0.0) || !fc_judge_fires(&c->judge, c->past, d->count))
            continue;
        c->latched = true;
        const fc_contact contact = {k, d->next - fc_onset(c->past, d->count), d->next - 1};
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
    for (int32_t k = 0; k < FC_CHANNELS; k++) {
        fc_channel *const c = &d->channel[k];
        if (n < FC_STEADY) {
            c->steady[n] = volts[k];
            if (d->count == FC_STEADY)
                settle(c);
            continue;
        }
        c->past[n % FC_RING] = normal(c, volts[k]);
        fc_judge_take(&c->judge, c->past, n);
        if (d->count == d->window_end)
            fc_judge_step(&c->judge);
    }
    if (d->count != d->window_end)
        return 0;
    d->window_end += FC_STEP;
    return judge(d, contacts);
}
