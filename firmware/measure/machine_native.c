#include "machine.h"

#include <stdio.h>

static FILE *from, *to;

int machine_begin(int argc, char **argv)
{
    from = argc == 3 ? fopen(argv[1], "rb") : NULL;
    to = from != NULL ? fopen(argv[2], "wb") : NULL;
    return to != NULL;
}

size_t machine_read(void *into, size_t bytes)
{
    return fread(into, 1, bytes, from);
}

void machine_write(const void *what, size_t bytes)
{
    (void)fwrite(what, 1, bytes, to);
}

void machine_end(void)
{
    (void)fclose(from);
    (void)fclose(to);
}

uint32_t machine_clock(void)
{
    return 0;
}

uint32_t machine_since(uint32_t then)
{
    return then;
}
