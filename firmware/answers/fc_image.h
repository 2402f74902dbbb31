/* A model as bytes: the constants that the kernels interpret, read where they lie.

   firstcontact.export._model_image writes it. The bytes are data and are never run; what does not
   fit the kernels that this firmware was built with is refused before any of it is used. */
#ifndef FC_IMAGE_H
#define FC_IMAGE_H

#include <stddef.h>

#include "fc_anytime.h"
#include "fc_detector.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    FC_IMAGE_FORMAT = 1, /* raised when a reader of the one before could not read it */
    FC_IMAGE_RIGS = 3,
    FC_IMAGE_TEXT = 300 /* longest text about it */
};

typedef struct {
    const char *text; /* JSON object about it for the descriptor: printable ASCII, text_bytes
                         without a zero */
    uint32_t text_bytes;
    bool gated;       /* the noise floors are known */
    double floors[2];
    fc_loudness judge;
    fc_anytime anytime;
    fc_rig rigs[FC_IMAGE_RIGS];
} fc_image;

/* CRC-32 of all sizes that the kernels were built with: an image for others is refused. */
uint32_t fc_image_sizes(void);

/* Reads an image at an address that 8 divides; the bytes must stay. Returns NULL, or why not. */
const char *fc_image_read(const uint8_t *bytes, size_t n, fc_image *image);

#ifdef __cplusplus
}
#endif
#endif
