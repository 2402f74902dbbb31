/* Kernels of live detection. The NumPy code of the package is the reference. */
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

enum {
    ORDER = 12,      /* of the linear prediction */
    PARTS = 5,       /* newest parts of a look */
    EACH = PARTS + 3, /* features of a look and signal */
    LOOKS_MOST = 8,
    WINDOW_MOST = 1024,
    STEPS = 13,      /* over which the gate judges */
    STEP_MOST = 1 << 16,
    WIDTH_MOST = 1 << 12
};

/* Detector at one rate. */
typedef struct {
    int32_t window, step, looks, search;
    int32_t lengths[PARTS + 1]; /* of the newest parts of a look, ascending, in samples */
    double awake, floor;
    double line[2 * EACH + 1];
} fc_detector;

/* One closing: levels and filters of the channels, and scores of the newest looks. */
typedef struct {
    int32_t fingers;
    const double *mean, *sigma;   /* (fingers,); a sigma of 0 marks a constant channel */
    const double *weights;        /* (fingers, ORDER + 1) */
    const uint8_t *is_judged;     /* (fingers,) */
    double *memory;               /* (fingers, LOOKS_MOST, 2): end of a look, and its score */
} fc_closing;

/* Judge the windows that end at `end`, `end + step`, ... in `past` (samples, fingers), volts.
   `first` is the number of the sample past[0]. onsets (count, fingers): position of the onset in
   `past`, -1 without a contact. */
void fc_judge(const fc_detector *d, const fc_closing *c, const double *past, int64_t first,
              int32_t end, int32_t count, int32_t *onsets);

/* Mark the steps at rest. volts: (steps * step, width), the first `fingers` columns are piezos.
   sums: (STEPS, 2, fingers) of the steps before, of which the last `known` are known. */
void fc_quiet_steps(const double *volts, int32_t width, int32_t fingers, int32_t step,
                    int32_t steps, double *sums, int64_t known, const double *limit,
                    uint8_t *is_quiet);

#endif
