/* A fingertip pair in an emulator: a Cortex-M7 that talks over its UART.

   Arguments, by semihosting: "timer" samples in the timer's interrupt at 4936 Hz of the
   board's clock; "free" samples whenever there is room, so that nothing overflows however
   slow the emulator is. A path behind it names a file of scans; without one a pattern is
   sent that has the sample's number in it. The clock starts with the first start. */
#include <string.h>

#include "board.h"
#include "fc_device.h"
#include "fc_layout.h"
#include "fc_pace.h"

enum { RING = 1024, RECORD = 12, SCANS_MOST = 250000, ARGUMENTS_MOST = 512 };

static const char descriptor[] = FC_DESCRIPTOR_TEXT("mps2-an500", "synthetic");
static fc_sample slots[RING];
static fc_device device;
static fc_pace pace;
static uint8_t scans[SCANS_MOST * RECORD + 1]; /* one more tells that a file is too long */
static size_t scans_bytes;
static bool from_file;
static volatile bool over;

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
    while (fc_device_listens(&device) && uart_get(&byte))
        fc_device_hear(&device, byte);
}

/* Returns whether the timer paces. */
static bool read_arguments(void)
{
    static char text[ARGUMENTS_MOST];
    host_arguments(text, sizeof text);
    const char *const path = strchr(text, ' ');
    if (path != NULL) {
        from_file = true;
        scans_bytes = host_read(path + 1, scans, sizeof scans);
        if (scans_bytes == 0 || scans_bytes == sizeof scans)
            board_exit(2); /* no such file, or more than fits */
    }
    return strncmp(text, "free", 4) != 0;
}

int main(void)
{
    const bool timed = read_arguments();
    bool begun = false;
    uart_init();
    fc_device_init(&device, descriptor, host_seconds(), slots, RING);
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
    }
}
