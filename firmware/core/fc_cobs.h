/* Consistent overhead byte stuffing (Cheshire and Baker 1999): bytes without zeros. */
#ifndef FC_COBS_H
#define FC_COBS_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Most bytes that n bytes become: one code for each 254 of them, and one more. */
#define FC_COBS_MAX(n) ((n) + (n) / 254u + 1u)

/* Stuffs n bytes into out, which has room for FC_COBS_MAX(n); returns how many they became.
   The zero that ends a frame is not written. */
size_t fc_cobs_stuff(const uint8_t *in, size_t n, uint8_t *out);

/* Undoes it; out has room for n and may be in. Returns how many bytes came out, or -1 where
   in is empty, has a zero in it or a run that reaches beyond its end. */
ptrdiff_t fc_cobs_unstuff(const uint8_t *in, size_t n, uint8_t *out);

#ifdef __cplusplus
}
#endif
#endif
