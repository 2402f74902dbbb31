/* Store for models in a file, in place of a board's flash. */
#ifndef MODELS_H
#define MODELS_H

#include "fc_store.h"

enum { MODEL_ROOM = FC_SLOT_BYTES };

/* Open or create the file. Return -1 and set errno on failure. Written bytes survive the program,
   however it ends.
   memory  out
   path    in */
int models_open(fc_memory *memory, const char *path);

#endif
