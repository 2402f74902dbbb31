/* Numerical kernels of the simulated hand. tests/twin/reference.py is their reference in Python. */
#ifndef FIRSTCONTACT_TWIN_H
#define FIRSTCONTACT_TWIN_H

#include "kernels.h"

/* States of a finger: positions (m) and speeds (m/s), elongations of the Maxwell arms of pad (m)
   and contact (m^1.5), the voltage that the piezo has lost by leakage and the buffer's output (V). */
enum {
    DRIVE_AT, DRIVE_SPEED, PHALANX_AT, PHALANX_SPEED, BOARD_AT, BOARD_SPEED, SKIN_AT, SKIN_SPEED,
    PAD_ARM, FAST_ARM, SLOW_ARM, LEAKED, BUFFER,
    FINGER_STATES,
    STATES = 2 * FINGER_STATES + 4
};

/* Numbers per sample and finger, as mechanics.py unpacks them. */
enum { OUT_BUFFER, OUT_FORCE, OUT_INDENTATION, OUT_FACE, OUT_DRIVE_SPEED, OUTPUTS };

/* State of a sliding pad: last inputs, shear of the object on the pads, and voltages. */
enum {
    LAST_NORMAL, LAST_SPEED, LAST_PULL, SHEAR_AT, SHEAR_SPEED, SLIP_LEAKED, SLIP_BUFFER,
    SLIP_STATES
};

/* State of a patch: offset and speed, 1 if it sticks, position along the object in grains. */
enum { PATCH_AT, PATCH_SPEED, PATCH_STICKS, PATCH_PATH, PATCH_STATES };

enum {
    TAXELS = 6,
    READINGS = 8,     /* readings of a taxel in its sliding mean */
    SCAN = 6,         /* readings of a scan */
    COLUMNS = 2 + 2 * TAXELS + 2,
    TONES_MOST = 8,   /* spectral lines of the motor noise */
    SECTIONS_MOST = 8, /* sections of a filter */
    PLACES = 64       /* drawn friction values of a patch */
};

/* Parameters: the fields of the named tuples in Python, in their order, SI units. A test compares
   the names. All fields are doubles, because Python fills them as an array. */
typedef struct {
    double speed, drive_mass, speed_gain, drive_force, link_stiffness, link_damping, phalanx_mass,
        mount_stiffness, mount_damping, board_mass, pad_stiffness, pad_stiffening,
        pad_arm_stiffness, pad_relaxation, pad_damping, pad_confinement, skin_mass, pad_modulus, tip_radius,
        piezo_volts_per_newton, piezo_time_constant, gain, buffer_cutoff;
} FingerParameters;

typedef struct {
    double modulus, radius, face_mass, bulk_stiffness, bulk_damping, clamp_stiffness,
        clamp_damping, dent_stiffness, arm_share, arm_relaxation, slow_share, slow_relaxation;
} ObjectParameters;

typedef struct {
    double threshold, rise, fall, creep_share, creep, conductance, exponent, leak, resistor, row,
        noise;
} VelostatParameters;

typedef struct {
    double patches, stiffness, mass, damping, ratio, weakening, scatter, grain, coupling;
} SlipParameters;

/* Piece of a pinch to integrate, with the arrays of firstcontact.twin.mechanics.Piece. */
typedef struct {
    FingerParameters finger[2];
    ObjectParameters object;
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
void fc_force_readings(const double *force, const double *shares,
                       const VelostatParameters *p, const double *noise, double dt, double *state,
                       int64_t first, uint16_t *out, int64_t n);

/* Filter scans (n, SCAN) as the device does, to samples `out` (n, COLUMNS). */
void fc_filter(const uint16_t *scans, int64_t n, int64_t *place, int64_t *smoothed,
               int64_t *readings, int64_t *sums, int16_t *out);

void fc_smoothed(const uint16_t *counts, int16_t *out, int64_t n);

void fc_slide(const double *forces, const double *hanging, double mass, double friction, double dt,
              const double *slid, double *out, int64_t n);

/* Simulate the patches of a sliding pad: factors (count, PLACES), patches (count,
   PATCH_STATES), state (SLIP_STATES). */
void fc_slide_patches(const double *normal, const double *speed, const double *pull, double mass,
                      double friction, const SlipParameters *p, const FingerParameters *finger,
                      const double *factors, double *patches, int32_t count, double *state,
                      double *out, int64_t n);

#endif
