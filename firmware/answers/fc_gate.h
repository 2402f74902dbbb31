/* Gate: begin and end of a closing. It begins once the motor has run for 39 ms with no object held,
   and ends when the motor rests.

   The gate decides as firstcontact.contact._gate does, sample by sample, on the same 3 ms grid. */
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
    double limit[FC_SENSORS]; /* highest mean square of a motor at rest */
    double sum[FC_GATE_STEPS][FC_SENSORS], square[FC_GATE_STEPS][FC_SENSORS];
    double load[FC_LOADS], unloaded[FC_LOADS];
    double adding[FC_SENSORS], adding_square[FC_SENSORS], adding_load[FC_LOADS];
    int32_t waiting;         /* samples in the unfinished step */
    int32_t skipped;         /* samples to skip before the first step */
    uint32_t steps;          /* steps since the start or the last gap */
    uint32_t since, held;    /* step in which the state began; last step with a load */
    bool rested;             /* unloaded is known */
    bool open;
    int8_t state;
} fc_gate;

/* floors: noise of both sensors while nothing moves, V RMS. begun: samples since the stream began,
   above 0 after a gap. Steps keep their grid in the stream, as on the host. */
void fc_gate_start(fc_gate *g, const double *floors, uint32_t begun);

/* Take a sample: volts of both sensors and of all taxels. The result holds from the next sample
   on. */
fc_turn fc_gate_take(fc_gate *g, const double *volts, const double *loads);

#ifdef __cplusplus
}
#endif
#endif
