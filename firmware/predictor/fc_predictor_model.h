/* Active model: its transfer over the wire, storage and loading. */
#ifndef FC_PREDICTOR_MODEL_H
#define FC_PREDICTOR_MODEL_H

#include "fc_predictor.h"

/* Write the channels of the device. Return NULL, or the reason why the device cannot run the
   image. */
const char *fc_predictor_fits(const fc_image *image, fc_stream *stream);

/* Start the chain with a->image, which must fit this device. */
void fc_predictor_start(fc_predictor *a);

/* Activate the newest stored model, or the previous one if the newest is unusable. Return NULL, or
   the fault of the newest. */
const char *fc_predictor_load(fc_predictor *a);

/* Functions of fc_receiver. `own` is an fc_predictor. */
uint8_t fc_predictor_receive(void *own, const fc_frame *frame, uint32_t *next, const char **why);
void fc_predictor_take_hint(void *own, const fc_frame *frame);

#endif
