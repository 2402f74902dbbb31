/* Models in a file: what flash is to a board. */
#ifndef MODELS_H
#define MODELS_H

#include "fc_store.h"

enum { MODEL_ROOM = FC_SLOT_BYTES };

/* Opens the file, or makes it; returns -1, errno set. What is written outlives the program,
   however that ends. */
int models_open(fc_keeper *keeper, const char *path);

#endif
