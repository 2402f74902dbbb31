#define _DEFAULT_SOURCE
#define _XOPEN_SOURCE 700

#include "line.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

const char *line_open(line *l)
{
    struct termios mode;
    l->from = l->to = 0;
    l->fd = posix_openpt(O_RDWR | O_NOCTTY);
    if (l->fd < 0 || grantpt(l->fd) < 0 || unlockpt(l->fd) < 0)
        return NULL;
    const char *const path = ptsname(l->fd);
    if (path == NULL)
        return NULL;
    /* Keep the host's end open here, so that hosts can come and go as on a board's port. */
    const int host = open(path, O_RDWR | O_NOCTTY);
    if (host < 0 || tcgetattr(host, &mode) < 0)
        return NULL;
    cfmakeraw(&mode);
    if (tcsetattr(host, TCSANOW, &mode) < 0)
        return NULL;
    return fcntl(l->fd, F_SETFL, O_NONBLOCK) < 0 ? NULL : path;
}

void line_send(line *l, fc_device *d)
{
    for (;;) {
        size_t n;
        const uint8_t *const bytes = fc_device_outgoing(d, &n);
        if (n == 0)
            return;
        const ssize_t sent = write(l->fd, bytes, n);
        if (sent <= 0)
            return;
        fc_device_sent(d, (size_t)sent);
    }
}

void line_hear(line *l, fc_device *d)
{
    while (fc_device_can_receive(d)) {
        if (l->from == l->to) {
            const ssize_t n = read(l->fd, l->bytes, sizeof l->bytes);
            if (n <= 0)
                return;
            l->from = 0;
            l->to = (size_t)n;
        }
        fc_device_receive(d, l->bytes[l->from++]);
    }
}

void line_wait(const line *l, fc_device *d, int timeout_ms)
{
    size_t n;
    struct pollfd waits = {.fd = l->fd, .events = 0};
    if (fc_device_can_receive(d))
        waits.events |= POLLIN;
    (void)fc_device_outgoing(d, &n);
    if (n > 0)
        waits.events |= POLLOUT;
    (void)poll(&waits, 1, timeout_ms);
}
