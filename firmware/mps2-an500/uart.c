/* CMSDK UART 0. */
#include "board.h"

typedef struct {
    volatile uint32_t data, state, control, interrupt, divider;
} uart;

#define UART0 ((uart *)0x40004000u)

enum { TX_FULL = 1, RX_FULL = 2, TX_ON = 1, RX_ON = 2, DIVIDER_LEAST = 16 };

void uart_init(void)
{
    UART0->divider = DIVIDER_LEAST;
    UART0->control = TX_ON | RX_ON;
}

bool uart_put(uint8_t byte)
{
    if (UART0->state & TX_FULL)
        return false;
    UART0->data = byte;
    return true;
}

bool uart_get(uint8_t *byte)
{
    if (!(UART0->state & RX_FULL))
        return false;
    *byte = (uint8_t)UART0->data;
    return true;
}
