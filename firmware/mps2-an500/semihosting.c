#include "board.h"

#include <string.h>

enum {
    SYS_OPEN = 0x01,
    SYS_CLOSE = 0x02,
    SYS_WRITE = 0x05,
    SYS_READ = 0x06,
    SYS_TIME = 0x11,
    SYS_GET_CMDLINE = 0x15,
    SYS_EXIT_EXTENDED = 0x20,
    READ_BINARY = 1,
    WRITE_BINARY = 5,
    APPLICATION_EXIT = 0x20026
};

static uint32_t call(uint32_t operation, const void *block)
{
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = block;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

void host_arguments(char *text, size_t room)
{
    uint32_t block[] = {(uint32_t)text, (uint32_t)room};
    if (call(SYS_GET_CMDLINE, block) != 0)
        text[0] = '\0';
}

int32_t host_open(const char *path, bool writing)
{
    const uint32_t open[] = {(uint32_t)path, writing ? WRITE_BINARY : READ_BINARY,
                             (uint32_t)strlen(path)};
    return (int32_t)call(SYS_OPEN, open);
}

size_t host_take(int32_t file, void *to, size_t bytes)
{
    const uint32_t read[] = {(uint32_t)file, (uint32_t)to, (uint32_t)bytes};
    const uint32_t left = call(SYS_READ, read); /* bytes that were not read */
    return left <= bytes ? bytes - left : 0;
}

void host_put(int32_t file, const void *from, size_t bytes)
{
    const uint32_t write[] = {(uint32_t)file, (uint32_t)from, (uint32_t)bytes};
    (void)call(SYS_WRITE, write);
}

void host_close(int32_t file)
{
    const uint32_t close[] = {(uint32_t)file};
    (void)call(SYS_CLOSE, close);
}

size_t host_read(const char *path, uint8_t *to, size_t room)
{
    const int32_t file = host_open(path, false);
    if (file < 0)
        return 0;
    const size_t n = host_take(file, to, room);
    host_close(file);
    return n;
}

uint32_t host_seconds(void)
{
    return call(SYS_TIME, NULL);
}

void board_exit(int code)
{
    const uint32_t block[] = {APPLICATION_EXIT, (uint32_t)code};
    (void)call(SYS_EXIT_EXTENDED, block);
    for (;;) {
    }
}
