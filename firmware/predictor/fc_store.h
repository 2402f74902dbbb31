/* Store with two slots for a model in non-volatile memory: one holds the active model, the other
   receives the next.

   A slot is valid once its head is written. The head is written last, after the bytes were read
   back and matched their CRC. So the older model survives a power cut at any time.

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". */
#ifndef FC_STORE_H
#define FC_STORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
    FC_SLOT_HEAD = 16,
    /* Size of a slot, 64 sectors. */
    FC_SLOT_BYTES = 1 << 18
};

/* Non-volatile memory. */
typedef struct fc_memory {
    void *own;           /* passed to these functions, or NULL */
    uint32_t slot_bytes;
    /* Return the address of a slot, a multiple of 8.
       own   in, as above
       slot  in, 0 or 1 */
    const uint8_t *(*read)(void *own, int slot);
    /* Clear a slot, before it is written. Return false on failure.
       own   in, as above
       slot  in, 0 or 1 */
    bool (*clear)(void *own, int slot);
    /* Write cleared bytes of a slot. Return false on failure.
       own    in, as above
       slot   in, 0 or 1
       at     in, bytes from the beginning of the slot
       bytes  in, (n)
       n      in, bytes */
    bool (*write)(void *own, int slot, uint32_t at, const uint8_t *bytes, uint32_t n);
} fc_memory;

typedef struct {
    const fc_memory *memory;
    int active;          /* slot of the active model, -1 for none */
    uint32_t bytes;      /* length of the active model */
    uint32_t turn;       /* number of models stored so far */
    bool taking, kept;   /* a transfer is in progress; the last transfer was stored */
    uint32_t length, crc, next; /* of the transfer in progress */
} fc_store;

/* Find the stored models.
   s       out
   memory  in, which must outlive the store */
void fc_store_open(fc_store *s, const fc_memory *memory);

/* Return the active model; NULL if there is none.
   s  in
   n  out, bytes */
const uint8_t *fc_store_model(const fc_store *s, uint32_t *n);

/* Activate the older model, because the newer one is unusable. The next model replaces the newer
   one. Return false if there is no older model.
   s  in, out */
bool fc_store_fall_back(fc_store *s);

/* Begin a transfer, or add a chunk. Return NULL, or the reason of a refusal. Repeated chunks are
   accepted. s->next is the offset of the next chunk.
   s          in, out
   length     in, bytes of the whole model
   crc        in, its fc_crc32
   at         in, bytes from the model's beginning
   bytes      in, (n)
   n          in, bytes */
const char *fc_store_begin(fc_store *s, uint32_t length, uint32_t crc);
const char *fc_store_chunk(fc_store *s, uint32_t at, const uint8_t *bytes, uint32_t n);

/* Return the bytes of a complete transfer, for checks before fc_store_keep; NULL if it is not complete.
   s    in
   why  out, NULL, or the reason of a refusal */
const uint8_t *fc_store_whole(const fc_store *s, const char **why);

/* Make the transferred model the active one. Return NULL, or the reason of a refusal.
   s  in, out */
const char *fc_store_keep(fc_store *s);

#ifdef __cplusplus
}
#endif
#endif
