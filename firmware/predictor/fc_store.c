#include "fc_store.h"

#include <string.h>

#include "fc_crc32.h"
#include "fc_protocol.h"

static const uint32_t MAGIC = 0x53464331u; /* "1CFS" */

/* Head of a slot: magic, turn, length, CRC of the bytes. */
static bool whole(const fc_memory *k, int slot, uint32_t *turn, uint32_t *length)
{
    const uint8_t *const bytes = k->read(k->own, slot);
    *turn = fc_get_u32(bytes + 4);
    *length = fc_get_u32(bytes + 8);
    return fc_get_u32(bytes) == MAGIC && *length <= k->slot_bytes - FC_SLOT_HEAD
           && fc_crc32(bytes + FC_SLOT_HEAD, *length) == fc_get_u32(bytes + 12);
}

void fc_store_open(fc_store *s, const fc_memory *memory)
{
    memset(s, 0, sizeof *s);
    s->memory = memory;
    s->active = -1;
    for (int slot = 0; slot < 2; slot++) {
        uint32_t turn, length;
        if (!whole(memory, slot, &turn, &length))
            continue;
        if (s->active < 0 || (int32_t)(turn - s->turn) > 0) {
            s->active = slot;
            s->turn = turn;
            s->bytes = length;
        }
    }
}

const uint8_t *fc_store_model(const fc_store *s, uint32_t *n)
{
    *n = s->bytes;
    return s->active < 0 ? NULL : s->memory->read(s->memory->own, s->active) + FC_SLOT_HEAD;
}

static int other(const fc_store *s)
{
    return s->active == 0 ? 1 : 0;
}

bool fc_store_fall_back(fc_store *s)
{
    uint32_t turn, length;
    if (s->active < 0 || !whole(s->memory, other(s), &turn, &length))
        return false;
    s->active = other(s);
    s->turn = turn;
    s->bytes = length;
    return true;
}

const char *fc_store_begin(fc_store *s, uint32_t length, uint32_t crc)
{
    const fc_memory *const k = s->memory;
    s->taking = s->kept = false;
    if (length == 0 || length > k->slot_bytes - FC_SLOT_HEAD)
        return "the model is longer than there is room for";
    if (!k->clear(k->own, other(s)))
        return "the memory for a model cannot be cleared";
    s->taking = true;
    s->length = length;
    s->crc = crc;
    s->next = 0;
    return NULL;
}

const char *fc_store_chunk(fc_store *s, uint32_t at, const uint8_t *bytes, uint32_t n)
{
    const fc_memory *const k = s->memory;
    if (!s->taking)
        return "no model was begun";
    if (at != s->next)
        return NULL;
    if (n == 0 || n > s->length - at)
        return "the model is longer than announced";
    if (!k->write(k->own, other(s), FC_SLOT_HEAD + at, bytes, n)) {
        s->taking = false;
        return "the memory for a model cannot be written";
    }
    s->next += n;
    return NULL;
}

const uint8_t *fc_store_whole(const fc_store *s, const char **why)
{
    const uint8_t *const bytes = s->memory->read(s->memory->own, other(s)) + FC_SLOT_HEAD;
    *why = NULL;
    if (!s->taking)
        *why = "no model was begun";
    else if (s->next != s->length)
        *why = "the model is not whole";
    else if (fc_crc32(bytes, s->length) != s->crc)
        *why = "the model's CRC does not match";
    return *why == NULL ? bytes : NULL;
}

const char *fc_store_keep(fc_store *s)
{
    const fc_memory *const k = s->memory;
    uint8_t head[FC_SLOT_HEAD];
    uint32_t turn, length;
    fc_put_u32(head, MAGIC);
    fc_put_u32(head + 4, s->turn + 1);
    fc_put_u32(head + 8, s->length);
    fc_put_u32(head + 12, s->crc);
    s->taking = false;
    if (!k->write(k->own, other(s), 0, head, sizeof head)
        || !whole(k, other(s), &turn, &length) || turn != s->turn + 1 || length != s->length)
        return "the memory for a model cannot be written";
    s->kept = true;
    s->active = other(s);
    s->turn++;
    s->bytes = s->length;
    return NULL;
}
