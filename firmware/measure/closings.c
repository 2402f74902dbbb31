/* Runs a detector over closings: for each how many samples, then the samples of all channels in;
   its contacts out, and the instructions of its dearest 3 ms. */
#include "machine.h"

#include <string.h>

#include "fc_detector.h"

enum { STRETCH = 15 }; /* samples in 3 ms at 4936 Hz, rounded up */

typedef struct {
    int32_t found;
    struct {
        int32_t channel;
        uint32_t sample, known;
    } contact[FC_CHANNELS];
    uint32_t dearest, whole, settling;
} record;

int main(int argc, char **argv)
{
    static fc_detector detector;
    uint32_t n;
    if (!machine_begin(argc, argv))
        return 2;
    while (machine_read(&n, sizeof n) == sizeof n) {
        uint32_t last[STRETCH] = {0}, sum = 0;
        record r;
        memset(&r, 0, sizeof r);
        fc_detector_start(&detector, 0);
        for (uint32_t i = 0; i < n; i++) {
            double volts[FC_CHANNELS];
            fc_contact contacts[FC_CHANNELS];
            (void)machine_read(volts, sizeof volts);
            const uint32_t before = machine_clock();
            const int32_t found = fc_detector_take(&detector, volts, contacts);
            const uint32_t took = machine_since(before);
            for (int32_t k = 0; k < found; k++, r.found++) {
                r.contact[r.found].channel = contacts[k].channel;
                r.contact[r.found].sample = contacts[k].sample;
                r.contact[r.found].known = contacts[k].known;
            }
            if (i + 1 == FC_STEADY) { /* once in a closing, and long before a contact */
                r.settling = took;
                continue;
            }
            r.whole += took;
            sum += took - last[i % STRETCH];
            last[i % STRETCH] = took;
            r.dearest = sum > r.dearest ? sum : r.dearest;
        }
        machine_write(&r, sizeof r);
    }
    machine_end();
    return 0;
}
