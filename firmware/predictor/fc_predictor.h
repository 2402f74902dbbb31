/* Predictions on the device: the chain runs on the device's own samples.

   Contacts and estimates go to a callback of the board, and to the host if it streams. Call these
   functions from the main loop, in which the callback runs, too.

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". */
#ifndef FC_PREDICTOR_H
#define FC_PREDICTOR_H

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

/* Functions and memory of a board. Each can be NULL or 0. */
typedef struct {
    uint32_t (*clock)(void); /* time, ns, which wraps */
    /* Fast memory for a copy of the active model, at an address that is a multiple of 8. */
    uint8_t *fast;
    uint32_t fast_bytes;
    /* Receive each event of the chain, with and without a host.
       event  in, valid until this returns */
    void (*event)(const fc_event *event);
} fc_board;

typedef struct {
    fc_device *device;
    fc_board board;
    fc_store store;
    fc_receiver receiver;
    fc_image image;
    bool ready;              /* true if a model is active */
    char room[FC_ROOM_TEXT]; /* JSON for the descriptor: accepted models, fault of the newest */
    uint32_t skipped;        /* estimates skipped because they were late, since the start */
    uint32_t sent_skipped, sent_unheard; /* counts as they were last sent */
    bool is_timed;           /* the newest sample led to an estimate */
    uint32_t then;           /* time before this estimate, ns */

    bool streamed;           /* the newest sample was also sent to the host */
    fc_chain chain;
    uint64_t memory[FC_MEMORY / 8];
} fc_predictor;

/* Set up predictions. The model in `memory`, if any, becomes active.
   a       out
   device  in, out: its samples must have been copied by fc_device_copy_samples
   memory  in, which must outlive the predictor
   board   in, copied */
void fc_predictor_init(fc_predictor *a, fc_device *device, const fc_memory *memory,
                     const fc_board *board);

/* Process all waiting samples.
   a  in, out */
void fc_predictor_work(fc_predictor *a);

/* Set the closing speed of this closing, or of the next one, and the radius of the object. Return
   false and change nothing if a number is impossible.
   a       in, out
   speed   in, m/s, from 0 to 100; 0 if unknown
   error   in, relative error of the speed, from 0 to 1e9
   radius  in, m, at least 1e-6; infinite for a flat object, NaN if unknown */
bool fc_predictor_hint(fc_predictor *a, double speed, double error, double radius);

#ifdef __cplusplus
}
#endif
#endif
