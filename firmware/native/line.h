/* A pseudo terminal that a device talks over. */
#ifndef LINE_H
#define LINE_H

#include <stdbool.h>

#include "fc_device.h"

typedef struct {
    int fd;
    uint8_t bytes[256]; /* of the host, read while the device could still listen */
    size_t from, to;
} line;

/* Opens one and returns the path of the host's end, or NULL, errno set. */
const char *line_open(line *l);

/* Sends what the line takes without waiting. */
void line_send(line *l, fc_device *d);

/* Gives the device what has come from the host. */
void line_hear(line *l, fc_device *d);

/* Waits until the host says or takes something, at most this long (ms, -1 for ever). */
void line_wait(const line *l, fc_device *d, int timeout_ms);

#endif
