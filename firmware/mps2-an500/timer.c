/* CMSDK timer 0: counts down at 25 MHz and starts again at its reload value. */
#include "board.h"

typedef struct {
    volatile uint32_t control, value, reload, interrupt;
} timer;

#define TIMER0 ((timer *)0x40000000u)
#define NVIC_ENABLE (*(volatile uint32_t *)0xe000e100u)

enum { ENABLED = 1, INTERRUPTS = 8 };

void timer_start(uint32_t ticks)
{
    TIMER0->reload = ticks - 1;
    TIMER0->value = ticks - 1;
    NVIC_ENABLE = 1u << BOARD_TIMER_IRQ;
    TIMER0->control = ENABLED | INTERRUPTS;
}

void timer_period(uint32_t ticks)
{
    TIMER0->interrupt = 1; /* writing 1 clears it */
    TIMER0->reload = ticks - 1;
}

void timer_stop(void)
{
    TIMER0->control = 0;
    TIMER0->interrupt = 1;
}
