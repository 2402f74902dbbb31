// Two slots for a model in the program's flash.
//
// They are the last 512 KiB below Teensyduino's EEPROM. LittleFS_Program uses the same place, so a
// sketch can use only one of them. The slots survive a power cut, but an upload of a sketch may
// erase them.
#pragma once

#include "fc_store.h"

enum { MODEL_ROOM = FC_SLOT_BYTES, MODEL_BYTES = MODEL_ROOM - FC_SLOT_HEAD };

// Return NULL if the program itself reaches into the slots.
const fc_memory *model_flash();
