#define _POSIX_C_SOURCE 200809L

#include "models.h"

#include <fcntl.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static uint8_t *at(void *own, int slot)
{
    return (uint8_t *)own + (size_t)slot * MODEL_ROOM;
}

static const uint8_t *read_slot(void *own, int slot)
{
    return at(own, slot);
}

static bool clear(void *own, int slot)
{
    memset(at(own, slot), 0xff, MODEL_ROOM);
    return true;
}

static bool write_slot(void *own, int slot, uint32_t place, const uint8_t *bytes, uint32_t n)
{
    /* The head is written last, once the other bytes are on the disk. */
    const bool head = place == 0;
    if (head && msync(own, 2 * MODEL_ROOM, MS_SYNC) != 0)
        return false;
    memcpy(at(own, slot) + place, bytes, n);
    return !head || msync(own, 2 * MODEL_ROOM, MS_SYNC) == 0;
}

int models_open(fc_memory *memory, const char *path)
{
    const int fd = open(path, O_RDWR | O_CREAT, 0666);
    if (fd < 0 || ftruncate(fd, 2 * MODEL_ROOM) < 0)
        return -1;
    void *const bytes = mmap(NULL, 2 * MODEL_ROOM, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    (void)close(fd);
    if (bytes == MAP_FAILED)
        return -1;
    memory->own = bytes;
    memory->slot_bytes = MODEL_ROOM;
    memory->read = read_slot;
    memory->clear = clear;
    memory->write = write_slot;
    return 0;
}
