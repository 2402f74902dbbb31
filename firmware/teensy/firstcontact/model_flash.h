// Two places for a model in the flash that the program lies in.
//
// They are the last 512 KiB below Teensyduino's EEPROM, where LittleFS_Program would lie: a sketch
// uses one or the other. They outlive the power; an upload of a sketch may erase them.
#pragma once

#include "fc_store.h"

enum { MODEL_ROOM = FC_SLOT_BYTES, MODEL_BYTES = MODEL_ROOM - FC_SLOT_HEAD };

// NULL where the program itself reaches into them.
const fc_keeper *model_flash();
