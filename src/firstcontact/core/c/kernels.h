/* Kernels of live detection and estimation. The NumPy code of the package is the reference. */
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
    WIDTH_MOST = 1 << 12,
    FEATURES = 14,   /* of a contact */
    TRAITS = FEATURES + 2,
    BESIDE = 5,
    POINTS = 74,     /* of a waveform */
    INPUTS = 3 * POINTS + FEATURES + BESIDE,
    HEADS = 4,
    COMPONENTS = 3,
    UNITS_MOST = 512, /* of a layer */
    LEVELS_MOST = 64,
    HALF = 1024,      /* half the numbers of the Fourier transform */
    LINES = 400,      /* of the motor's spectrum */
    SMOOTH = 61,
    FARTHEST_SHIFT = 88,
    KNOWN = FEATURES + 1, /* inputs of the regression */
    KNOWN_MOST = 256
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

typedef struct {
    int32_t inputs, outputs;
    const float *weight, *bias; /* (inputs, outputs), (outputs,) */
} fc_layer;

/* Regression on the pinches of a rig; n is 0 without one. Arrays have a first axis of stages. */
typedef struct {
    int32_t n;
    const double *mean, *sd;       /* (KNOWN,) */
    const double *known, *squares; /* (KNOWN, n), (n,) */
    const double *weights, *inverse; /* (n,), (n, n) */
    const double *scale;           /* () */
    double centre, unit;
} fc_regression;

/* Network, the same for all rigs. */
typedef struct {
    int32_t stages;
    const float *mean, *sd;  /* of the inputs */
    fc_layer query1, query2, body1, body2, body3, answer;
    const double *usual, *whitening, *limit, *gain; /* of the traits: (stages, TRAITS), ... */
    const double *factors;   /* half widths in spreads, (stages,) */
    float absent[3 * POINTS]; /* scaled inputs of samples that are not there yet */
    float rest[UNITS_MOST];   /* query1 of these alone */
} fc_network;

/* Rig that a network is conditioned on. */
typedef struct {
    const fc_network *network; /* that it was made for */
    int32_t levels;
    double level, sign;
    const float *along;         /* (stages, body1.outputs): the part of body1 that the rig fixes */
    const float *keys, *values; /* (stages, HEADS, levels, width) */
    fc_regression regression;
} fc_rig;

/* Spectrum of a motor on an axis of ln(frequency), at one rate. */
typedef struct {
    int32_t heard;                /* samples */
    double turn[2 * HALF + HALF / 2]; /* sin of 2 pi k / (2 * HALF) */
    double part[LINES], fade[2 * HALF];
    int32_t cell[LINES];
} fc_ear;

/* Shift of the motor's spectrum against a reference, and the correlation there. */
void fc_listen(const fc_ear *e, const double *reference, const float *signal, int32_t *shift,
               double *alike);

typedef struct {
    double value, low, high, half_width;
    bool is_out_of_range, is_finite;
} fc_estimate;

/* Compute what does not depend on the contact. */
void fc_network_prepare(fc_network *n);

/* Predict from `valid` samples after the contact, V. `noise` is the trait of the signal before. */
void fc_predict(const fc_network *n, const fc_rig *r, const float *signal, int32_t valid,
                int32_t stage, const double *beside, double noise, fc_estimate *out);

#endif
