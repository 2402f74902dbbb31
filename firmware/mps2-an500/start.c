/* Start-up code: vectors, FPU, memory. */
#include <stdint.h>

#include "board.h"

extern uint32_t data_begin[], data_end[], bss_begin[], bss_end[], stack_top[];
extern const uint32_t data_from[];
int main(void);
void reset(void);

/* Coprocessor access control. The FPU is number 10 and 11, and off after reset. */
#define CPACR (*(volatile uint32_t *)0xe000ed88u)

void reset(void)
{
    const uint32_t *from = data_from;
    CPACR |= 0xfu << 20;
    __asm__ volatile("dsb\n isb" ::: "memory");
    for (uint32_t *to = data_begin; to < data_end; to++)
        *to = *from++;
    for (uint32_t *to = bss_begin; to < bss_end; to++)
        *to = 0;
    board_exit(main());
}

static void fault(void)
{
    board_exit(1);
}

typedef void (*vector)(void);

/* The core's 16 vectors, then the board's interrupts. */
__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack;
    vector core[15];
    vector board[32];
} vectors = {
    .stack = stack_top,
    .core = {reset, fault, fault, fault, fault, fault, fault, fault,
             fault, fault, fault, fault, fault, fault, fault},
    .board = {[BOARD_TIMER_IRQ] = board_timer_interrupt},
};
