/* Checks of what a caller passes. They vanish with NDEBUG, and never change a result.

   On a bare Cortex-M a failed check traps: Teensy's CrashReport then gives the address, which
   `addr2line` turns into file and line. The instruction contains the line, modulo 256, so that the
   compiler does not merge the traps of a function. Elsewhere it is the C library's assert. */
#ifndef FC_ASSERT_H
#define FC_ASSERT_H

#if defined(NDEBUG)
#define FC_ASSERT(condition) ((void)0)
#elif defined(__arm__) && !defined(__linux__)
#define FC_ASSERT(condition) \
    do { \
        if (!(condition)) { \
            __asm__ volatile("udf #%c0" : : "i"(__LINE__ % 256)); \
            __builtin_unreachable(); \
        } \
    } while (0)
#else
#include <assert.h>
#define FC_ASSERT(condition) assert(condition)
#endif

#endif
