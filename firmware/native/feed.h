/* Reader of raw scans from a file or a pipe: records of six uint16, little-endian. */
#ifndef FEED_H
#define FEED_H

#include <stddef.h>

#include "fc_device.h"

enum { FEED_RECORD = 12 };

typedef struct {
    int fd;
    size_t from, to;
    uint8_t bytes[FEED_RECORD * 512];
} feed;

typedef enum { FEED_SCAN, FEED_DRY, FEED_END } feed_state;

/* Open the file. Return -1 and set errno on failure.
   f     out
   path  in, or "-" for standard input */
int feed_open(feed *f, const char *path);

/* Read the next scan without waiting. Return FEED_DRY if the pipe is empty.
   f    in, out
   raw  out, counts; unchanged without a scan */
feed_state feed_next(feed *f, fc_raw *raw);

#endif
