/* Lock against interrupts on the same core. A POSIX program has none and needs only a compiler
   barrier. */
#ifndef FC_LOCK_H
#define FC_LOCK_H

#define FC_BARRIER() __asm__ volatile("" ::: "memory")

#if defined(__ARM_ARCH) && defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
/* Do not nest these, and call them only with interrupts on. */
#define FC_LOCK() __asm__ volatile("cpsid i" ::: "memory")
#define FC_UNLOCK() __asm__ volatile("cpsie i" ::: "memory")
#else
#define FC_LOCK() FC_BARRIER()
#define FC_UNLOCK() FC_BARRIER()
#endif

#endif
