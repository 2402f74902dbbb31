/* The hand's own answers: samples as they are sent go in, contacts and estimates come out as
   frames, and to the hand itself. The same filter, gate, detector and network as on the host,
   sample by sample.

   An answer is left out where the next one is due already: no sample waits for it, and none is lost.
   How many were is counted. */
#ifndef FC_ANSWERS_H
#define FC_ANSWERS_H

#include "fc_device.h"
#include "fc_gate.h"
#include "fc_image.h"
#include "fc_store.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    FC_PAST = 512, /* samples that are remembered */
    FC_ROOM_TEXT = 240
};

/* What a board offers; what is NULL or 0 it does without. */
typedef struct {
    uint32_t (*clock)(void); /* ns, wrapping */
    /* Faster memory, at an address that 8 divides, into which the model that answers is copied. */
    uint8_t *fast;
    uint32_t fast_bytes;
    /* What the hand does by itself, whether or not a host listens. */
    void (*contact)(const fc_contact *contact, bool first);
    void (*estimate)(const fc_told *answer);
} fc_board;

typedef struct {
    fc_device *device;
    fc_board board;
    fc_store store;
    fc_model_taker taker;
    fc_image image;
    bool ready;              /* a model answers */
    char room[FC_ROOM_TEXT]; /* JSON for the descriptor: what models are taken, what of the newest
                                one is wrong */
    uint32_t skipped;        /* answers left out because they were late, since the start */
    uint32_t told_skipped, told_unheard; /* what was told of it */

    bool begun, streamed;
    uint32_t next;           /* number of the sample that comes next */
    uint32_t stream;         /* of the first sample of the stream */
    fc_gate gate;
    fc_detector detector;
    fc_touch touch;
    int16_t past[FC_PAST][FC_FINGERS];

    bool open;               /* a closing goes on, */
    uint32_t since;          /* from this sample on */
    int32_t latched;         /* fingers that touch */
    bool touched, second;    /* the first contact is known, the second is */
    bool over, still;        /* the pinch is over; no more answers come */
    fc_contact first;
    bool listening;          /* the touch has its signal so far */
    double baseline;
    int32_t answered;        /* samples of the newest answer */
    bool passed[FC_LONGEST + 1]; /* answers from so many samples that were left out */
} fc_answers;

/* keeper: what keeps models; the one that it has answers from now on. */
void fc_answers_init(fc_answers *a, fc_device *device, const fc_keeper *keeper,
                     const fc_board *board);

/* Works on all samples that wait; belongs to the main loop. */
void fc_answers_work(fc_answers *a);

#ifdef __cplusplus
}
#endif
#endif
