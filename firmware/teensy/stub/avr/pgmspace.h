// Where Teensyduino's linker script puts things; see ../Arduino.h.
#pragma once

#define PROGMEM __attribute__((section(".progmem")))
#define DMAMEM __attribute__((section(".dmabuffers"), used))
