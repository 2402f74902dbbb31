/* Contacts of a closing: detected, confirmed or withdrawn. */
#include "fc_steps.h"

#include <string.h>

#include "fc_math.h"

/* A push is at least FAINT times as loud as the signal before it. A signal that is CLEAR times as
   loud is a contact, however fast it changes. ROUGHEST is the largest mean change of a push,
   relative to its mean deviation. */
static const double FAINT = 4.0, CLEAR = 20.0, ROUGHEST = 0.35;

void fc_contacts_forget(fc_chain *c)
{
    memset(c->is_latched, 0, sizeof c->is_latched);
    memset(c->is_predicted, 0, sizeof c->is_predicted);
    memset(c->is_skipped, 0, sizeof c->is_skipped);
    c->has_first = c->has_second = c->is_waiting = false;
    c->is_touch_ready = c->is_settled = c->varies = false;
    c->is_put_off = c->is_second_put_off = false;
    c->predicted = c->failed = 0;
}

bool fc_contacts_all_latched(const fc_chain *c)
{
    for (int32_t k = 0; k < c->stream.channels; k++)
        if (!c->is_latched[k])
            return false;
    return true;
}

/* Return true if the signal after the first contact is that of a pushing finger. */
static bool is_push(const fc_chain *c)
{
    const fc_timing *const t = c->image->timing;
    const int64_t oldest = c->start > c->past.begin ? c->start : c->past.begin;
    const int64_t early = c->first - t->before > oldest ? c->first - t->before : oldest;
    const int32_t n = (int32_t)(c->first - t->guard - early);
    double mean = 0.0, squares = 0.0, change = 0.0, away = 0.0, newest = 0.0;
    bool varies = false;
    if (n < 1)
        return true;
    for (int32_t k = 0; k < n; k++) {
        mean += fc_past_at(&c->past, c->channel, early + k);
        varies |= fc_past_at(&c->past, c->channel, early + k)
                  != fc_past_at(&c->past, c->channel, early);
    }
    mean /= n;
    for (int32_t k = 0; k < n; k++) {
        const double x = fc_past_at(&c->past, c->channel, early + k) - mean;
        squares += x * x;
    }
    for (int32_t k = 0; k < t->confirmed; k++) {
        const double x = fc_past_at(&c->past, c->channel, c->first + k) - mean;
        away += fabs(x);
        if (k >= t->lag)
            change += fabs(x - (fc_past_at(&c->past, c->channel, c->first + k - t->lag) - mean));
        if (k >= t->confirmed - t->lasting)
            newest += x * x;
    }
    const double least = (change > ROUGHEST * away ? CLEAR : FAINT) * sqrt(squares / n);
    return !varies || !(sqrt(newest / t->lasting) <= least);
}

/* Confirm or withdraw the first contact once there are enough samples. */
static void confirm(fc_chain *c)
{
    const int64_t end = c->first + c->image->timing->confirmed - 1;
    const int64_t due = end > c->decided ? end : c->decided;
    if (!c->is_waiting || c->next < due)
        return;
    c->is_waiting = false;
    if (is_push(c)) {
        c->is_confirmed = true;
        return;
    }
    fc_chain_emit(c, FC_CONTACT_WITHDRAWN, 0, FC_IS_FIRST, c->first, due);
    c->not_before = c->first + 1;
    fc_contacts_forget(c);
}

/* Report a contact that the newest sample has shown. */
static void found(fc_chain *c, int32_t channel, int64_t sample)
{
    const bool is_first = !c->has_first;
    c->is_latched[channel] = true;
    fc_gate_touched(&c->gate, sample);
    if (is_first) {
        c->has_first = true;
        c->channel = channel;
        c->first = sample;
        c->decided = c->next;
        c->is_waiting = !c->is_confirmed;
    } else if (!c->has_second) {
        c->has_second = true;
        c->second = sample;
    }
    fc_event event = {0};
    event.kind = FC_CONTACT_FOUND;
    event.flags = is_first ? FC_IS_FIRST : 0;
    event.channel = channel;
    event.sample = sample;
    event.known = c->next;
    fc_chain_send(c, &event);
}

/* Evaluate the window that ends with the newest sample. Return true if it shows a second contact. */
static bool judge(fc_chain *c)
{
    const bool had_second = c->has_second;
    const bool is_traced = c->program.window != NULL;
    bool is_skipped[FC_CHANNELS_MOST];
    int64_t onsets[FC_CHANNELS_MOST];
    for (int32_t k = 0; k < c->stream.channels; k++)
        is_skipped[k] = !is_traced && c->is_confirmed && c->is_latched[k];
    fc_detector_judge(&c->detector, &c->past, is_skipped, onsets);
    if (is_traced)
        c->program.window(c->program.context, c->past.end, onsets);
    for (;;) { /* the earliest onset first */
        int32_t best = -1;
        for (int32_t k = 0; k < c->stream.channels; k++)
            if (onsets[k] >= c->not_before && onsets[k] >= 0 && !c->is_latched[k]
                && (best < 0 || onsets[k] < onsets[best]))
                best = k;
        if (best < 0)
            return c->has_second && !had_second;
        found(c, best, onsets[best]);
    }
}

bool fc_contacts_detect(fc_chain *c, bool is_finite)
{
    const fc_timing *const t = c->image->timing;
    fc_detector *const d = &c->detector;
    const int64_t end = c->past.end;
    bool has_new_second = false;
    if (d->constants->kind == FC_DETECTOR_NONE
        || (c->program.window == NULL && c->is_confirmed && fc_contacts_all_latched(c)))
        return false;
    confirm(c);
    if (!is_finite) {
        fc_detector_restart(d, end);
    } else if (!d->is_settled && end == d->settles) {
        fc_detector_settle(d, &c->past, end);
    } else if (d->is_settled && end == d->next) {
        has_new_second = judge(c);
    }
    confirm(c);
    if (end == c->resettle) {
        c->resettle += t->every;
        const int64_t quiet_end = end - t->age;
        if (!c->is_confirmed && d->is_settled && quiet_end - d->constants->steady >= c->start
            && quiet_end - d->constants->steady >= c->past.begin)
            fc_detector_resettle(d, &c->past, quiet_end);
    }
    return has_new_second;
}
