/* Functions of the machine that runs a measuring program. */
#ifndef MACHINE_H
#define MACHINE_H

#include <stddef.h>
#include <stdint.h>

/* Open the files of the two arguments, to read and to write. Return 0 on failure.
   argc  in, as main gets it
   argv  in, out: likewise */
int machine_begin(int argc, char **argv);

/* Read or write bytes. Return the number of bytes read, which is smaller at the end.
   to     out, (bytes)
   from   in, (bytes)
   bytes  in */
size_t machine_read(void *to, size_t bytes);
void machine_write(const void *from, size_t bytes);

/* Close the files. */
void machine_end(void);

/* Return a time stamp, and the instructions since a time stamp; 0 if nothing counts them.
   then  in, a time stamp */
uint32_t machine_clock(void);
uint32_t machine_since(uint32_t then);

#endif
