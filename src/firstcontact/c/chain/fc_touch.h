/* Signal of one contact, and the stiffness that a model predicts from it.

   A stage is a number of samples after the contact for which the model has its own description of a
   rig. Traits are the numbers that decide whether a contact resembles those of the training.

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". */
#ifndef FC_TOUCH_H
#define FC_TOUCH_H

#include <stdbool.h>
#include <stdint.h>

#include "fc_network.h"
#include "fc_pitch.h"
#include "fc_svm.h"

enum {
    FC_POINTS = 74,         /* most samples after the contact that the network uses */
    FC_MOMENTS_MOST = 80,   /* moments after a contact at which a model predicts */
    FC_BEFORE_MOST = 256,   /* samples before the contact */
    FC_FEATURES = 14,       /* features of the signal after the contact */
    FC_TRAITS = FC_FEATURES + 2, /* features, noise before the contact, and share of repeated samples */
    FC_HINTS = 5,           /* inputs for closing speed and radius */
    FC_INPUTS = 3 * FC_POINTS + FC_FEATURES + FC_HINTS,
    FC_KNOWN = FC_FEATURES + 1, /* inputs of the regression: the features and the closing speed */
    FC_PINCHES_MOST = 48,   /* pinches of the regression */
    FC_TRIANGLE = FC_TRAITS * (FC_TRAITS + 1) / 2,
    FC_RIGS_MOST = 6
};

/* Numbers that the training in Python reads, too, through `constants` of touch_module.c. */
#define FC_BELIEVED 0.5     /* correlation of the motor's spectrum above which its pitch is trusted */
#define FC_TIP 0.010        /* radius of a fingertip, m */
#define FC_LARGEST 10.0     /* largest magnitude of the regression's inputs, in which 1 is usual */
#define FC_LENGTH 2.0       /* length scale of its smooth part, standard deviations of an input */
#define FC_LINEAR 1.0       /* variances of its linear part and of the noise; the others are 1 */
#define FC_NOISE 0.3

/* Traits of a contact. The first FC_FEATURES are inputs of the network. Times count samples. */
enum {
    FC_TRAIT_PEAK, FC_TRAIT_RISE,   /* largest sample and largest step, ln(relative to the level) */
    FC_TRAIT_PEAK_AT,               /* time of the peak */
    FC_TRAIT_BELOW_TENTH, FC_TRAIT_BELOW_HALF, /* samples up to the peak below 10 % and 50 % of it */
    FC_TRAIT_WIDTH,                 /* samples above half the peak */
    FC_TRAIT_ROUGHNESS,             /* energy of the steps, ln(relative to that of the signal) */
    FC_TRAIT_DIP, FC_TRAIT_DIP_AT,  /* lowest sample after the peak, relative to it, and its time */
    FC_TRAIT_POWER,                 /* root mean square, ln(relative to the level) */
    FC_TRAIT_CENTROID,              /* mean time of the energy */
    FC_TRAIT_LENGTH,                /* number of samples, constant at a stage */
    FC_TRAIT_LAST, FC_TRAIT_TREND,  /* last sample, relative to the peak, and its recent change */
    FC_TRAIT_NOISE,                 /* noise before the contact, ln(relative to the level) */
    FC_TRAIT_REPEATS                /* share of repeated samples */
};

/* Inputs of the network for what is known of the closing and the object. */
enum {
    FC_HINT_SPEED, FC_HINT_HAS_SPEED, /* ln(relative to the rig's usual speed); 1 if it is trusted */
    FC_HINT_ALIKE,                  /* correlation of the motor's spectrum; 1 for a measured speed */
    FC_HINT_HAS_RADIUS, FC_HINT_CURVATURE /* 1 if the radius is known; curvature of the object */
};

/* Gaussian process fitted to a rig's own pinches, at one stage. */
typedef struct {
    const float *mean, *each; /* mean, and 1 / standard deviation, of the inputs (FC_KNOWN) */
    const float *known;       /* standardised inputs of the rig's pinches (FC_KNOWN, n) */
    const float *weights;     /* (n,) */
    const float *factor;      /* rows of the inverse Cholesky factor, lower triangle */
    double scale;             /* factor on the spread */
    double offset;            /* Shore A by which the average reads blocks too hard */
} fc_process;

/* Whole numbers of a rig, as in the image. */
typedef struct {
    int32_t finger;           /* number of the finger; -1 for all fingers without a rig of their own */
    int32_t has_level;        /* 1 if the rig has pinches of known Shore A */
    int32_t has_pitch, has_speeds;
    int32_t pinches;          /* number of pinches of the regression; 0 without one */
    int32_t unused;
} fc_rig_counts;

/* Other numbers of a rig, as in the image. */
typedef struct {
    double level, sign;       /* typical peak of a contact, V, and sign of the largest swing */
    double usual_pitch;       /* median shift of the rig's contacts, ln(frequency) */
    double usual_speed, speed_spread, heard_error; /* heard_error: error of the pitch, 0 if it is useless */
    double centre, unit;      /* mean and scale of the Shore A of the regression's pinches */
} fc_rig_scales;

/* Rig that a model is conditioned on. */
typedef struct {
    const fc_rig_counts *counts;
    const fc_rig_scales *scales;
    const float *reference;   /* spectrum of the motor (FC_LINES) */
    const float *rig_terms;   /* (stages, rank) */
    const uint8_t *processes; /* fc_process of each stage, one after the other */
} fc_rig;

/* Kinds of models. */
enum {
    FC_MODEL_NONE,
    FC_MODEL_NETWORK,
    FC_MODEL_PROGRAM,         /* the calling program predicts */
    FC_MODEL_SVM              /* one support vector machine for each moment */
};

/* Lengths in samples and numbers of parts of a model, as in the image. Only a model of the kind
   FC_MODEL_NETWORK has guard, baseline, stages and rigs. */
typedef struct {
    int32_t before;           /* signal before the contact */
    int32_t guard, baseline;  /* baseline: length of the quiet signal that ends `guard` before the contact */
    int32_t moments, stages, rigs;
    int32_t pitch_samples;    /* see fc_pitch */
    int32_t lookahead;        /* samples after a moment that the model's filter needs */
} fc_model_sizes;

/* Model that predicts at any time after a contact. Only a model of the kind FC_MODEL_NETWORK has the
   fields from `stage` on. */
typedef struct {
    int32_t kind;
    const fc_model_sizes *sizes;
    const int32_t *moment;    /* samples after the contact that each prediction needs, with lookahead */
    fc_svm svm[FC_SVMS_MOST]; /* of a model of the kind FC_MODEL_SVM, one for each moment */
    const int32_t *stage;     /* stages, ascending */
    fc_network network;
    const double *factors;    /* half width of an interval, in spreads (stages) */
    const float *familiar;    /* (stages, FC_TRAITS): mean traits of the training */
    const float *whitening;   /* (stages, FC_TRIANGLE): lower triangles */
    const double *limit;      /* distance from the mean above which a contact is out of range (stages) */
    fc_pitch pitch;
    double pitch_step;        /* distance of two points of the spectrum, ln(frequency) */
    fc_rig rig[FC_RIGS_MOST]; /* (rigs) */
} fc_model;

/* Stiffness in the unit of the model's training: Shore A, or as the header of an export says. */
typedef struct {
    float value, low, high, half_width, spread;
    bool is_out_of_range;
} fc_estimate;

/* Measured closing speed, m/s (0 if unknown), and its relative error (0 if exact). Radius of the
   object, m; infinite for a flat object, NaN if unknown. */
typedef struct {
    double speed, error, radius;
} fc_hints;

typedef struct {
    const fc_model *model;
    const fc_rig *rig;
    double hints[FC_HINTS];
    double noise;             /* noise before the contact, a trait */
    int32_t samples;
    double volts[FC_POINTS];  /* sign chosen so that the first swing is positive */
    float scaled[FC_POINTS];  /* signed logarithm of the samples, relative to the level */
    float shift, correlation; /* pitch of the motor */
} fc_touch;

/* Memory for one prediction. The spectrum and the network are never needed at the same time. */
typedef union {
    float spectrum[FC_TURN + FC_LINES];
    fc_network_room network;
} fc_touch_room;

/* Return the rig of a finger, or NULL if the model has none for it.
   m       in
   finger  in, number of the finger; -1 for none */
const fc_rig *fc_touch_rig(const fc_model *m, int32_t finger);

/* Begin a contact.
   t       out
   m       in, which must outlive t
   finger  in, number of the finger; -1 for none
   before  in, V, signal before the contact minus the baseline, (m->sizes->before)
   room    out, room for work */
void fc_touch_begin(fc_touch *t, const fc_model *m, int32_t finger, const float *before,
                    fc_touch_room *room);

/* Set closing speed and radius, after fc_touch_begin.
   t      in, out
   hints  in, m/s and m */
void fc_touch_hint(fc_touch *t, const fc_hints *hints);

/* Add a sample after the contact. Samples after the first FC_POINTS change nothing.
   t      in, out
   volts  in, V, sample minus the baseline */
void fc_touch_take(fc_touch *t, float volts);

/* Compute the traits of a contact. Return its peak, V.
   t       in
   n       in, samples after the contact, from 2 to t->samples
   traits  out, (FC_TRAITS) */
double fc_touch_traits(const fc_touch *t, int32_t n, double *traits);

/* Compute the inputs of the network, and the traits.
   t       in
   n       in, samples after the contact, from 2 to t->samples
   inputs  out, (FC_INPUTS)
   traits  out, (FC_TRAITS) */
void fc_touch_inputs(const fc_touch *t, int32_t n, float *inputs, double *traits);

/* Predict from a contact. Return false if the result is not finite; then `out` is unchanged.
   t     in
   n     in, samples after the contact, from 2 to t->samples
   room  out, room for work
   out   out, Shore A */
bool fc_touch_predict(const fc_touch *t, int32_t n, fc_touch_room *room, fc_estimate *out);

/* Predict with the regression of the rig alone. The rig must have pinches.
   t              in
   stage          in, index of fc_touch_stage
   traits         in, (FC_TRAITS)
   value, spread  out, Shore A */
void fc_process_predict(const fc_touch *t, int32_t stage, const double *traits, double *value,
                        double *spread);

/* Return the index of the stage for a number of samples.
   m  in
   n  in, samples after the contact */
int32_t fc_touch_stage(const fc_model *m, int32_t n);

#endif
