/* Image of a model: all constants of a chain in one block of bytes, which is read in place.

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". */
#ifndef FC_IMAGE_H
#define FC_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Also around the headers below, so that C++ finds the functions of all of them. */
#ifdef __cplusplus
extern "C" {
#endif

#include "fc_detector.h"
#include "fc_touch.h"

enum {
    FC_IMAGE_VERSION = 4,
    FC_IMAGE_TEXT = 300,    /* longest description, bytes */
    FC_CAPACITY_MOST = 1 << 20 /* samples in memory */
};

/* Lengths in samples at the rate of the image. */
typedef struct {
    int32_t gate_step, rearm;   /* see fc_gate */
    int32_t every, age;         /* time between two steady states, and age of their newest sample */
    int32_t confirmed, lasting; /* signal that confirms a contact, and its newest part */
    int32_t lag;                /* distance of the two samples that measure how fast a signal changes */
    int32_t before, guard;      /* signal before the contact, and its last part, which is left out */
    int32_t after;              /* time from the first contact to the end of the pinch */
    int32_t capacity;           /* samples in memory, a power of 2 */
    int32_t unused;
} fc_timing;

typedef struct {
    double rate;                /* Hz */
    const fc_timing *timing;
    const fc_detector_constants *detector;
    const double *floors;       /* noise of each channel at rest, V; 0 if unknown */
    const char *text;           /* description, printable ASCII */
    uint32_t text_bytes;
    fc_model model;
} fc_image;

/* Check and read an image. Return NULL, or the fault as a sentence in English.
   bytes  in, at an address that is a multiple of 8, (n). They must outlive `image`.
   n      in, bytes
   image  out */
const char *fc_image_read(const uint8_t *bytes, size_t n, fc_image *image);

#ifdef __cplusplus
}
#endif
#endif
