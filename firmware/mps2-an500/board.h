/* Peripherals of the emulated board. */
#ifndef BOARD_H
#define BOARD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { BOARD_CLOCK_HZ = 25000000, BOARD_TIMER_IRQ = 8 };

void uart_init(void);

/* Send a byte. Return false if there is no room.
   byte  in */
bool uart_put(uint8_t byte);

/* Receive a byte. Return false if there is none.
   byte  out */
bool uart_get(uint8_t *byte);

/* Start interrupts. Each interrupt sets the period after the one that then runs.
   ticks  in */
void timer_start(uint32_t ticks);
void timer_period(uint32_t ticks);
void timer_stop(void);
void board_timer_interrupt(void); /* defined by the program */

/* Return the time of the instructions, ns at 600 MHz and 1.5 cycles each. In the emulator each lasts
   1024 ns. */
void counter_start(void);
uint32_t counter_ns(void);

/* Semihosting: services of the emulator. host_read and host_take return the number of bytes read,
   host_open a file, or a number below 0 on an error.
   text     out, (room)
   room     in, bytes
   path     in
   to       out, (room) or (bytes)
   writing  in
   file     in, of host_open
   bytes    in
   from     in, (bytes) */
void host_arguments(char *text, size_t room);
size_t host_read(const char *path, uint8_t *to, size_t room);
int32_t host_open(const char *path, bool writing);
size_t host_take(int32_t file, void *to, size_t bytes);
void host_put(int32_t file, const void *from, size_t bytes);
void host_close(int32_t file);
uint32_t host_seconds(void);

/* End the program.
   code  in */
void board_exit(int code);

#endif
