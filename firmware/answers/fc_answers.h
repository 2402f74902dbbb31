/* Predictions on the device: the chain of firstcontact over the device's own samples.

   Contacts and estimates go to a callback of the board, and to the host if it listens. */
#ifndef FC_ANSWERS_H
#define FC_ANSWERS_H

#include "fc_chain.h"
#include "fc_device.h"
#include "fc_store.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    FC_MEMORY = 32768, /* bytes of work memory for the chain */
    FC_LOADS = FC_FINGERS * FC_TAXELS,
    FC_ROOM_TEXT = 240
};

/* Functions and memory of a board; NULL or 0 for those that it lacks. */
typedef struct {
    uint32_t (*clock)(void); /* ns, wrapping */
    /* Fast memory for a copy of the active model, at an address that is a multiple of 8. */
    uint8_t *fast;
    uint32_t fast_bytes;
    /* Called with each event of the chain, with and without a host. */
    void (*event)(const fc_event *event);
} fc_board;

typedef struct {
    fc_device *device;
    fc_board board;
    fc_store store;
    fc_taker taker;
    fc_image image;
    bool ready;              /* a model is active */
    char room[FC_ROOM_TEXT]; /* JSON for the descriptor: accepted models and the newest one's fault */
    uint32_t skipped;        /* estimates skipped because they were late, since the start */
    uint32_t told_skipped, told_unheard; /* counts that were last sent */
    bool is_timed;           /* the clock was read before an estimate with the newest sample */
    uint32_t then;           /* time at that moment, ns */

    bool streamed;           /* the newest sample was sent to the host, too */
    fc_chain chain;
    uint64_t memory[FC_MEMORY / 8];
} fc_answers;

/* keeper: memory for models. The model that it holds becomes active. */
void fc_answers_init(fc_answers *a, fc_device *device, const fc_keeper *keeper,
                     const fc_board *board);

/* Process all waiting samples. Call it from the main loop. */
void fc_answers_work(fc_answers *a);

/* Set the measured closing speed of this closing, or of the next one, m/s, its relative error, and
   the radius of the object, m (NaN if it is unknown). Return false, and change nothing, if a number
   is impossible. */
bool fc_answers_hint(fc_answers *a, double speed, double error, double radius);

#ifdef __cplusplus
}
#endif
#endif
