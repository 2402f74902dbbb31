/* Peripherals of the emulated board. */
#ifndef BOARD_H
#define BOARD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { BOARD_CLOCK_HZ = 25000000, BOARD_TIMER_IRQ = 8 };

void uart_init(void);
bool uart_put(uint8_t byte); /* false if it is full */
bool uart_get(uint8_t *byte);

/* Start interrupts. Each interrupt sets the period after the one that then runs. */
void timer_start(uint32_t ticks);
void timer_period(uint32_t ticks);
void timer_stop(void);
void board_timer_interrupt(void); /* defined by the program */

/* Return the time of the instructions, ns at 600 MHz and 1.5 cycles each. In the emulator each lasts
   1024 ns. */
void counter_start(void);
uint32_t counter_ns(void);

/* Semihosting: services of the emulator. */
void host_arguments(char *text, size_t room);
size_t host_read(const char *path, uint8_t *to, size_t room); /* bytes read, 0 on an error */
int32_t host_open(const char *path, bool writing); /* below 0 on an error */
size_t host_take(int32_t file, void *to, size_t bytes); /* bytes read */
void host_put(int32_t file, const void *from, size_t bytes);
void host_close(int32_t file);
uint32_t host_seconds(void);
void board_exit(int code);

#endif
