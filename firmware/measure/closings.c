/* Run a detector over closings. Input, for each closing: the number of samples, then the samples of
   all channels. Output: its contacts, and the instructions of the costliest 3 ms with and without
   the samples that compute the steady state, of the costliest of these samples, and of all. */
#include "machine.h"

#include <string.h>

#include "fc_detector.h"

/* Samples in 3 ms at 4936 Hz, rounded up, and samples that compute the steady state, from the one
   that completes it. */
enum { STRETCH = 15, TAKEN_IN = 3 };

typedef struct {
    uint32_t last[STRETCH], sum, dearest;
} stretch;

static void count(stretch *s, uint32_t i, uint32_t took)
{
    s->sum += took - s->last[i % STRETCH];
    s->last[i % STRETCH] = took;
    s->dearest = s->sum > s->dearest ? s->sum : s->dearest;
}

typedef struct {
    int32_t found;
    struct {
        int32_t channel;
        uint32_t sample, known;
    } contact[FC_CHANNELS];
    uint32_t dearest, whole, steady, around;
} record;

int main(int argc, char **argv)
{
    static fc_detector detector;
    uint32_t n;
    if (!machine_begin(argc, argv))
        return 2;
    while (machine_read(&n, sizeof n) == sizeof n) {
        stretch all = {{0}, 0, 0}, others = {{0}, 0, 0};
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
            r.whole += took;
            count(&all, i, took);
            if (i + 1 - FC_STEADY < TAKEN_IN) /* once in a closing */
                r.steady = took > r.steady ? took : r.steady;
            else
                count(&others, i, took);
        }
        r.around = all.dearest;
        r.dearest = others.dearest;
        machine_write(&r, sizeof r);
    }
    machine_end();
    return 0;
}
