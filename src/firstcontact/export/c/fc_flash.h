/* Where constants stay: Teensy's linker copies them into fast memory unless told otherwise. */
#ifndef FC_FLASH_H
#define FC_FLASH_H

#if defined(__IMXRT1062__)
#include <avr/pgmspace.h>
#define FC_FLASH PROGMEM
#else
#define FC_FLASH
#endif

#endif
