// Sections of Teensyduino's linker script; see ../Arduino.h.
#pragma once

#define PROGMEM __attribute__((section(".progmem")))
#define DMAMEM __attribute__((section(".dmabuffers"), used))
