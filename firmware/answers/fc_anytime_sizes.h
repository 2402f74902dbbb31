/* The any-time network. Written by write_sizes.py: do not edit. */
#ifndef FC_ANYTIME_SIZES_H
#define FC_ANYTIME_SIZES_H

enum {
    FC_LISTENS = 0,
    FC_HEARD = 187,
    FC_LONGEST = 74,
    FC_BEFORE = 197,
    FC_BESIDE = 5,
    FC_HEADS = 4,
    FC_HIDDEN = 256,
    FC_FOUND = 64,
    FC_WIDEST = 320,
    FC_DIRECTIONS = 48,
    FC_LEVELS_MOST = 8
};

#endif
