/* Pseudo terminal of a device. */
#ifndef LINE_H
#define LINE_H

#include <stdbool.h>

#include "fc_device.h"

typedef struct {
    int fd;
    uint8_t bytes[256]; /* bytes of the host that the device has not taken yet */
    size_t from, to;
} line;

/* Open a pseudo terminal and return the path of the host's end. On failure return NULL and set
   errno.
   l  out */
const char *line_open(line *l);

/* Send as many bytes as the line takes without waiting.
   l  in, out
   d  in, out */
void line_send(line *l, fc_device *d);

/* Pass the host's bytes to the device.
   l  in, out
   d  in, out */
void line_hear(line *l, fc_device *d);

/* Wait until the host sends or reads bytes, or until the timeout.
   l           in
   d           in, out
   timeout_ms  in, ms; -1 for none */
void line_wait(const line *l, fc_device *d, int timeout_ms);

#endif
