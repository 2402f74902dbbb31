/* The model that answers: taken over the wire, kept, and read from where it is kept. */
#ifndef FC_ANSWERS_MODEL_H
#define FC_ANSWERS_MODEL_H

#include "fc_answers.h"

/* Has the newest model that is kept answer, or the one before where that cannot be used. Returns
   NULL, or what is wrong with the newest. */
const char *fc_answers_load(fc_answers *a);

/* Frames about models: see fc_model_taker, whose own is an fc_answers. */
uint8_t fc_answers_hear(void *own, const fc_frame *frame, uint32_t *next, const char **why);

#endif
