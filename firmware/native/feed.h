/* Raw scans out of a file or a pipe: records of six uint16, little-endian. */
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

/* path "-" is the standard input; returns -1, errno set, where it cannot be opened. */
int feed_open(feed *f, const char *path);

/* The next scan; FEED_DRY where a pipe has none just now. Never waits. */
feed_state feed_next(feed *f, fc_raw *raw);

#endif
