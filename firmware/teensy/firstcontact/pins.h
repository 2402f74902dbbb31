// Pins of the Teensy 4.0, as docs/reference/fingertip.md wires them. Index finger first.
#pragma once

#include <stdint.h>

static const uint8_t PIEZO_PIN[2] = {A0, A1};                      // 14, 15
static const uint8_t COLUMN_PIN[2][2] = {{A2, A3}, {A4, A5}};      // 16, 17; 18, 19
static const uint8_t ROW_PIN[2][3] = {{2, 3, 4}, {5, 6, 7}};
static const uint8_t STRIP_PIN[2] = {8, 9};
