/* Active model: its transfer over the wire, storage and loading. */
#ifndef FC_ANSWERS_MODEL_H
#define FC_ANSWERS_MODEL_H

#include "fc_answers.h"

/* Write the channels of the device. Return NULL, or why this device cannot run the image. */
const char *fc_answers_fits(const fc_image *image, fc_stream *stream);

/* Start the chain with a->image, which fits. */
void fc_answers_start(fc_answers *a);

/* Activate the newest stored model, or the previous one if the newest cannot be used. Return NULL,
   or the fault of the newest. */
const char *fc_answers_load(fc_answers *a);

/* Handle a frame about models, or a hint: see fc_taker. own is an fc_answers. */
uint8_t fc_answers_hear(void *own, const fc_frame *frame, uint32_t *next, const char **why);
void fc_answers_take_hint(void *own, const fc_frame *frame);

#endif
