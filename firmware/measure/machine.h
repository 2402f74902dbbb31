/* What the measuring program needs of the machine that it runs on. */
#ifndef MACHINE_H
#define MACHINE_H

#include <stddef.h>
#include <stdint.h>

/* Its two arguments: a file to read and a file to write. 0 where they cannot be opened. */
int machine_begin(int argc, char **argv);
size_t machine_read(void *to, size_t bytes); /* bytes read, fewer at the end */
void machine_write(const void *from, size_t bytes);
void machine_end(void);

/* A clock, and the instructions that were run since it said so; 0 where none are counted. */
uint32_t machine_clock(void);
uint32_t machine_since(uint32_t then);

#endif
