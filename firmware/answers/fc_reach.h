/* Bounds on the numbers of a network for any signal. */
#ifndef FC_REACH_H
#define FC_REACH_H

#include "fc_anytime.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Return true if no number of the network can exceed 1e30. Then none is infinite or NaN, and rounded
   numbers fit their integers. firstcontact.export._reach refuses the same networks. */
bool fc_reach_is_bounded(const fc_anytime *m);

#ifdef __cplusplus
}
#endif
#endif
