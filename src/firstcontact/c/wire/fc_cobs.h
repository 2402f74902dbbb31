/* Consistent overhead byte stuffing (Cheshire and Baker 1999), which removes all zeros. */
#ifndef FC_COBS_H
#define FC_COBS_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Largest stuffed length of n bytes: one code for each 254 of them, and one more. */
#define FC_COBS_MAX(n) ((n) + (n) / 254u + 1u)

/* Stuff n bytes into out, which has room for FC_COBS_MAX(n). Return the stuffed length. The zero
   that ends a frame is not written. */
size_t fc_cobs_stuff(const uint8_t *in, size_t n, uint8_t *out);

/* Undo the stuffing. out has room for n bytes and may be in. Return the number of bytes, or -1 if
   in is empty, contains a zero or has a run beyond its end. */
ptrdiff_t fc_cobs_unstuff(const uint8_t *in, size_t n, uint8_t *out);

#ifdef __cplusplus
}
#endif
#endif
