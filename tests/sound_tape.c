/* A sound input without hardware, for ALSA and all that is built on it: it plays a tape of 16-bit
 * samples into the input at its rate by the clock, and has the faults of real ones.
 *
 *   pcm.NAME { type tape  file PATH  rate HZ  channels N  ppm N  lose_at N  lose N  loop BOOL
 *              waits BOOL }
 *
 * ppm: how much faster than it says it is. lose_at, lose: at this sample of the tape so many are
 * lost, as when the buffer overflows. At the end of the tape it is unplugged, unless it loops.
 * waits: the tape stands still while the buffer is nearly full, so that a late reader loses nothing.
 */
#include <alsa/asoundlib.h>
#include <alsa/pcm_external.h>
#include <stdint.h>
#include <sys/timerfd.h>
#include <time.h>

typedef struct {
    snd_pcm_ioplug_t io;
    int16_t *tape;
    long frames, rate, channels, ppm, lose_at, lose, loop, waits;
    long given;    /* samples in or through the buffer since then */
    long from;     /* of the tape, where the input was started */
    double zero;   /* when sample 0 of the tape was taken, s; 0 before it */
    double began;  /* when the input was started, s */
    int lost, gone, running;
} tape_t;

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

static double speed(const tape_t *t) { return t->rate * (1.0 + 1e-6 * t->ppm); }

static int start(snd_pcm_ioplug_t *io) {
    tape_t *t = io->private_data;
    if (t->gone) return -ENODEV;
    if (t->zero == 0.0) t->zero = now();
    t->began = now();
    t->from = (long)((t->began - t->zero) * speed(t));
    t->given = 0;
    t->running = 1;
    return 0;
}

static int stop(snd_pcm_ioplug_t *io) {
    ((tape_t *)io->private_data)->running = 0;
    return 0;
}

static int prepare(snd_pcm_ioplug_t *io) {
    tape_t *t = io->private_data;
    t->running = 0;
    if (t->lost == 1) { /* what a host that was away for so long has not taken */
        struct timespec away = {t->lose / t->rate, (long)(1e9 * (t->lose % t->rate) / t->rate)};
        nanosleep(&away, NULL);
        t->lost = 2;
    }
    return t->gone ? -ENODEV : 0;
}

/* As a card does: into the buffer whatever has been sampled, and how far it has come. */
static snd_pcm_sframes_t pointer(snd_pcm_ioplug_t *io) {
    tape_t *t = io->private_data;
    if (!t->running) return 0;
    long size = (long)io->buffer_size, taken = (long)((now() - t->began) * speed(t));
    long end = t->from + taken;
    if (t->waits) {
        const long most = (long)io->appl_ptr + size / 2, left = t->frames - t->from;
        if (taken > most) {
            t->began += (taken - most) / speed(t);
            taken = most;
        }
        if (taken > left) taken = left;
        end = t->from + (long)io->appl_ptr + (long)io->period_size;
    }
    if (!t->loop && end >= t->frames) t->gone = 1;
    if (t->gone) {
        /* With an error the library takes it for an overrun. */
        snd_pcm_ioplug_set_state(io, SND_PCM_STATE_DISCONNECTED);
        return 0;
    }
    if (!t->lost && t->lose > 0 && t->from + taken >= t->lose_at) {
        t->lost = 1;
        return -EPIPE;
    }
    if (taken - (long)io->appl_ptr > size) return -EPIPE;
    const snd_pcm_channel_area_t *areas = snd_pcm_ioplug_mmap_areas(io);
    for (; areas && t->given < taken; t->given++)
        for (long c = 0; c < t->channels; c++) {
            const snd_pcm_channel_area_t *a = &areas[c];
            char *at = (char *)a->addr + (a->first + t->given % size * a->step) / 8;
            *(int16_t *)at = t->tape[(t->from + t->given) % t->frames * t->channels + c];
        }
    return taken % size;
}

static int revents(snd_pcm_ioplug_t *io, struct pollfd *fds, unsigned n, unsigned short *out) {
    tape_t *t = io->private_data;
    uint64_t ticks;
    (void)n;
    *out = 0;
    if ((fds[0].revents & POLLIN) && read(fds[0].fd, &ticks, sizeof ticks) < 0 && errno != EAGAIN)
        return -errno;
    snd_pcm_sframes_t there = snd_pcm_avail_update(io->pcm);
    if (there < 0 || there >= (snd_pcm_sframes_t)io->period_size) *out = POLLIN;
    if (t->gone) *out |= POLLERR;
    return 0;
}

static int closed(snd_pcm_ioplug_t *io) {
    tape_t *t = io->private_data;
    close(io->poll_fd);
    free(t->tape);
    free(t);
    return 0;
}

static const snd_pcm_ioplug_callback_t callbacks = {
    .start = start, .stop = stop, .prepare = prepare,
    .pointer = pointer, .poll_revents = revents, .close = closed,
};

static int unroll(tape_t *t, const char *path) {
    FILE *f = path ? fopen(path, "rb") : NULL;
    if (!f) return -ENOENT;
    fseek(f, 0, SEEK_END);
    long bytes = ftell(f);
    rewind(f);
    t->frames = bytes / (2 * t->channels);
    t->tape = malloc((size_t)bytes);
    int whole = t->tape && t->frames > 0 && fread(t->tape, 1, (size_t)bytes, f) == (size_t)bytes;
    fclose(f);
    return whole ? 0 : -EIO;
}

static int constrain(tape_t *t) {
    snd_pcm_ioplug_t *io = &t->io;
    const unsigned access[] = {SND_PCM_ACCESS_MMAP_INTERLEAVED, SND_PCM_ACCESS_RW_INTERLEAVED};
    const unsigned format[] = {SND_PCM_FORMAT_S16_LE};
    int e = snd_pcm_ioplug_set_param_list(io, SND_PCM_IOPLUG_HW_ACCESS, 2, access);
    if (!e) e = snd_pcm_ioplug_set_param_list(io, SND_PCM_IOPLUG_HW_FORMAT, 1, format);
    if (!e) e = snd_pcm_ioplug_set_param_minmax(io, SND_PCM_IOPLUG_HW_CHANNELS, t->channels, t->channels);
    if (!e) e = snd_pcm_ioplug_set_param_minmax(io, SND_PCM_IOPLUG_HW_RATE, t->rate, t->rate);
    if (!e) e = snd_pcm_ioplug_set_param_minmax(io, SND_PCM_IOPLUG_HW_PERIOD_BYTES, 32, 65536);
    if (!e) e = snd_pcm_ioplug_set_param_minmax(io, SND_PCM_IOPLUG_HW_BUFFER_BYTES, 256, 262144);
    if (!e) e = snd_pcm_ioplug_set_param_minmax(io, SND_PCM_IOPLUG_HW_PERIODS, 2, 1024);
    return e;
}

SND_PCM_PLUGIN_DEFINE_FUNC(tape) {
    snd_config_iterator_t i, next;
    const char *path = NULL;
    tape_t *t = calloc(1, sizeof *t);
    (void)root;
    if (!t) return -ENOMEM;
    t->rate = 48000;
    t->channels = 1;
    snd_config_for_each(i, next, conf) {
        snd_config_t *entry = snd_config_iterator_entry(i);
        const char *id;
        if (snd_config_get_id(entry, &id) < 0) continue;
        struct { const char *name; long *value; } known[] = {
            {"rate", &t->rate}, {"channels", &t->channels}, {"ppm", &t->ppm},
            {"lose_at", &t->lose_at}, {"lose", &t->lose}, {"loop", &t->loop},
            {"waits", &t->waits},
        };
        for (size_t k = 0; k < sizeof known / sizeof *known; k++)
            if (!strcmp(id, known[k].name)) snd_config_get_integer(entry, known[k].value);
        if (!strcmp(id, "file")) snd_config_get_string(entry, &path);
    }
    int e = stream == SND_PCM_STREAM_CAPTURE ? unroll(t, path) : -EINVAL;
    if (e < 0) goto failed;
    struct itimerspec tick = {{0, 500000}, {0, 500000}};
    t->io.version = SND_PCM_IOPLUG_VERSION;
    t->io.name = "a tape";
    t->io.callback = &callbacks;
    t->io.private_data = t;
    t->io.poll_fd = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK);
    t->io.poll_events = POLLIN;
    t->io.mmap_rw = 1;
    timerfd_settime(t->io.poll_fd, 0, &tick, NULL);
    e = snd_pcm_ioplug_create(&t->io, name, stream, mode);
    if (e < 0) goto failed;
    e = constrain(t);
    if (e < 0) {
        snd_pcm_ioplug_delete(&t->io);
        return e;
    }
    *pcmp = t->io.pcm;
    return 0;
failed:
    free(t->tape);
    free(t);
    return e;
}
SND_PCM_PLUGIN_SYMBOL(tape);
