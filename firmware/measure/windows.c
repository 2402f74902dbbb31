/* Predict with one window model. Input: records of floats. Output: records of predictions.

   Build it with MODEL, the function's name, HEADER, its file, and NUMBERS, the length of a window. */
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
        fc_answer answer = {0.0, 0.0, 0.0, -1};
        record r;
        memset(&r, 0, sizeof r);
        const uint32_t before = machine_clock();
        r.status = MODEL(window, &answer);
        r.instructions = machine_since(before);
        r.value = answer.value;
        r.low = answer.low;
        r.high = answer.high;
        r.chosen = answer.chosen;
        machine_write(&r, sizeof r);
    }
    machine_end();
    return 0;
}
