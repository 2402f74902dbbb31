#include "fc_exact.h"
#include "fc_answers.h"
#include "fc_answers_model.h"

#include <string.h>

static const uint16_t moments[] = {FC_MOMENTS};

static bool before(uint32_t a, uint32_t b)
{
    return (int32_t)(a - b) < 0;
}

static double volts(int16_t value, double zero)
{
    return (value - zero) * FC_VOLT;
}

/* Send the number of late estimates at the beginning of a stream and when it has changed. */
static void tell_late(fc_answers *a, bool begins)
{
    uint8_t payload[FC_LATE_BYTES];
    const uint32_t skipped = a->skipped, unheard = a->device->unheard;
    const bool news = skipped != a->told_skipped || unheard != a->told_unheard;
    if (!a->device->streaming || !(news || begins))
        return;
    fc_device_tell(a->device, FC_LATE, payload, fc_put_late(payload, skipped, unheard));
    a->told_skipped = skipped;
    a->told_unheard = unheard;
}

/* Start a closing with this sample. */
static void begin(fc_answers *a, uint32_t sample)
{
    fc_detector_start(&a->detector, sample);
    a->open = true;
    a->since = sample;
    a->latched = 0;
    a->touched = a->second = a->over = a->still = false;
    a->answered = 0;
    memset(a->passed, 0, sizeof a->passed);
}

/* Start a stream, or continue it after a gap, with this sample. */
static void anew(fc_answers *a, uint32_t sample, bool gap)
{
    a->open = false;
    tell_late(a, !gap);
    if (!gap)
        a->stream = sample;
    fc_gate_start(&a->gate, a->image.floors, sample - a->stream);
    if (!a->image.gated && !gap)
        begin(a, sample);
}

static void tell_contact(fc_answers *a, const fc_contact *c, bool first)
{
    uint8_t payload[FC_CONTACT_BYTES];
    const size_t n = fc_put_contact(payload, c->sample, c->known, (uint8_t)c->channel, first);
    fc_device_tell(a->device, FC_CONTACT, payload, n);
    if (a->board.contact != NULL)
        a->board.contact(c, first);
}

static void tell_estimate(fc_answers *a, const fc_running *answer, uint8_t flags, uint32_t known,
                          int32_t samples, uint32_t took)
{
    uint8_t payload[FC_ESTIMATE_BYTES];
    fc_told told = {a->first.sample, known, (uint16_t)samples, (uint8_t)a->first.channel,
                    flags,           0.0f,  0.0f,              0.0f,
                    took};
    if (answer != NULL) {
        told.value = (float)answer->value;
        told.low = (float)answer->low;
        told.high = (float)answer->high;
    }
    const size_t n = fc_put_estimate(payload, &told);
    fc_device_tell(a->device, FC_ESTIMATE, payload, n);
    if (a->board.estimate != NULL)
        a->board.estimate(&told);
}

static double heard(const fc_answers *a, uint32_t sample)
{
    return volts(a->past[sample % FC_PAST][a->first.channel], FC_PIEZO_ZERO);
}

/* Give the touch its signal up to this sample: the samples before the contact, the baseline and the
   samples since. */
static bool begin_touch(fc_answers *a, uint32_t sample)
{
    static float quiet[FC_BEFORE];
    const uint32_t start = a->first.sample - FC_BEFORE;
    if ((int32_t)(a->first.sample - a->since) < FC_BEFORE || sample - start >= FC_PAST)
        return false;
    double baseline = 0.0;
    for (uint32_t k = 0; k < FC_BASELINE; k++)
        baseline += heard(a, a->first.sample - FC_GUARD - FC_BASELINE + k);
    baseline /= FC_BASELINE;
    for (uint32_t k = 0; k < FC_BEFORE; k++)
        quiet[k] = (float)(heard(a, start + k) - baseline);
    fc_anytime_begin(&a->image.anytime, &a->touch, quiet, a->first.channel);
    a->baseline = baseline;
    for (uint32_t n = a->first.sample; before(n, sample); n++)
        fc_anytime_take(&a->touch, (float)(heard(a, n) - baseline));
    return true;
}

/* Return the newest moment within this many samples, 0 if there is none. */
static int32_t newest(int32_t samples)
{
    int32_t found = 0;
    for (size_t k = 0; k < sizeof moments / sizeof *moments && moments[k] <= samples; k++)
        found = moments[k];
    return found;
}

static uint32_t now(const fc_answers *a)
{
    return a->board.clock != NULL ? a->board.clock() : 0;
}

static void answer(fc_answers *a, uint32_t sample, int32_t moment)
{
    fc_running found = {0.0, 0.0, 0.0, 0.0, false};
    fc_touch *const t = &a->touch;
    const int32_t there = t->samples;
    const uint32_t then = now(a);
    t->samples = moment; /* ignore samples after the moment */
    const fc_status status = fc_anytime_answer(&a->image.anytime, t, &found);
    t->samples = there;
    const uint32_t took = now(a) - then;
    a->answered = moment;
    if (status == FC_ANSWER) {
        tell_estimate(a, &found, found.strange ? FC_STRANGE : 0, sample, moment, took);
    } else {
        a->still = true;
        tell_estimate(a, NULL, FC_REFUSES, sample, moment, took);
    }
}

/* Predict after this sample. fresh: the second contact became known with it. */
static void go_on(fc_answers *a, uint32_t sample, bool fresh, uint32_t second)
{
    const int32_t since = (int32_t)(sample - a->first.sample) + 1;
    /* Samples after the second contact must not be used. */
    const int32_t offset = (int32_t)(second - a->first.sample);
    const int32_t moment = newest(fresh && offset < since ? offset : since);
    const bool asked_late = fresh && a->passed[moment]; /* the final estimate was skipped */
    if (a->still || since < moments[0]) {
        if (asked_late)
            answer(a, sample, moment);
        a->still |= fresh;
        return;
    }
    if (!a->listening) {
        if (!begin_touch(a, sample)) {
            a->still = true;
            tell_estimate(a, NULL, FC_REFUSES, sample, 0, 0);
            return;
        }
        a->listening = true;
    }
    fc_anytime_take(&a->touch, (float)(heard(a, sample) - a->baseline));
    /* An estimate is late if the waiting samples make a later one due. */
    const int32_t waiting = (int32_t)fc_ring_used(&a->device->listeners);
    const bool late = !fresh && newest(since + waiting) > moment;
    const bool due = moment > a->answered || asked_late;
    if (due && !late) {
        answer(a, sample, moment);
    } else if (due && !a->passed[moment]) {
        a->passed[moment] = true;
        a->skipped++;
    }
    if (fresh || a->answered == FC_LONGEST)
        a->still = true;
}

static void closing(fc_answers *a, const fc_sample *s)
{
    fc_contact found[FC_FINGERS];
    double both[FC_FINGERS];
    int32_t n = 0;
    uint32_t second = 0;
    bool fresh = false;
    if (a->latched < FC_FINGERS) {
        for (int f = 0; f < FC_FINGERS; f++)
            both[f] = volts(s->value[f], FC_PIEZO_ZERO);
        n = fc_detector_take(&a->detector, both, found);
        a->latched += n;
    }
    for (int32_t k = 0; k < n && !a->over; k++) {
        if (!a->touched) {
            a->touched = true;
            a->listening = false;
            a->first = found[k];
            tell_contact(a, found + k, true);
        } else if (before(found[k].known, a->first.sample + FC_AFTER)) {
            fresh = !a->second;
            a->second = true;
            second = found[k].sample;
            tell_contact(a, found + k, false);
        }
    }
    if (!a->touched || a->over)
        return;
    go_on(a, s->number, fresh, second);
    a->over = !before(s->number + 1, a->first.sample + FC_AFTER);
    if (a->over)
        tell_late(a, false);
}

static void take(fc_answers *a, const fc_sample *s)
{
    double both[FC_FINGERS], loads[FC_LOADS];
    if (!a->begun || (s->streamed && !a->streamed))
        anew(a, s->number, false);
    else if (s->number != a->next)
        anew(a, s->number, true);
    a->begun = true;
    a->streamed = s->streamed;
    a->next = s->number + 1;
    for (int f = 0; f < FC_FINGERS; f++) {
        a->past[s->number % FC_PAST][f] = s->value[f];
        both[f] = volts(s->value[f], FC_PIEZO_ZERO);
    }
    if (a->open)
        closing(a, s);
    if (!a->image.gated)
        return;
    for (int k = 0; k < FC_LOADS; k++)
        loads[k] = volts(s->value[FC_FINGERS + k], 0.0);
    switch (fc_gate_take(&a->gate, both, loads)) {
    case FC_OPENS:
        begin(a, s->number + 1);
        break;
    case FC_SHUTS:
        a->open = false;
        break;
    default:
        break;
    }
}

void fc_answers_init(fc_answers *a, fc_device *device, const fc_keeper *keeper,
                     const fc_board *board)
{
    memset(a, 0, sizeof *a);
    a->device = device;
    a->board = *board;
    a->taker.own = a;
    a->taker.hear = fc_answers_hear;
    device->taker = &a->taker;
    fc_store_open(&a->store, keeper);
    (void)fc_answers_load(a);
}

void fc_answers_work(fc_answers *a)
{
    fc_ring *const ring = &a->device->listeners;
    while (fc_ring_used(ring) > 0) {
        const fc_sample s = *fc_ring_peek(ring, 0);
        fc_ring_drop(ring, 1);
        if (a->ready)
            take(a, &s);
    }
}
