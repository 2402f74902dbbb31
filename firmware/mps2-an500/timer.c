/* CMSDK timers: they count down at 25 MHz and restart at their reload value. */
#include "board.h"

typedef struct {
    volatile uint32_t control, value, reload, interrupt;
} timer;

#define TIMER0 ((timer *)0x40000000u)
#define TIMER1 ((timer *)0x40001000u)
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

static uint64_t ticks;
static uint32_t before;

void counter_start(void)
{
    TIMER1->reload = UINT32_MAX;
    TIMER1->value = before = UINT32_MAX;
    TIMER1->control = ENABLED;
}

/* 1024 ns are 25.6 ticks and represent 2.5 ns. */
uint32_t counter_ns(void)
{
    const uint32_t now = TIMER1->value;
    ticks += (uint32_t)(before - now);
    before = now;
    return (uint32_t)(ticks * 25 / 256);
}
