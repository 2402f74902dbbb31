/* The detector. Written by write_sizes.py: do not edit. */
#ifndef FC_DETECTOR_SIZES_H
#define FC_DETECTOR_SIZES_H

#define FC_JUDGE_HEADER "fc_judge_loudness.h"
#define FC_CHANNELS 2
#define fc_judge_constants (*fc_judge_loaded)

enum {
    FC_WINDOW = 105,
    FC_STEP = 2,
    FC_STEADY = 197,
    FC_SEARCH = 44,
    FC_RING = 128,
    FC_LOOK = 99,
    FC_LOOKS = 4,
    FC_QUIET = 69
};

#endif
