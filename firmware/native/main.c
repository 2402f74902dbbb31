/* Device without hardware: the firmware's core on a pseudo terminal, fed with scans. */
#define _POSIX_C_SOURCE 200809L

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "fc_predictor.h"
#include "fc_device.h"
#include "fc_layout.h"
#include "fc_pace.h"
#include "feed.h"
#include "line.h"
#include "models.h"

enum { LISTENERS = 4096 };
enum { NANO = 1000000000, RING_MOST = 1 << 16, SPEED_MOST = 1000 };

static const char descriptor[] = FC_DESCRIPTOR_TEXT("native", "twin");
static const char usage[] =
    "usage: firstcontact-device --scans FILE|- [--speed N] [--ring N] [--boot N] [--models FILE]\n"
    "Prints the path of a pseudo terminal and serves the scans there, from the first start on.\n"
    "With --models it predicts by itself, with the model in this file.\n";

typedef struct {
    const char *scans, *models;
    unsigned long speed, ring, boot;
} options;

static uint64_t now_ns(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (uint64_t)t.tv_sec * NANO + (uint64_t)t.tv_nsec;
}

static uint32_t clock_ns(void)
{
    return (uint32_t)now_ns(CLOCK_MONOTONIC);
}

static int number(const char *text, unsigned long low, unsigned long high, unsigned long *out)
{
    char *end;
    errno = 0;
    *out = strtoul(text, &end, 10);
    return errno == 0 && end != text && *end == '\0' && *out >= low && *out <= high;
}

static int parse(int argc, char **argv, options *o)
{
    int good = argc % 2;
    for (int i = 1; good && i + 1 < argc; i += 2) {
        const char *const value = argv[i + 1];
        if (strcmp(argv[i], "--scans") == 0)
            o->scans = value;
        else if (strcmp(argv[i], "--models") == 0)
            o->models = value;
        else if (strcmp(argv[i], "--speed") == 0)
            good = number(value, 1, SPEED_MOST, &o->speed);
        else if (strcmp(argv[i], "--ring") == 0)
            good = number(value, 1, RING_MOST - 1, &o->ring);
        else if (strcmp(argv[i], "--boot") == 0)
            good = number(value, 0, 0xffffffffu, &o->boot);
        else
            good = 0;
    }
    return good && o->scans != NULL;
}

/* Clock of a device. It starts with the first start of streaming and never stops. */
typedef struct {
    fc_pace pace;
    uint64_t next;
    bool running, over;
} ticking;

/* Take the scans that are due. Send in between, so that the ring does not overflow after a pause of
   the operating system. */
static void sample(ticking *t, feed *scans, fc_predictor *a, fc_device *d, line *l)
{
    const uint64_t now = now_ns(CLOCK_MONOTONIC);
    if (!t->running && !t->over && d->streaming) {
        t->running = true;
        t->next = now;
    }
    for (int k = 1; t->running && t->next <= now; k++) {
        fc_raw raw;
        const feed_state state = feed_next(scans, &raw);
        if (state == FEED_END) {
            t->running = false;
            t->over = true;
        } else if (state == FEED_DRY) {
            t->next = now + 1; /* the clock waits for the next scan */
        } else {
            fc_device_sample(d, &raw);
            t->next += fc_pace_next(&t->pace);
            if (d->own_samples.size > 0)
                fc_predictor_work(a);
            if (k % FC_FRAME_SAMPLES == 0)
                line_send(l, d);
        }
    }
}

int main(int argc, char **argv)
{
    static fc_sample slots[RING_MOST];
    static fc_sample waiting[LISTENERS];
    static fc_device device;
    static fc_predictor predictor;
    static fc_memory memory;
    static feed scans;
    line l;
    options o = {NULL, NULL, 1, 8192, (unsigned long)(now_ns(CLOCK_REALTIME) & 0xffffffffu)};
    ticking t = {.next = 0, .running = false, .over = false};

    if (!parse(argc, argv, &o)) {
        fputs(usage, stderr);
        return 2;
    }
    if (feed_open(&scans, o.scans) < 0) {
        fprintf(stderr, "%s cannot be opened: %s\n", o.scans, strerror(errno));
        return 2;
    }
    const char *const path = line_open(&l);
    if (path == NULL) {
        fprintf(stderr, "no pseudo terminal: %s\n", strerror(errno));
        return 1;
    }
    fc_device_init(&device, descriptor, (uint32_t)o.boot, slots, (uint32_t)o.ring + 1);
    if (o.models != NULL) {
        if (models_open(&memory, o.models) < 0) {
            fprintf(stderr, "%s cannot keep models: %s\n", o.models, strerror(errno));
            return 2;
        }
        fc_device_copy_samples(&device, waiting, LISTENERS);
        fc_predictor_init(&predictor, &device, &memory, &(fc_board){.clock = clock_ns});
    }
    fc_pace_init(&t.pace, NANO, (uint32_t)(FC_RATE_HZ * o.speed));
    printf("%s\n", path);
    fflush(stdout);
    for (;;) {
        sample(&t, &scans, &predictor, &device, &l);
        line_send(&l, &device);
        line_wait(&l, &device, t.running ? 1 : -1);
        line_hear(&l, &device);
    }
}
