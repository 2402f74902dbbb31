/* Active model: its transfer over the wire, storage and loading. */
#ifndef FC_ANSWERS_MODEL_H
#define FC_ANSWERS_MODEL_H

#include "fc_answers.h"

/* Activate the newest stored model, or the previous one if the newest cannot be used. Return NULL,
   or the fault of the newest. */
const char *fc_answers_load(fc_answers *a);

/* Handle a frame about models: see fc_model_taker. own is an fc_answers. */
uint8_t fc_answers_hear(void *own, const fc_frame *frame, uint32_t *next, const char **why);

#endif
