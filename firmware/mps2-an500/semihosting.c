#include "board.h"

#include <string.h>

enum {
    SYS_OPEN = 0x01,
    SYS_CLOSE = 0x02,
    SYS_READ = 0x06,
    SYS_TIME = 0x11,
    SYS_GET_CMDLINE = 0x15,
    SYS_EXIT_EXTENDED = 0x20,
    READ_BINARY = 1,
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

size_t host_read(const char *path, uint8_t *to, size_t room)
{
    const uint32_t open[] = {(uint32_t)path, READ_BINARY, (uint32_t)strlen(path)};
    const uint32_t file = call(SYS_OPEN, open);
    if (file == UINT32_MAX)
        return 0;
    const uint32_t read[] = {file, (uint32_t)to, (uint32_t)room};
    const uint32_t left = call(SYS_READ, read); /* bytes that were not read */
    const uint32_t close[] = {file};
    (void)call(SYS_CLOSE, close);
    return left <= room ? room - left : 0;
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
