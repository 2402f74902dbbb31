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

/* A sample of the steady state. */
static void hear(fc_channel *c, uint32_t n, double volts)
{
    if (n == 0) {
        c->first = volts;
        c->sum = c->squares = 0.0;
    }
    const double x = c->steady[n] = volts - c->first;
    c->sum += x;
    c->squares = fma(x, x, c->squares);
    fc_judge_hear(&c->judge, c->steady, n);
}

static void keep(fc_channel *c, uint32_t n, double x)
{
    x = (x - c->mean) / c->sigma;
    c->past[n % FC_RING] = c->past[n % FC_RING + FC_RING] = x;
}

/* One after the newest of so many samples; FC_RING of them lie before it. */
static const double *newest(const fc_channel *c, uint32_t count)
{
    return c->past + FC_RING + count % FC_RING;
}

/* Mean and sigma, and the samples that the first window still needs. The first sample is in the
   sigma: it is sqrt(FC_STEADY) sigmas from the mean at most, which bounds what cancels here. */
static void settle(fc_channel *c)
{
    c->mean = c->sum / FC_STEADY;
    const double spread = c->squares - c->mean * c->sum;
    c->sigma = spread > 0.0 ? sqrt(spread / FC_STEADY) : INFINITY;
    fc_judge_settle(&c->judge, c->steady, c->mean, spread);
    for (uint32_t n = FC_STEADY - FC_WINDOW; n < FC_STEADY; n++)
        keep(c, n, c->steady[n]);
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
            hear(d->channel + k, n, volts[k]);
            if (d->count == FC_STEADY)
                settle(d->channel + k);
        }
        return 0;
    }
    for (int32_t k = 0; k < FC_CHANNELS; k++) {
        fc_channel *const c = d->channel + k;
        /* The judge learns of the past before the first window is whole, not of all in one sample. */
        if (n == FC_STEADY + (uint32_t)(k > 0 && FC_STEP > 1) && !c->latched)
            fc_judge_recall(&c->judge, newest(c, FC_STEADY));
        keep(c, n, volts[k] - c->first);
    }
    if (d->count != d->window_end)
        return 0;
    d->window_end += FC_STEP;
    /* A channel whose contact was told is not judged again before it settles anew. */
    for (int32_t k = 0; k < FC_CHANNELS; k++)
        if (!d->channel[k].latched)
            fc_judge_step(&d->channel[k].judge, newest(d->channel + k, d->count), d->count);
    return judge(d, contacts);
}
