/* Predictions on the device: it takes the samples as they are sent, and gives contacts and estimates
   as frames and to the hand itself. It uses the same filter, gate, detector and network as the
   host, sample by sample.

   An estimate is skipped and counted if the next one is due already. No sample is lost by this. */
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
    FC_PAST = 512, /* samples in memory */
    FC_ROOM_TEXT = 240
};

/* Functions and memory of a board; NULL or 0 for those that it lacks. */
typedef struct {
    uint32_t (*clock)(void); /* ns, wrapping */
    /* Fast memory for a copy of the active model, at an address that is a multiple of 8. */
    uint8_t *fast;
    uint32_t fast_bytes;
    /* Callbacks of the hand, called with and without a host. */
    void (*contact)(const fc_contact *contact, bool first);
    void (*estimate)(const fc_told *answer);
} fc_board;

typedef struct {
    fc_device *device;
    fc_board board;
    fc_store store;
    fc_model_taker taker;
    fc_image image;
    bool ready;              /* a model is active */
    char room[FC_ROOM_TEXT]; /* JSON for the descriptor: accepted models and the newest one's fault */
    uint32_t skipped;        /* estimates skipped because they were late, since the start */
    uint32_t told_skipped, told_unheard; /* counts that were last sent */

    bool begun, streamed;
    uint32_t next;           /* number of the next sample */
    uint32_t stream;         /* number of the stream's first sample */
    fc_gate gate;
    fc_detector detector;
    fc_touch touch;
    int16_t past[FC_PAST][FC_FINGERS];

    bool open;               /* a closing runs */
    uint32_t since;          /* its first sample */
    int32_t latched;         /* number of fingers that touch */
    bool touched, second;    /* the first contact is known; the second contact is known */
    bool over, still;        /* the pinch is over; no more estimates follow */
    fc_contact first;
    bool listening;          /* the touch holds the signal so far */
    double baseline;
    int32_t answered;        /* samples of the newest estimate */
    bool passed[FC_LONGEST + 1]; /* skipped estimates, by their number of samples */
} fc_answers;

/* keeper: memory for models. The model that it holds becomes active. */
void fc_answers_init(fc_answers *a, fc_device *device, const fc_keeper *keeper,
                     const fc_board *board);

/* Process all waiting samples. Call it from the main loop. */
void fc_answers_work(fc_answers *a);

#ifdef __cplusplus
}
#endif
#endif
