#include "fc_chain.h"

#include <string.h>

#include "fc_assert.h"
#include "fc_math.h"

/* The motor runs if the RMS of a step exceeds the noise at rest by this factor. */
static const double RUNNING = 1.4;
/* A push is at least FAINT times as loud as the signal before it. A signal that is CLEAR times as
   loud is a contact, however fast it changes. ROUGHEST is the largest mean change of a push,
   relative to its mean deviation. */
static const double FAINT = 4.0, CLEAR = 20.0, ROUGHEST = 0.35;
/* No sample may take too long. So an estimate waits for the next sample if the detector computed more
   looks than this with the newest one, or if the motor's pitch was analysed. */
enum { EFFORT_MOST = 3 };

static size_t room_of_detector(const fc_detector_constants *d)
{
    return (size_t)(d->window > d->steady ? d->window : d->steady);
}

/* Return the size of the past and of the detector's room, in numbers of 8 bytes. */
static size_t fixed_room(const fc_image *image, const fc_stream *stream)
{
    const size_t channels = (size_t)stream->channels;
    const size_t past = (size_t)image->timing->capacity * channels;
    return past + room_of_detector(image->detector) * (channels + 1);
}

size_t fc_chain_bytes(const fc_image *image, const fc_stream *stream)
{
    FC_ASSERT(image != NULL && stream != NULL);
    FC_ASSERT(stream->channels > 0 && stream->channels <= FC_CHANNELS_MOST);
    size_t most = 0;
    for (int32_t k = 0; image->model.kind == FC_MODEL_SVM && k < image->model.moments; k++) {
        const size_t room = fc_svm_room(image->model.svm + k);
        most = room > most ? room : most;
    }
    return sizeof(double) * (fixed_room(image, stream) + (most + 1) / 2);
}

void fc_chain_init(fc_chain *c, const fc_image *image, const fc_stream *stream,
                   const fc_program *program, void *memory)
{
    FC_ASSERT(c != NULL && image != NULL && stream != NULL);
    FC_ASSERT(stream->channels > 0 && stream->channels <= FC_CHANNELS_MOST);
    const fc_timing *const t = image->timing;
    memset(c, 0, sizeof *c);
    c->image = image;
    c->stream = *stream;
    c->program = *program;
    c->hints.radius = NAN;
    c->past.volts = memory;
    c->past.capacity = t->capacity;
    c->past.channels = stream->channels;
    c->detector.constants = image->detector;
    c->detector.program = program->judge;
    c->detector.channels = stream->channels;
    c->detector.window = c->past.volts + (size_t)t->capacity * (size_t)stream->channels;
    c->detector.work
        = c->detector.window + room_of_detector(image->detector) * (size_t)stream->channels;
    c->svm_room = (float *)(void *)(c->past.volts + fixed_room(image, stream));
    c->gate.channels = stream->channels;
    c->gate.taxels = stream->taxels;
    c->gate.step = t->gate_step;
    c->gate.rearm = t->rearm;
    c->gate.is_by_hand = stream->is_by_hand;
    for (int32_t k = 0; k < stream->channels; k++) {
        const double limit = RUNNING * stream->floors[k];
        c->gate.limit[k] = limit * limit;
    }
}

static void emit(fc_chain *c, int32_t kind, int32_t reason, int32_t flags, int64_t sample,
                 int64_t known)
{
    fc_event event = {0};
    event.kind = kind;
    event.reason = reason;
    event.flags = flags;
    event.channel = c->has_first ? c->channel : -1;
    event.sample = sample;
    event.known = known;
    if (c->program.emit != NULL)
        c->program.emit(c->program.context, &event);
}

/* Forget the contacts of this closing and their estimates. */
static void forget_contacts(fc_chain *c)
{
    memset(c->is_latched, 0, sizeof c->is_latched);
    memset(c->is_predicted, 0, sizeof c->is_predicted);
    memset(c->is_skipped, 0, sizeof c->is_skipped);
    c->has_first = c->has_second = c->is_waiting = false;
    c->is_touch_ready = c->is_settled = c->varies = false;
    c->is_put_off = c->is_second_put_off = false;
    c->predicted = c->failed = 0;
}

static void begin_closing(fc_chain *c, int64_t first)
{
    c->is_open = true;
    c->is_over = false;
    c->start = first;
    c->resettle = first + c->image->timing->every;
    c->not_before = INT64_MIN;
    c->is_confirmed = c->stream.is_by_hand || c->stream.keeps_first_state;
    forget_contacts(c);
    fc_detector_restart(&c->detector, first);
    emit(c, FC_CLOSING_BEGAN, 0, 0, first, first - 1);
}

/* Return the index of a moment in the model. */
static int32_t moment_index(const fc_model *m, int32_t samples)
{
    int32_t k = 0;
    while (m->moment[k] != samples)
        k++;
    return k;
}

/* Return the newest moment within the first `samples` samples; 0 if there is none. */
static int32_t newest_moment(const fc_model *m, int64_t samples)
{
    int32_t newest = 0;
    for (int32_t k = 0; k < m->moments && m->moment[k] <= samples; k++)
        newest = m->moment[k];
    return newest;
}

static void emit_estimate(fc_chain *c, int32_t samples, int32_t flags, int64_t known)
{
    const fc_estimate *const estimate = c->estimates + moment_index(&c->image->model, samples);
    fc_event event = {0};
    event.kind = FC_ESTIMATED;
    event.flags = flags | (estimate->is_out_of_range ? FC_IS_OUT_OF_RANGE : 0);
    event.channel = c->channel;
    event.sample = c->first;
    event.known = known;
    event.samples = samples - c->image->model.lookahead;
    event.estimate = *estimate;
    if (c->program.emit != NULL)
        c->program.emit(c->program.context, &event);
}

/* Return the number of the sample from which on no second contact can lie within the newest estimate.
   Onsets are placed up to `search` samples back. */
static int64_t final_from(const fc_chain *c)
{
    const int32_t search = c->stream.channels > 1 ? c->detector.constants->search : 0;
    return c->predicted == 0 ? c->first : c->first + c->predicted + search;
}

/* Report the final estimate: the newest one that uses only samples before the second contact. */
static void settle(fc_chain *c, int64_t known, int32_t reason)
{
    const fc_model *const m = &c->image->model;
    const int64_t limit = c->has_second ? c->second - c->first : INT32_MAX;
    int32_t standing = 0;
    for (int32_t k = 0; k < m->moments && m->moment[k] <= limit; k++)
        if (c->is_predicted[k])
            standing = m->moment[k];
    c->is_settled = true;
    if (standing > 0)
        emit_estimate(c, standing, FC_IS_FINAL, known);
    else
        emit(c, FC_NOT_ESTIMATED, reason, FC_IS_FINAL, c->first, known);
}

static void estimate(fc_chain *c, bool has_new_second);

static void end_closing(fc_chain *c, int64_t sample, int32_t reason)
{
    if (!c->is_over) {
        if (c->is_put_off)
            estimate(c, false);
        if (c->has_first && !c->is_settled && c->image->model.kind != FC_MODEL_NONE)
            settle(c, sample - 1, reason);
        emit(c, FC_CLOSING_ENDED, reason, 0, sample, sample - 1);
    }
    c->is_over = true;
    const fc_hints none = {0.0, 0.0, c->hints.radius};
    c->hints = none; /* a speed belongs to one closing */
}

void fc_chain_restart(fc_chain *c, int64_t next, bool is_same_epoch)
{
    FC_ASSERT(c != NULL && c->image != NULL);
    FC_ASSERT(next >= 0);
    is_same_epoch = is_same_epoch && c->has_begun;
    if (c->is_open)
        end_closing(c, c->next, FC_LOST);
    c->is_open = c->has_smoothed = false;
    c->has_begun = true;
    c->next = c->past.begin = c->past.end = next;
    fc_gate_restart(&c->gate, next, is_same_epoch);
    if (!c->stream.has_floors && !is_same_epoch)
        begin_closing(c, next);
}

void fc_chain_finish(fc_chain *c)
{
    FC_ASSERT(c != NULL && c->image != NULL);
    if (c->is_open)
        end_closing(c, c->next, FC_STREAM_ENDED);
    c->is_open = c->has_begun = false;
}

/* Smooth a sample and store it. Return false if it is not finite. */
static bool store(fc_chain *c, const double *vibration)
{
    const int64_t mask = c->past.capacity - 1;
    bool is_finite = true;
    for (int32_t k = 0; k < c->stream.channels; k++)
        is_finite &= isfinite(vibration[k]) != 0;
    for (int32_t k = 0; k < c->stream.channels; k++) {
        const double alpha = c->stream.alpha[k];
        double *const y = c->smoothed + k;
        *y = c->has_smoothed && alpha < 1.0 ? alpha * vibration[k] + (1.0 - alpha) * *y
                                            : vibration[k];
        c->past.volts[k * c->past.capacity + (int32_t)(c->next & mask)] = is_finite ? *y : NAN;
    }
    c->has_smoothed = is_finite;
    c->past.end = c->next + 1;
    if (c->past.end - c->past.begin > c->past.capacity)
        c->past.begin = c->past.end - c->past.capacity;
    return is_finite;
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
    emit(c, FC_CONTACT_WITHDRAWN, 0, FC_IS_FIRST, c->first, due);
    c->not_before = c->first + 1;
    forget_contacts(c);
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
    if (c->program.emit != NULL)
        c->program.emit(c->program.context, &event);
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

static bool all_latched(const fc_chain *c)
{
    for (int32_t k = 0; k < c->stream.channels; k++)
        if (!c->is_latched[k])
            return false;
    return true;
}

/* Detect contacts with the newest sample. Return true if it shows a second contact. */
static bool detect(fc_chain *c, bool is_finite)
{
    const fc_timing *const t = c->image->timing;
    fc_detector *const d = &c->detector;
    const int64_t end = c->past.end;
    bool has_new_second = false;
    if (d->constants->kind == FC_DETECTOR_NONE
        || (c->program.window == NULL && c->is_confirmed && all_latched(c)))
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

/* Cut out the signal of the first contact. Return false and set the reason if it is unusable. */
static bool begin_touch(fc_chain *c, int32_t *reason)
{
    const fc_model *const m = &c->image->model;
    const int64_t start = c->first - m->before;
    double baseline = 0.0;
    *reason = FC_TOO_EARLY;
    if (start < c->past.begin)
        return false;
    *reason = FC_NO_SIGNAL;
    for (int64_t k = c->first - m->guard - m->baseline; k < c->first - m->guard; k++)
        baseline += fc_past_at(&c->past, c->channel, k);
    baseline /= m->baseline;
    c->baseline = baseline;
    for (int32_t k = 0; k < m->before; k++) {
        const double x = fc_past_at(&c->past, c->channel, start + k);
        if (!isfinite(x))
            return false;
        c->before[k] = (float)(x - baseline);
        c->varies |= x != fc_past_at(&c->past, c->channel, start);
    }
    fc_touch_begin(&c->touch, m, c->stream.finger[c->channel], c->before, &c->room);
    c->is_touch_ready = true;
    return true;
}

/* Add the new samples after the contact. Return false if one is not finite. */
static bool extend_touch(fc_chain *c)
{
    fc_touch *const t = &c->touch;
    while (c->first + t->samples < c->past.end && t->samples < FC_POINTS) {
        const double x = fc_past_at(&c->past, c->channel, c->first + t->samples);
        if (!isfinite(x))
            return false;
        c->varies |= x != fc_past_at(&c->past, c->channel, c->first - c->image->model.before);
        fc_touch_take(t, (float)(x - c->baseline));
    }
    return true;
}

/* Make the signal of the first contact ready. Return FC_DONE, or the reason why it is unusable. */
static int32_t prepare_touch(fc_chain *c)
{
    int32_t reason;
    if (c->image->model.kind != FC_MODEL_NETWORK)
        return FC_DONE;
    if (!c->is_touch_ready && !begin_touch(c, &reason))
        return reason;
    return extend_touch(c) && c->varies ? FC_DONE : FC_NO_SIGNAL;
}

/* Predict at a moment. Return FC_DONE, or the reason why there is no prediction. */
static int32_t predict(fc_chain *c, int32_t samples)
{
    const fc_model *const m = &c->image->model;
    const int32_t k = moment_index(m, samples);
    fc_estimate *const out = c->estimates + k;
    int32_t reason = FC_NOT_FINITE;
    if (m->kind == FC_MODEL_NETWORK) {
        fc_touch_hint(&c->touch, &c->hints);
        if (fc_touch_predict(&c->touch, samples, &c->room, out))
            reason = FC_DONE;
    } else if (m->kind == FC_MODEL_SVM) {
        double numbers[3] = {NAN, NAN, NAN};
        reason = fc_svm_predict(m->svm + k, &c->past, c->channel, c->first, c->svm_room, numbers);
        const fc_estimate estimate
            = {(float)numbers[0], (float)numbers[1], (float)numbers[2], NAN, NAN, false};
        *out = estimate;
    } else if (c->program.predict != NULL) {
        const int64_t oldest = c->first - m->before;
        const int64_t start = oldest > c->past.begin ? oldest : c->past.begin;
        const int32_t lead = (int32_t)(c->first - start);
        reason = c->program.predict(c->program.context, c, lead, samples, out);
    }
    if (reason != FC_DONE)
        return reason;
    c->is_predicted[k] = true;
    c->predicted = samples > c->predicted ? samples : c->predicted;
    emit_estimate(c, samples, 0, c->past.end - 1);
    return FC_DONE;
}

/* Return true if the estimate must wait for the next sample, because this one took long already. */
static bool is_effort_spent(fc_chain *c, bool was_put_off)
{
    int32_t ignored;
    bool is_long = c->detector.effort > EFFORT_MOST;
    if (c->image->model.kind == FC_MODEL_PROGRAM || was_put_off)
        return false;
    if (c->image->model.kind == FC_MODEL_NETWORK && c->past.end - 1 == c->decided)
        is_long |= begin_touch(c, &ignored) && c->touch.rig->has_pitch;
    return is_long;
}

/* Compute the estimate of a moment, unless a later one is due with samples that wait already. Return
   FC_DONE, or the reason why there is none. */
static int32_t compute_estimate(fc_chain *c, int32_t moment, bool has_new_second)
{
    const fc_model *const m = &c->image->model;
    const int32_t k = moment_index(m, moment);
    const int32_t waiting = c->program.waiting != NULL && !has_new_second
                                ? c->program.waiting(c->program.context) : 0;
    const int32_t reason = prepare_touch(c);
    if (reason != FC_DONE)
        return reason;
    if (has_new_second || newest_moment(m, c->past.end - c->first + waiting) <= moment)
        return predict(c, moment);
    if (!c->is_skipped[k])
        emit(c, FC_SKIPPED, 0, 0, c->first, c->past.end - 1);
    c->is_skipped[k] = true;
    return FC_DONE;
}

/* Compute the estimates that are due with the newest sample. */
static void estimate(fc_chain *c, bool has_new_second)
{
    const fc_model *const m = &c->image->model;
    const int64_t newest = c->past.end - 1;
    const bool was_put_off = c->is_put_off;
    int64_t limit = c->past.end - c->first;
    has_new_second |= c->is_second_put_off;
    c->is_put_off = c->is_second_put_off = false;
    if (!c->has_first || c->is_settled)
        return;
    if (c->has_second && c->second - c->first < limit)
        limit = c->second - c->first;
    const int32_t moment = newest_moment(m, limit);
    const int32_t k = moment > 0 ? moment_index(m, moment) : 0;
    const bool is_due = moment > 0 && !c->is_predicted[k] && !c->failed
                        && (has_new_second || moment > c->predicted);
    if (is_effort_spent(c, was_put_off) && is_due) {
        c->is_put_off = true;
        c->is_second_put_off = has_new_second;
        return;
    }
    if (is_due)
        c->failed = compute_estimate(c, moment, has_new_second);
    const bool is_last = c->failed != FC_DONE || c->predicted == m->moment[m->moments - 1];
    if (has_new_second || (is_last && newest + 1 >= final_from(c)))
        settle(c, newest, c->failed != FC_DONE ? c->failed : FC_SECOND_TOUCHED);
}

void fc_chain_take(fc_chain *c, const double *vibration, const double *loads)
{
    FC_ASSERT(c != NULL && vibration != NULL);
    FC_ASSERT(c->has_begun);
    const bool is_finite = store(c, vibration);
    c->detector.effort = 0;
    if (c->is_open && !c->is_over) {
        const bool has_new_second = detect(c, is_finite);
        if (c->image->model.kind != FC_MODEL_NONE)
            estimate(c, has_new_second);
        const int64_t end = c->first + c->image->timing->after;
        if (c->has_first && !c->is_waiting && c->next + 1 >= end && c->program.window == NULL)
            end_closing(c, end, FC_DONE);
    }
    if (c->stream.has_floors) {
        const fc_gate_turn turn = fc_gate_take(&c->gate, vibration, loads);
        if (turn == FC_GATE_SHUTS || turn == FC_GATE_SHUTS_AND_OPENS) {
            end_closing(c, c->next + 1, FC_RESTED);
            c->is_open = false;
        }
        if (turn == FC_GATE_OPENS || turn == FC_GATE_SHUTS_AND_OPENS)
            begin_closing(c, c->next + 1);
    }
    c->next++;
}

void fc_chain_hint(fc_chain *c, const fc_hints *hints)
{
    FC_ASSERT(c != NULL && hints != NULL);
    c->hints = *hints;
}

int32_t fc_chain_due(const fc_chain *c, int32_t most)
{
    FC_ASSERT(c != NULL && most >= 0);
    const fc_model *const m = &c->image->model;
    int64_t due = most;
    if (!c->is_open || c->is_over)
        return most;
    if (c->is_put_off)
        return 1;
    const int64_t next = c->detector.is_settled
                             ? c->detector.next : c->detector.settles + c->detector.constants->step;
    if (!(c->is_confirmed && all_latched(c)) && next - c->next < due)
        due = next - c->next;
    const bool is_estimating = c->has_first && !c->is_settled && m->kind != FC_MODEL_NONE;
    if (is_estimating && final_from(c) - c->next < due
        && (c->failed || c->predicted == m->moment[m->moments - 1]))
        due = final_from(c) - c->next;
    if (c->is_waiting && c->first + c->image->timing->confirmed - c->next < due)
        due = c->first + c->image->timing->confirmed - c->next;
    for (int32_t k = 0; is_estimating && k < m->moments; k++)
        if (m->moment[k] > c->predicted && c->first + m->moment[k] - c->next < due) {
            due = c->first + m->moment[k] - c->next;
            break;
        }
    return due < 1 ? 1 : (int32_t)due;
}
