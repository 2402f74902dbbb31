/* Where in a window a contact began: the split into quiet and loud that explains it best. */
#ifndef FC_ONSET_H
#define FC_ONSET_H

#include <stdint.h>

/* end: one after the window's last sample. Samples from the onset on. */
uint32_t fc_onset(const double *end);

#endif
