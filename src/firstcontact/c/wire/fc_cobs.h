/* Consistent overhead byte stuffing (Cheshire and Baker 1999), which removes all zeros.

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". */
#ifndef FC_COBS_H
#define FC_COBS_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Largest stuffed length of n bytes: one code for each 254 of them, and one more. */
#define FC_COBS_MAX(n) ((n) + (n) / 254u + 1u)

/* Stuff bytes. Return the stuffed length. The zero that ends a frame is not written.
   in   in, (n)
   n    in, bytes
   out  out, (FC_COBS_MAX(n)), apart from `in` */
size_t fc_cobs_stuff(const uint8_t *in, size_t n, uint8_t *out);

/* Undo the stuffing. Return the number of bytes, or -1 if `in` is empty, contains a zero or has a run
   beyond its end.
   in   in, (n)
   n    in, bytes
   out  out, (n). It can be `in`. */
ptrdiff_t fc_cobs_unstuff(const uint8_t *in, size_t n, uint8_t *out);

#ifdef __cplusplus
}
#endif
#endif
