// Functions of the Teensy's EEPROM that the sketch uses; see ../Arduino.h.
#pragma once

#include <stdint.h>

extern "C" {
uint32_t eeprom_read_dword(const uint32_t *place);
void eeprom_write_dword(uint32_t *place, uint32_t value);
}
