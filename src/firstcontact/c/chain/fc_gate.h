/* Gate that finds closings: times in which the motor runs and the hand holds no object.

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". */
#ifndef FC_GATE_H
#define FC_GATE_H

#include <stdbool.h>
#include <stdint.h>

enum {
    FC_CHANNELS_MOST = 6,   /* vibration channels: one per finger, and one without a finger */
    FC_TAXELS_MOST = 64,    /* force channels */
    FC_GATE_STEPS = 13      /* steps over which rest and the settling of the motor are judged */
};

/* The motor runs if the RMS of a step exceeds the noise at rest by this factor. */
#define FC_RUNNING 1.4

typedef enum { FC_GATE_STAYS, FC_GATE_OPENS, FC_GATE_SHUTS, FC_GATE_SHUTS_AND_OPENS } fc_gate_turn;

/* What the gate knows of the motor: nothing since a gap; at rest; starting; running. */
typedef enum { FC_GATE_LOST, FC_GATE_REST, FC_GATE_STARTING, FC_GATE_OPEN } fc_gate_state;

/* Sums of each channel over a step. */
typedef struct {
    double volts[FC_CHANNELS_MOST], squares[FC_CHANNELS_MOST]; /* V and V^2 */
} fc_step;

typedef struct {
    int32_t channels, taxels;
    int32_t step;              /* length of a step, samples */
    int32_t rearm;             /* samples after a contact by hand until the gate can open again */
    bool is_by_hand;           /* a person moves the sensor, and the gate opens at rest */
    double limit[FC_CHANNELS_MOST]; /* largest power at rest, V^2 */

    fc_gate_state state;
    bool is_open;
    int64_t steps, since, held; /* step counts: so far, at the start of the state, at the last load */
    int32_t refused;           /* number of motor starts under load since the gate last opened */
    int64_t grid;              /* number of the first sample of the step in progress */
    int32_t skipped;           /* samples to skip until this step begins */
    int32_t waiting;           /* samples of this step so far */
    bool is_due;               /* after a contact by hand, the gate opens at sample `due` */
    int64_t due;
    int32_t newest;            /* position of the newest step in the sums */
    fc_step sums[FC_GATE_STEPS]; /* of the newest steps */
    double load_sums[FC_TAXELS_MOST];
    bool has_unloaded;
    double unloaded[FC_TAXELS_MOST];  /* lowest voltage of each taxel at rest */
} fc_gate;

/* Restart after a gap or in a new epoch.
   g              in, out
   first          in, number of the next sample
   is_same_epoch  in */
void fc_gate_restart(fc_gate *g, int64_t first, bool is_same_epoch);

/* Report a contact.
   g       in, out
   sample  in, number of its first sample */
void fc_gate_touched(fc_gate *g, int64_t sample);

/* Process one sample. The closing opens or shuts after it.
   g          in, out
   vibration  in, V, (channels)
   loads      in, V, (taxels), or NULL without taxels */
fc_gate_turn fc_gate_take(fc_gate *g, const double *vibration, const double *loads);

#endif
