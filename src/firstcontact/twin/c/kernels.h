/* Options of the compiler for the kernels. */
#ifndef FIRSTCONTACT_KERNELS_H
#define FIRSTCONTACT_KERNELS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if defined(__FAST_MATH__)
#error "compile without -ffast-math: the results would differ from NumPy's"
#endif

/* One binary for all processors of a kind. With -ffp-contract=off all versions round alike. */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__GLIBC__)
#define WIDE __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define WIDE
#endif

/* Function that is compiled anew in each of these versions. */
#if defined(__GNUC__)
#define INLINE static inline __attribute__((always_inline))
#else
#define INLINE static inline
#endif

/* Before a loop over the lanes of a vector: it becomes vector instructions, not repeated code. */
#if defined(__GNUC__) && !defined(__clang__)
#define LANEWISE _Pragma("GCC unroll 1")
#else
#define LANEWISE
#endif

#endif
