/* Model image: the constants of the kernels as bytes, read in place.

   firstcontact.export._model_image writes it. The bytes are data, never code. An image that does
   not fit the kernels of this firmware is refused before any of it is used. */
#ifndef FC_IMAGE_H
#define FC_IMAGE_H

#include <stddef.h>

#include "fc_anytime.h"
#include "fc_detector.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    FC_IMAGE_FORMAT = 1, /* raise it when an older reader cannot read the format */
    FC_IMAGE_RIGS = 3,
    FC_IMAGE_TEXT = 300 /* longest text about the model */
};

typedef struct {
    const char *text; /* JSON object for the descriptor: printable ASCII, text_bytes without a
                         zero */
    uint32_t text_bytes;
    bool gated;       /* the noise floors are known */
    double floors[2];
    fc_loudness judge;
    fc_anytime anytime;
    fc_rig rigs[FC_IMAGE_RIGS];
} fc_image;

/* Return the CRC-32 of all sizes of the kernels. An image for other sizes is refused. */
uint32_t fc_image_sizes(void);

/* Read an image at an address that is a multiple of 8. The caller keeps the bytes. Return NULL, or
   the reason for a refusal. */
const char *fc_image_read(const uint8_t *bytes, size_t n, fc_image *image);

#ifdef __cplusplus
}
#endif
#endif
