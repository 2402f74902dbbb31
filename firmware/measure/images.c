/* Read intact and damaged images, and run the chain with those that are not refused. Input: the
   length of an intact image and its bytes; then, for each image to try, its length and its number
   of patches; for each patch its offset, its length and its bytes. Length and checksum in the head
   are set to fit. Output: one record per image. */
#include "machine.h"

#include <math.h>
#include <string.h>

#include "fc_chain.h"
#include "fc_crc32.h"

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/asan_interface.h>
#else
#define ASAN_POISON_MEMORY_REGION(at, n) ((void)(at), (void)(n))
#define ASAN_UNPOISON_MEMORY_REGION(at, n) ((void)(at), (void)(n))
#endif

enum { ROOM = 1 << 19, MEMORY = 1 << 16, SAMPLES = 500, HEAD = 16 };

typedef struct {
    char why[72];                /* reason for the refusal, "" if the image was accepted */
    int32_t contacts, estimates; /* number of events */
    int32_t wrong, unused;       /* estimates that are not 0 <= low <= value <= high <= 100; of an SVM,
                                    that are not finite, or where low > high */
    float value, low, high, spread; /* newest estimate */
} record;

static uint64_t sound[ROOM / 8], tried[ROOM / 8], memory[MEMORY / 8];
static fc_image image;
static fc_chain chain;

/* Test signal: noise, then a swing. */
static double heard(uint32_t n)
{
    static const double swing[] = {0.0, 0.1, 0.3, 0.5, 0.4, 0.1, -0.2, -0.3, -0.2, 0.0};
    const double noise = 1e-3 * (double)((n * 2654435761u >> 20) & 15u);
    return n >= 300 ? noise + swing[(n - 300) % 10] * 80.0 / (double)(n - 220) : noise;
}

static void on_event(void *context, const fc_event *e)
{
    record *const r = context;
    const fc_estimate *const s = &e->estimate;
    r->contacts += e->kind == FC_CONTACT_FOUND;
    if (e->kind != FC_ESTIMATED)
        return;
    r->estimates++;
    r->wrong += image.model.kind == FC_MODEL_SVM
                    ? !(isfinite(s->value) && s->low <= s->high && isfinite(s->high - s->low))
                    : !(s->low >= 0.0f && s->low <= s->value && s->value <= s->high && s->high <= 100.0f);
    r->value = s->value;
    r->low = s->low;
    r->high = s->high;
    r->spread = s->spread;
}

static void run(record *r)
{
    const fc_program program = {.context = r, .emit = on_event};
    fc_stream stream = {.channels = 2, .finger = {0, 1}, .alpha = {1.0, 1.0}};
    if (fc_chain_bytes(&image, &stream) > sizeof memory) {
        strcpy(r->why, "it needs too much memory");
        return;
    }
    fc_chain_init(&chain, &image, &stream, &program, memory);
    fc_chain_restart(&chain, 0, false);
    for (uint32_t n = 0; n < SAMPLES; n++) {
        const double volts[2] = {heard(n), heard(n % 300)};
        fc_chain_take(&chain, volts, NULL);
    }
    fc_chain_finish(&chain);
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
    if (told[0] >= HEAD) {
        const uint32_t sum = fc_crc32(bytes + HEAD, told[0] - HEAD);
        memcpy(bytes + 8, told, sizeof *told);
        memcpy(bytes + 12, &sum, sizeof sum);
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
            run(&r);
        machine_write(&r, sizeof r);
    }
    machine_end();
    return 0;
}
