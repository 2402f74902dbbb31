/* CRC-32 of zlib and Ethernet. */
#ifndef FC_CRC32_H
#define FC_CRC32_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Return the checksum.
   data  in, (n), or NULL if n is 0
   n     in, bytes */
uint32_t fc_crc32(const uint8_t *data, size_t n);

#ifdef __cplusplus
}
#endif
#endif
