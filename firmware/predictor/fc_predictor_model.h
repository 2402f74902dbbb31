/* Active model: its transfer over the wire, storage and loading.

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". */
#ifndef FC_PREDICTOR_MODEL_H
#define FC_PREDICTOR_MODEL_H

#include "fc_predictor.h"

/* Return NULL, or the reason why the device cannot run an image.
   image   in
   stream  out, channels of the device */
const char *fc_predictor_fits(const fc_image *image, fc_stream *stream);

/* Start the chain with a->image, which must fit this device.
   a  in, out */
void fc_predictor_start(fc_predictor *a);

/* Activate the newest stored model, or the previous one if the newest is unusable. Return NULL, or
   the fault of the newest.
   a  in, out */
const char *fc_predictor_load(fc_predictor *a);

/* Functions of fc_receiver.
   own    in, out: an fc_predictor
   frame  in
   next   out, bytes received so far
   why    out, reason of a refusal */
uint8_t fc_predictor_receive(void *own, const fc_frame *frame, uint32_t *next, const char **why);
void fc_predictor_take_hint(void *own, const fc_frame *frame);

#endif
