/* When a closing begins and ends: the motor has run for 39 ms with nothing held, and rests.

   What firstcontact.contact._gate decides, sample by sample, on the same grid of 3 ms. */
#ifndef FC_GATE_H
#define FC_GATE_H

#include <stdbool.h>
#include <stdint.h>

#include "fc_chain_sizes.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { FC_SENSORS = 2, FC_LOADS = 12 };

typedef enum { FC_STAYS, FC_OPENS, FC_SHUTS } fc_turn;

typedef struct {
    double limit[FC_SENSORS]; /* mean square of a motor at rest, at most */
    double sum[FC_GATE_STEPS][FC_SENSORS], square[FC_GATE_STEPS][FC_SENSORS];
    double load[FC_LOADS], unloaded[FC_LOADS];
    double adding[FC_SENSORS], adding_square[FC_SENSORS], adding_load[FC_LOADS];
    int32_t waiting;         /* samples of a step that is not whole */
    int32_t skipped;         /* samples that still come before the first step */
    uint32_t steps;          /* seen in this stretch */
    uint32_t since, held;    /* step in which the state began, in which something was held */
    bool rested;             /* unloaded is known */
    bool open;
    int8_t state;
} fc_gate;

/* floors: noise of both sensors with nothing moving, V RMS; begun: samples since the stream began,
   more than 0 behind a gap. Steps stay where they are in the stream, as on the host. */
void fc_gate_start(fc_gate *g, const double *floors, uint32_t begun);

/* Takes a sample: volts of both sensors and of all taxels. What it says holds from the next
   sample on. */
fc_turn fc_gate_take(fc_gate *g, const double *volts, const double *loads);

#ifdef __cplusplus
}
#endif
#endif
