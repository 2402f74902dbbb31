/* Predict with the any-time model. Input, for each contact: finger, number of valid samples, signal.
   Output: predictions after the given numbers of samples. */
#include "machine.h"

#include <string.h>

#include "fc_anytime_model.h"

typedef struct {
    double value, spread, low, high;
    int32_t samples, status, strange;
    uint32_t instructions;
} record;

int main(int argc, char **argv)
{
    static float signal[FC_BEFORE + FC_LONGEST];
    static fc_touch touch;
    int32_t count, moments[64], told[2];
    if (!machine_begin(argc, argv))
        return 2;
    (void)machine_read(&count, sizeof count);
    (void)machine_read(moments, (size_t)count * sizeof *moments);
    while (machine_read(told, sizeof told) == sizeof told) {
        int32_t next = 0;
        (void)machine_read(signal, sizeof signal);
        uint32_t before = machine_clock();
        fc_anytime_begin(&fc_anytime_model, &touch, signal, told[0]);
        for (int32_t k = 0; k < told[1] && next < count; k++) {
            fc_anytime_take(&touch, signal[FC_BEFORE + k]);
            if (k + 1 != moments[next])
                continue;
            fc_running answer = {0.0, 0.0, 0.0, 0.0, false};
            record r;
            memset(&r, 0, sizeof r);
            r.status = fc_anytime_answer(&fc_anytime_model, &touch, &answer);
            r.instructions = machine_since(before); /* since the previous prediction */
            r.value = answer.value;
            r.spread = answer.spread;
            r.low = answer.low;
            r.high = answer.high;
            r.strange = answer.strange;
            r.samples = moments[next++];
            machine_write(&r, sizeof r);
            before = machine_clock();
        }
    }
    machine_end();
    return 0;
}
