/* Estimates of the first contact of a closing. */
#include "fc_steps.h"

#include "fc_math.h"

/* No sample may take too long. So an estimate waits for the next sample if the detector computed more
   looks than this with the newest one, or if the motor's pitch was analysed. */
enum { EFFORT_MOST = 3 };

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
    for (int32_t k = 0; k < m->sizes->moments && m->moment[k] <= samples; k++)
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
    event.samples = samples - c->image->model.sizes->lookahead;
    event.estimate = *estimate;
    fc_chain_send(c, &event);
}

int64_t fc_estimates_final_from(const fc_chain *c)
{
    const int32_t search = c->stream.channels > 1 ? c->detector.constants->search : 0;
    return c->predicted == 0 ? c->first : c->first + c->predicted + search;
}

void fc_estimates_settle(fc_chain *c, int64_t known, int32_t reason)
{
    const fc_model *const m = &c->image->model;
    const int64_t limit = c->has_second ? c->second - c->first : INT32_MAX;
    int32_t standing = 0;
    for (int32_t k = 0; k < m->sizes->moments && m->moment[k] <= limit; k++)
        if (c->is_predicted[k])
            standing = m->moment[k];
    c->is_settled = true;
    if (standing > 0)
        emit_estimate(c, standing, FC_IS_FINAL, known);
    else
        fc_chain_emit(c, FC_NOT_ESTIMATED, reason, FC_IS_FINAL, c->first, known);
}

/* Cut out the signal of the first contact. Return false and set the reason if it is unusable. */
static bool begin_touch(fc_chain *c, int32_t *reason)
{
    const fc_model *const m = &c->image->model;
    const int64_t start = c->first - m->sizes->before;
    double baseline = 0.0;
    *reason = FC_TOO_EARLY;
    if (start < c->past.begin)
        return false;
    *reason = FC_NO_SIGNAL;
    for (int64_t k = c->first - m->sizes->guard - m->sizes->baseline; k < c->first - m->sizes->guard; k++)
        baseline += fc_past_at(&c->past, c->channel, k);
    baseline /= m->sizes->baseline;
    c->baseline = baseline;
    for (int32_t k = 0; k < m->sizes->before; k++) {
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
        c->varies |= x != fc_past_at(&c->past, c->channel, c->first - c->image->model.sizes->before);
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
        fc_svm_estimate e = {NAN, NAN, NAN};
        reason = fc_svm_predict(m->svm + k, &c->past, c->channel, c->first, c->svm_room, &e);
        const fc_estimate estimate = {(float)e.value, (float)e.low, (float)e.high, NAN, NAN, false};
        *out = estimate;
    } else if (c->program.predict != NULL) {
        const int64_t oldest = c->first - m->sizes->before;
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
        is_long |= begin_touch(c, &ignored) && c->touch.rig->counts->has_pitch;
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
        fc_chain_emit(c, FC_SKIPPED, 0, 0, c->first, c->past.end - 1);
    c->is_skipped[k] = true;
    return FC_DONE;
}

void fc_estimates_compute(fc_chain *c, bool has_new_second)
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
    const bool is_last = c->failed != FC_DONE || c->predicted == m->moment[m->sizes->moments - 1];
    if (has_new_second || (is_last && newest + 1 >= fc_estimates_final_from(c)))
        fc_estimates_settle(c, newest, c->failed != FC_DONE ? c->failed : FC_SECOND_TOUCHED);
}
