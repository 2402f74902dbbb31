/* Emulated Cortex-M7: files by semihosting, instruction counts by its timer. */
#include "machine.h"

#include <string.h>

#include "board.h"

/* With qemu -icount shift=10 an instruction lasts 1024 ns: 25.6 ticks of 25 MHz. */
#define TIMER0_CONTROL (*(volatile uint32_t *)0x40000000u)
#define TIMER0_VALUE (*(volatile uint32_t *)0x40000004u)
#define TIMER0_RELOAD (*(volatile uint32_t *)0x40000008u)

static int32_t from, to;

int machine_begin(int argc, char **argv)
{
    static char text[1024];
    (void)argc;
    (void)argv;
    host_arguments(text, sizeof text);
    char *const second = strchr(text, ' ');
    if (second == NULL)
        return 0;
    *second = '\0';
    from = host_open(text, false);
    to = host_open(second + 1, true);
    TIMER0_RELOAD = UINT32_MAX;
    TIMER0_VALUE = UINT32_MAX;
    TIMER0_CONTROL = 1;
    return from >= 0 && to >= 0;
}

size_t machine_read(void *into, size_t bytes)
{
    return host_take(from, into, bytes);
}

void machine_write(const void *what, size_t bytes)
{
    host_put(to, what, bytes);
}

void machine_end(void)
{
    host_close(from);
    host_close(to);
}

uint32_t machine_clock(void)
{
    return TIMER0_VALUE;
}

uint32_t machine_since(uint32_t then)
{
    return (uint32_t)((uint64_t)(uint32_t)(then - TIMER0_VALUE) * 10 / 256);
}

void board_timer_interrupt(void)
{
}
