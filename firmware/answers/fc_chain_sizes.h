/* The gate, and the signal of a contact. Written by write_sizes.py: do not edit. */
#ifndef FC_CHAIN_SIZES_H
#define FC_CHAIN_SIZES_H

enum {
    FC_GATE_STEP = 15,
    FC_GATE_STEPS = 13,
    FC_BASELINE = 99,
    FC_GUARD = 10,
    FC_AFTER = 987
};

/* Samples after a contact with which there is an answer. */
#define FC_MOMENTS 10, 15, 20, 25, 30, 35, 39, 44, 49, 54, 59, 64, 69, 74
#define FC_VOLT 0.0001007080078125
#define FC_PIEZO_ZERO 16384.0

#endif
