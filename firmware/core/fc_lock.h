/* What keeps an interrupt on the same core out. Where nothing interrupts (a POSIX program),
   only the compiler has to be kept in order. */
#ifndef FC_LOCK_H
#define FC_LOCK_H

#define FC_BARRIER() __asm__ volatile("" ::: "memory")

#if defined(__ARM_ARCH) && defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
/* Never nested, and never called with interrupts off. */
#define FC_LOCK() __asm__ volatile("cpsid i" ::: "memory")
#define FC_UNLOCK() __asm__ volatile("cpsie i" ::: "memory")
#else
#define FC_LOCK() FC_BARRIER()
#define FC_UNLOCK() FC_BARRIER()
#endif

#endif
