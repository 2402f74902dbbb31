#include "fc_steps.h"

#include <string.h>

#include "fc_assert.h"
#include "fc_math.h"

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
    for (int32_t k = 0; image->model.kind == FC_MODEL_SVM && k < image->model.sizes->moments; k++) {
        const size_t room = fc_svm_room(image->model.svm + k);
        most = room > most ? room : most;
    }
    return sizeof(double) * (fixed_room(image, stream) + (most + 1) / 2);
}

void fc_chain_init(fc_chain *c, const fc_image *image, const fc_stream *stream,
                   const fc_program *program, void *memory)
{
    FC_ASSERT(c != NULL && image != NULL && stream != NULL && program != NULL && memory != NULL);
    FC_ASSERT(stream->channels > 0 && stream->channels <= FC_CHANNELS_MOST);
    FC_ASSERT(stream->taxels >= 0 && stream->taxels <= FC_TAXELS_MOST);
    FC_ASSERT((uintptr_t)memory % sizeof(double) == 0);
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
        const double limit = FC_RUNNING * stream->floors[k];
        c->gate.limit[k] = limit * limit;
    }
}

void fc_chain_send(const fc_chain *c, const fc_event *event)
{
    if (c->program.emit != NULL)
        c->program.emit(c->program.context, event);
}

void fc_chain_emit(const fc_chain *c, int32_t kind, int32_t reason, int32_t flags, int64_t sample,
                   int64_t known)
{
    fc_event event = {0};
    event.kind = kind;
    event.reason = reason;
    event.flags = flags;
    event.channel = c->has_first ? c->channel : -1;
    event.sample = sample;
    event.known = known;
    fc_chain_send(c, &event);
}

static void begin_closing(fc_chain *c, int64_t first)
{
    c->is_open = true;
    c->is_over = false;
    c->start = first;
    c->resettle = first + c->image->timing->every;
    c->not_before = INT64_MIN;
    c->is_confirmed = c->stream.is_by_hand || c->stream.keeps_first_state;
    fc_contacts_forget(c);
    fc_detector_restart(&c->detector, first);
    fc_chain_emit(c, FC_CLOSING_BEGAN, 0, 0, first, first - 1);
}

static void end_closing(fc_chain *c, int64_t sample, int32_t reason)
{
    if (!c->is_over) {
        if (c->is_put_off)
            fc_estimates_compute(c, false);
        if (c->has_first && !c->is_settled && c->image->model.kind != FC_MODEL_NONE)
            fc_estimates_settle(c, sample - 1, reason);
        fc_chain_emit(c, FC_CLOSING_ENDED, reason, 0, sample, sample - 1);
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

void fc_chain_take(fc_chain *c, const double *vibration, const double *loads)
{
    FC_ASSERT(c != NULL && vibration != NULL);
    FC_ASSERT(c->has_begun);
    FC_ASSERT(loads != NULL || c->stream.taxels == 0 || !c->stream.has_floors);
    const bool is_finite = store(c, vibration);
    c->detector.effort = 0;
    if (c->is_open && !c->is_over) {
        const bool has_new_second = fc_contacts_detect(c, is_finite);
        if (c->image->model.kind != FC_MODEL_NONE)
            fc_estimates_compute(c, has_new_second);
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
    FC_ASSERT(!(hints->radius <= 0.0));
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
    if (!(c->is_confirmed && fc_contacts_all_latched(c)) && next - c->next < due)
        due = next - c->next;
    const bool is_estimating = c->has_first && !c->is_settled && m->kind != FC_MODEL_NONE;
    if (is_estimating && fc_estimates_final_from(c) - c->next < due
        && (c->failed || c->predicted == m->moment[m->sizes->moments - 1]))
        due = fc_estimates_final_from(c) - c->next;
    if (c->is_waiting && c->first + c->image->timing->confirmed - c->next < due)
        due = c->first + c->image->timing->confirmed - c->next;
    for (int32_t k = 0; is_estimating && k < m->sizes->moments; k++)
        if (m->moment[k] > c->predicted && c->first + m->moment[k] - c->next < due) {
            due = c->first + m->moment[k] - c->next;
            break;
        }
    return due < 1 ? 1 : (int32_t)due;
}
