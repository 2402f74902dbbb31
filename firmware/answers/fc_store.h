/* Two places for a model in memory that outlives the power: one holds what answers, the other
   takes what comes.

   A place counts only once its head is written, and the head is written last, over bytes that were
   read back and agree with their CRC. Whenever the power goes, the older model is whole. */
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
    /* What a place takes on every board, 64 sectors: the form that `export-model --to hand` writes
       unless told otherwise has 239 kB at most, with a rig for each finger and eight levels. */
    FC_SLOT_BYTES = 1 << 18
};

/* What keeps bytes. read gives them where they lie, at an address that 8 divides; write returns
   false where they could not be kept, and may only be asked for what was cleared before. */
typedef struct fc_keeper {
    void *own;
    uint32_t slot_bytes;
    const uint8_t *(*read)(void *own, int slot);
    bool (*clear)(void *own, int slot);
    bool (*write)(void *own, int slot, uint32_t at, const uint8_t *bytes, uint32_t n);
} fc_keeper;

typedef struct {
    const fc_keeper *keeper;
    int active;          /* -1 where no place holds a model */
    uint32_t bytes;      /* of the active one */
    uint32_t turn;       /* counts the models kept */
    bool taking, kept;   /* a model is coming; the last that came was kept */
    uint32_t length, crc, next; /* of what is taken */
} fc_store;

void fc_store_open(fc_store *s, const fc_keeper *keeper);

/* The model that counts, and its length; NULL where there is none. */
const uint8_t *fc_store_model(const fc_store *s, uint32_t *n);

/* Has the older model count, where the newer is whole and cannot be used: what comes next takes
   the newer's place. Returns whether there is one. */
bool fc_store_fall_back(fc_store *s);

/* Each returns NULL, or why not. A chunk that came before is no fault: next tells what is due. */
const char *fc_store_begin(fc_store *s, uint32_t length, uint32_t crc);
const char *fc_store_chunk(fc_store *s, uint32_t at, const uint8_t *bytes, uint32_t n);

/* Where all of it came: its bytes, to be looked at before they are kept. */
const uint8_t *fc_store_whole(fc_store *s, const char **why);
const char *fc_store_keep(fc_store *s);

#ifdef __cplusplus
}
#endif
#endif
