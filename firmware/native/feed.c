#define _POSIX_C_SOURCE 200809L

#include "feed.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <unistd.h>

int feed_open(feed *f, const char *path)
{
    f->from = f->to = 0;
    f->fd = strcmp(path, "-") == 0 ? STDIN_FILENO : open(path, O_RDONLY);
    if (f->fd < 0)
        return -1;
    return fcntl(f->fd, F_SETFL, fcntl(f->fd, F_GETFL) | O_NONBLOCK);
}

static uint16_t get_u16(const uint8_t *from)
{
    return (uint16_t)(from[0] | from[1] << 8);
}

feed_state feed_next(feed *f, fc_raw *raw)
{
    while (f->to - f->from < FEED_RECORD) {
        memmove(f->bytes, f->bytes + f->from, f->to - f->from);
        f->to -= f->from;
        f->from = 0;
        const ssize_t n = read(f->fd, f->bytes + f->to, sizeof f->bytes - f->to);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0 && errno == EAGAIN)
            return FEED_DRY;
        if (n <= 0)
            return FEED_END;
        f->to += (size_t)n;
    }
    const uint8_t *const record = f->bytes + f->from;
    for (int k = 0; k < FC_FINGERS; k++) {
        raw->piezo[k] = get_u16(record + 2 * k);
        raw->force[k] = get_u16(record + 4 + 2 * k);
        raw->strip[k] = get_u16(record + 8 + 2 * k) != 0;
    }
    f->from += FEED_RECORD;
    return FEED_SCAN;
}
