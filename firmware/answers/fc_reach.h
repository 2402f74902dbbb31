/* How large the numbers of a network can become, whatever is touched. */
#ifndef FC_REACH_H
#define FC_REACH_H

#include "fc_anytime.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Whether no number of it can pass 1e30: then none is infinite or no number at all, and what is
   rounded to whole numbers fits into them. firstcontact.export._reach refuses the same. */
bool fc_reach_is_bounded(const fc_anytime *m);

#ifdef __cplusplus
}
#endif
#endif
