/* Device in an emulator: a Cortex-M7 with a UART.

   The first argument, by semihosting, is one of three:
   - "timer" samples in the timer's interrupt at 4936 Hz of the board's clock.
   - "free" samples whenever there is room, so that a slow emulator causes no overflow.
   - "counted" is "free" with instructions counted, for an emulator in which each lasts 1024 ns
     (-icount shift=10).
   The second argument names a file of scans. Without it the device sends a pattern that contains the
   sample's number. The third argument names a model. The clock starts with the first start of
   streaming. */
#include <string.h>

#include "board.h"
#include "fc_predictor.h"
#include "fc_crc32.h"
#include "fc_device.h"
#include "fc_layout.h"
#include "fc_pace.h"

enum { RING = 1024, RECORD = 12, SCANS_MOST = 250000, ARGUMENTS_MOST = 512 };
/* In place of flash; its content is lost when the emulator ends. */
enum { LISTENERS = 256, MODEL_ROOM = FC_SLOT_BYTES };

static const char descriptor[] = FC_DESCRIPTOR_TEXT("mps2-an500", "synthetic");
static fc_sample slots[RING];
static fc_sample waiting[LISTENERS];
static fc_device device;
static fc_predictor predictor;
static uint64_t models[2][MODEL_ROOM / 8];
static fc_pace pace;
static uint8_t scans[SCANS_MOST * RECORD + 1]; /* one more byte shows that a file is too long */
static size_t scans_bytes;
static bool from_file;
static volatile bool over;

static uint8_t *model_at(int slot)
{
    return (uint8_t *)models[slot];
}

static const uint8_t *model_read(void *own, int slot)
{
    (void)own;
    return model_at(slot);
}

static bool model_clear(void *own, int slot)
{
    (void)own;
    memset(model_at(slot), 0xff, MODEL_ROOM);
    return true;
}

static bool model_write(void *own, int slot, uint32_t at, const uint8_t *bytes, uint32_t n)
{
    (void)own;
    memcpy(model_at(slot) + at, bytes, n);
    return true;
}

static const fc_memory memory = {NULL, MODEL_ROOM, model_read, model_clear, model_write};

static void pattern(uint32_t i, fc_raw *raw)
{
    raw->piezo[0] = i & 1023u;
    raw->piezo[1] = (i >> 10) & 1023u;
    raw->force[0] = (7u * i) & 1023u;
    raw->force[1] = 1023u - (i & 1023u);
    raw->strip[0] = i & 1u;
    raw->strip[1] = (i >> 1) & 1u;
}

static uint16_t get_u16(const uint8_t *from)
{
    return (uint16_t)(from[0] | from[1] << 8);
}

static void sample(void)
{
    fc_raw raw;
    const uint32_t i = device.next;
    if (!from_file) {
        pattern(i, &raw);
    } else if (i < scans_bytes / RECORD) {
        const uint8_t *const record = scans + (size_t)i * RECORD;
        for (int f = 0; f < FC_FINGERS; f++) {
            raw.piezo[f] = get_u16(record + 2 * f);
            raw.force[f] = get_u16(record + 4 + 2 * f);
            raw.strip[f] = get_u16(record + 8 + 2 * f) != 0;
        }
    } else {
        over = true;
        return;
    }
    fc_device_sample(&device, &raw);
}

void board_timer_interrupt(void)
{
    timer_period(fc_pace_next(&pace));
    sample();
    if (over)
        timer_stop();
}

static void talk(void)
{
    uint8_t byte;
    size_t n;
    const uint8_t *const bytes = fc_device_outgoing(&device, &n);
    size_t sent = 0;
    while (sent < n && uart_put(bytes[sent]))
        sent++;
    fc_device_sent(&device, sent);
    while (fc_device_can_receive(&device) && uart_get(&byte))
        fc_device_receive(&device, byte);
}

/* Store the model of the third argument as if it had arrived over the line. */
static void flash(const char *path)
{
    fc_store store;
    const uint8_t *const bytes = scans; /* still empty */
    const size_t n = host_read(path, scans, sizeof scans);
    fc_store_open(&store, &memory);
    if (n == 0 || fc_store_begin(&store, (uint32_t)n, fc_crc32(bytes, n)) != NULL
        || fc_store_chunk(&store, 0, bytes, (uint32_t)n) != NULL
        || fc_store_keep(&store) != NULL)
        board_exit(2);
}

/* Read the arguments. Return true if the timer sets the pace. */
static bool read_arguments(uint32_t (**clock)(void))
{
    static char text[ARGUMENTS_MOST];
    host_arguments(text, sizeof text);
    char *const path = strchr(text, ' ');
    char *const model = path == NULL ? NULL : strchr(path + 1, ' ');
    if (model != NULL) {
        *model = '\0';
        flash(model + 1);
    }
    if (path != NULL) {
        from_file = true;
        scans_bytes = host_read(path + 1, scans, sizeof scans);
        if (scans_bytes == 0 || scans_bytes == sizeof scans)
            board_exit(2); /* no such file, or more than fits */
    }
    const bool counted = strncmp(text, "counted", 7) == 0;
    *clock = counted ? counter_ns : NULL;
    return !counted && strncmp(text, "free", 4) != 0;
}

int main(void)
{
    uint32_t (*clock)(void);
    const bool timed = read_arguments(&clock);
    bool begun = false;
    uart_init();
    counter_start();
    fc_device_init(&device, descriptor, host_seconds(), slots, RING);
    fc_device_copy_samples(&device, waiting, LISTENERS);
    fc_predictor_init(&predictor, &device, &memory, &(fc_board){.clock = clock});
    fc_pace_init(&pace, BOARD_CLOCK_HZ, FC_RATE_HZ);
    for (;;) {
        talk();
        if (!begun && device.streaming) {
            begun = true;
            if (timed)
                timer_start(fc_pace_next(&pace));
        }
        if (begun && !timed && !over && fc_ring_used(&device.ring) < RING - 1)
            sample();
        fc_predictor_work(&predictor);
    }
}
