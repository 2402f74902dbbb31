/* Read intact and damaged model images, and predict with those that are not refused. Input: the
   length of an intact image and its bytes; then, for each image to try, its length and its number
   of patches; for each patch its offset, its length and its bytes. Output: one record per image. */
#include "machine.h"

#include <string.h>

#include "fc_image.h"

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/asan_interface.h>
#else
#define ASAN_POISON_MEMORY_REGION(at, n) ((void)(at), (void)(n))
#define ASAN_UNPOISON_MEMORY_REGION(at, n) ((void)(at), (void)(n))
#endif

enum { ROOM = 1 << 19, SAMPLES = 400 };

typedef struct {
    char why[72];                /* reason for the refusal, "" if the image was accepted */
    int32_t contacts, status[4]; /* contacts of the detector; status at each moment */
    int32_t spare;
    double value[4], low[4], high[4];
} record;

const fc_loudness *fc_judge_loaded;

static uint64_t sound[ROOM / 8], tried[ROOM / 8];
static fc_image image;

/* Test signal: noise, then a swing. */
static double heard(uint32_t n)
{
    static const double swing[] = {0.0, 0.1, 0.3, 0.5, 0.4, 0.1, -0.2, -0.3, -0.2, 0.0};
    const double noise = 1e-3 * (double)((n * 2654435761u >> 20) & 15u);
    return n >= 300 ? noise + swing[(n - 300) % 10] * 80.0 / (double)(n - 220) : noise;
}

static void answer(record *r)
{
    static const int32_t moments[4] = {10, 25, 49, 74};
    static fc_detector detector;
    static fc_touch touch;
    float before[FC_BEFORE];
    fc_contact found[FC_CHANNELS];
    double volts[FC_CHANNELS];
    fc_judge_loaded = &image.judge;
    fc_detector_start(&detector, 0);
    for (uint32_t n = 0; n < SAMPLES; n++) {
        for (uint32_t c = 0; c < FC_CHANNELS; c++)
            volts[c] = heard(n + c);
        r->contacts += fc_detector_take(&detector, volts, found);
    }
    for (uint32_t k = 0; k < FC_BEFORE; k++)
        before[k] = (float)heard(300 - FC_BEFORE + k);
    for (int m = 0; m < 4; m++) {
        fc_running a = {0.0, 0.0, 0.0, 0.0, false};
        fc_anytime_begin(&image.anytime, &touch, before, m % 2);
        for (int32_t k = 0; k < moments[m]; k++)
            fc_anytime_take(&touch, (float)heard(300 + (uint32_t)k));
        r->status[m] = fc_anytime_answer(&image.anytime, &touch, &a);
        r->value[m] = a.value;
        r->low[m] = a.low;
        r->high[m] = a.high;
    }
    for (uint32_t k = 0; k < image.text_bytes; k++)
        r->spare += image.text[k] > '~'; /* never */
}

/* Read the next image to try and return its length, 0 at the end. */
static uint32_t next(uint32_t whole)
{
    uint32_t told[2], patch[2];
    uint8_t *const bytes = (uint8_t *)tried;
    ASAN_UNPOISON_MEMORY_REGION(tried, sizeof tried);
    if (machine_read(told, sizeof told) != sizeof told || told[0] > whole)
        return 0;
    memcpy(tried, sound, sizeof tried);
    for (uint32_t k = 0; k < told[1]; k++) {
        if (machine_read(patch, sizeof patch) != sizeof patch || patch[0] > ROOM
            || patch[1] > ROOM - patch[0])
            return 0;
        (void)machine_read(bytes + patch[0], patch[1]);
    }
    ASAN_POISON_MEMORY_REGION(bytes + told[0], ROOM - told[0]);
    return told[0];
}

int main(int argc, char **argv)
{
    uint32_t whole, n;
    if (!machine_begin(argc, argv) || machine_read(&whole, sizeof whole) != sizeof whole
        || whole > ROOM || machine_read(sound, whole) != whole)
        return 2;
    while ((n = next(whole)) > 0) {
        record r;
        memset(&r, 0, sizeof r);
        const char *const why = fc_image_read((const uint8_t *)tried, n, &image);
        if (why != NULL)
            strncpy(r.why, why, sizeof r.why - 1);
        else
            answer(&r);
        machine_write(&r, sizeof r);
    }
    machine_end();
    return 0;
}
