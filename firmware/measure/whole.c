/* One image with detector, window model and any-time model. Its size is what a hand needs in all.

   Build it with MODEL, the window model's function, and HEADER, its file. Input: closings. Output:
   predictions. */
#include "machine.h"

#include <string.h>

#include "fc_anytime_model.h"
#include "fc_detector.h"

#include HEADER

enum { KEPT = FC_BEFORE + FC_LONGEST };

static fc_detector detector;
static fc_touch touch;
static float past[FC_CHANNELS][KEPT], window[NUMBERS];

int main(int argc, char **argv)
{
    uint32_t n;
    if (!machine_begin(argc, argv))
        return 2;
    while (machine_read(&n, sizeof n) == sizeof n) {
        fc_detector_start(&detector, 0);
        for (uint32_t i = 0; i < n; i++) {
            double volts[FC_CHANNELS];
            fc_contact contacts[FC_CHANNELS];
            (void)machine_read(volts, sizeof volts);
            for (int32_t c = 0; c < FC_CHANNELS; c++) {
                memmove(past[c], past[c] + 1, (KEPT - 1) * sizeof **past);
                past[c][KEPT - 1] = (float)volts[c];
            }
            const int32_t found = fc_detector_take(&detector, volts, contacts);
            for (int32_t k = 0; k < found; k++) {
                const float *const heard = past[contacts[k].channel];
                fc_running running = {0.0, 0.0, 0.0, 0.0, false};
                fc_estimate estimate = {0.0, 0.0, 0.0, -1};
                fc_anytime_begin(&fc_anytime_model, &touch, heard, contacts[k].channel);
                for (int32_t s = 0; s < FC_LONGEST; s++)
                    fc_anytime_take(&touch, heard[FC_BEFORE + s]);
                (void)fc_anytime_answer(&fc_anytime_model, &touch, &running);
                memcpy(window, heard + KEPT - NUMBERS, sizeof window);
                (void)MODEL(window, &estimate);
                machine_write(&running.value, sizeof running.value);
                machine_write(&estimate.value, sizeof estimate.value);
            }
        }
    }
    machine_end();
    return 0;
}
