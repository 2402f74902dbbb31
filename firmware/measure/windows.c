/* Program that predicts with one window model. It reads windows of floats and writes records.

   Define MODEL as the name of the function, HEADER as its file, and NUMBERS as the number of floats
   in a window. */
#include "machine.h"

#include <string.h>

#include HEADER

typedef struct {
    double value, low, high;
    int32_t chosen, status;
    uint32_t instructions, spare;
} record;

int main(int argc, char **argv)
{
    static float window[NUMBERS];
    if (!machine_begin(argc, argv))
        return 2;
    while (machine_read(window, sizeof window) == sizeof window) {
        fc_prediction p = {0.0, 0.0, 0.0, -1};
        record r;
        memset(&r, 0, sizeof r);
        const uint32_t before = machine_clock();
        r.status = MODEL(window, &p);
        r.instructions = machine_since(before);
        r.value = p.value;
        r.low = p.low;
        r.high = p.high;
        r.chosen = p.class_number;
        machine_write(&r, sizeof r);
    }
    machine_end();
    return 0;
}
