/* Attribute of constants that stay in flash. Teensy's linker copies all others to fast memory. */
#ifndef FC_FLASH_H
#define FC_FLASH_H

#if defined(__IMXRT1062__)
#include <avr/pgmspace.h>
#define FC_FLASH PROGMEM
#else
#define FC_FLASH
#endif

#endif
