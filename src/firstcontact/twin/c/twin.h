/* Numerical kernels of the simulated hand. tests/twin/reference.py is their reference in Python. */
#ifndef FIRSTCONTACT_TWIN_H
#define FIRSTCONTACT_TWIN_H

#include "kernels.h"

enum {
    FINGER_STATES = 12,
    STATES = 2 * FINGER_STATES + 4,
    OUTPUTS = 5,      /* numbers per sample and finger */
    FINGER = 22,      /* parameters of a finger, in the order of FingerParameters */
    OBJECT = 10,      /* parameters of an object, in the order of ObjectParameters */
    SHEET = 11,       /* parameters of a force array, in the order of VelostatParameters */
    SLIP = 9,         /* parameters of a sliding pad, in the order of SlipParameters */
    TAXELS = 6,
    READINGS = 8,     /* readings of a taxel in its sliding mean */
    SCAN = 6,         /* readings of a scan */
    COLUMNS = 2 + 2 * TAXELS + 2,
    TONES_MOST = 8,   /* spectral lines of the motor noise */
    SECTIONS_MOST = 8, /* sections of a filter */
    PLACES = 64       /* drawn friction values of a patch */
};

/* Piece of a pinch to integrate, with the arrays of firstcontact.twin.mechanics.Piece. */
typedef struct {
    double finger[2][FINGER], object[OBJECT];
    const double *stiffness, *touch, *times, *noise, *speeds;
    int64_t samples, points, rows; /* lengths of times, noise and speeds */
    double noise_dt, motor_force, back_damping, full_speed, limit, calm;
    int64_t substeps, calm_steps;
    double *x, *gap, *touched, *out;
    int64_t taken; /* result: number of samples computed */
} fc_pinch;

/* Integrate pieces of different pinches, several side by side. */
void fc_integrate(fc_pinch *pinches, int32_t count);

/* Add spectral lines to `out`. `lines` and `turns` hold count + 1 complex numbers. The last line
   modulates the others. */
void fc_tones(double (*lines)[2], const double (*turns)[2], const double *amplitudes,
              const double *depth, int32_t count, double *out, int64_t n);

/* Filter x by second-order sections (count, 6). */
void fc_filtered(const double *sections, int32_t count, const double *x, double *out, int64_t n);

void fc_piezo_readings(const double *volts, uint16_t *out, int64_t n);

/* Compute the readings of one force array with state (2, TAXELS). Sample i reads taxel `first` + i
   modulo 6. */
void fc_force_readings(const double *force, const double *shares, const double *p,
                       const double *noise, double dt, double *state, int64_t first, uint16_t *out,
                       int64_t n);

/* Filter scans (n, SCAN) as the device does, to samples `out` (n, COLUMNS). */
void fc_filter(const uint16_t *scans, int64_t n, int64_t *place, int64_t *smoothed,
               int64_t *readings, int64_t *sums, int16_t *out);

void fc_smoothed(const uint16_t *counts, int16_t *out, int64_t n);

void fc_slide(const double *forces, const double *hanging, double mass, double friction, double dt,
              const double *slid, double *out, int64_t n);

/* Simulate the patches of a sliding pad: factors (count, PLACES), patches (count, 4), state (7). */
void fc_slide_patches(const double *normal, const double *speed, const double *pull, double mass,
                      double friction, const double *p, const double *finger, const double *factors,
                      double *patches, int32_t count, double *state, double *out, int64_t n);

#endif
