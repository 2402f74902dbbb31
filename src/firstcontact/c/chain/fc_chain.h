/* The chain: samples in, events out. It finds closings, contacts and their stiffness, one sample
   after the other. It allocates nothing and does no input or output.

   Computer, hand and exported library run this code, and get the same bits.

   Interrupts: run the whole chain in one context. Let an interrupt only store samples in a queue.
   fc_chain_take can compute an estimate, which takes far longer than one sample. The chain has no
   locks.
   Calls of `emit`: fc_chain_take, fc_chain_restart and fc_chain_finish call it before they return, in
   the context of the caller. The event is valid until `emit` returns. `emit` can call fc_chain_hint,
   but no other function that changes the chain.
   Stack: 4 KB, and what the functions of fc_program need. Measured for a Cortex-M7 with gcc -O2,
   -fstack-usage and -fcallgraph-info=su, as the sum of the deepest path of calls. That path leads to
   fc_spectrum, which needs 3.3 KB. The chain itself and its memory lie where the caller puts them.
   Arguments: comments name each one with its direction and unit. A pointer can be NULL only if they
   say "or NULL". Where an argument is wrong, a check of fc_assert.h stops the program, unless it was
   compiled with NDEBUG.
   No contact appears: look at `is_open` first. If it stays false, look at `gate.state`,
   `stream.floors` (V) and the unit of the samples (V). If it is true, look at `detector.is_settled`
   and `detector.sigma`, then at `next`, which must grow without restarts. An event
   FC_CONTACT_WITHDRAWN means that the signal did not look like a pushing finger. */
#ifndef FC_CHAIN_H
#define FC_CHAIN_H

#include "fc_image.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Kinds of events. */
enum {
    FC_CLOSING_BEGAN = 1,   /* sample: first sample of the closing */
    FC_CONTACT_FOUND,       /* sample: first sample of the contact */
    FC_CONTACT_WITHDRAWN,   /* sample: first sample of the first contact */
    FC_ESTIMATED,           /* sample: first sample of the first contact */
    FC_NOT_ESTIMATED,       /* the contact gets no estimate, see the reason */
    FC_SKIPPED,             /* estimate left out, because a later one was due */
    FC_CLOSING_ENDED        /* sample: first sample after the closing; see the reason */
};

/* Flags of events. */
enum {
    FC_IS_FIRST = 1,        /* first contact of a closing */
    FC_IS_FINAL = 2,        /* repeats the estimate of a contact that no later event replaces */
    FC_IS_OUT_OF_RANGE = 4
};

/* Reasons of FC_CLOSING_ENDED and FC_NOT_ESTIMATED. */
enum {
    FC_DONE,                /* the time for estimates after the first contact is over */
    FC_RESTED,              /* the motor rests */
    FC_LOST,                /* samples were lost, or an epoch began */
    FC_STREAM_ENDED,
    FC_TOO_EARLY,           /* there is too little signal before the contact */
    FC_NO_SIGNAL,           /* the signal is constant or not finite */
    FC_SECOND_TOUCHED,      /* the second finger touched before the first estimate */
    FC_NOT_FINITE           /* the model predicts no finite number */
};

typedef struct {
    int32_t kind, reason, flags;
    int32_t channel;        /* vibration channel of a contact; -1 for none */
    int64_t sample;
    int64_t known;          /* last sample that the event depends on */
    int32_t samples;        /* number of samples after the contact that an estimate uses */
    fc_estimate estimate;
} fc_event;

struct fc_chain;

/* Functions that the calling program provides. Each can be NULL. */
typedef struct {
    void *context;          /* passed to these functions, or NULL */
    /* Receive an event.
       context  in, as above
       event    in */
    void (*emit)(void *context, const fc_event *event);
    /* Receive the decisions for a window.
       context  in, as above
       end      in, number of the sample after the window
       onsets   in, number of the first sample of a contact, or -1, (channels) */
    void (*window)(void *context, int64_t end, const int64_t *onsets);
    /* Return the number of further samples that wait already.
       context  in, as above */
    int32_t (*waiting)(void *context);
    /* Predict for a model of the kind FC_MODEL_PROGRAM, from chain->past in channel chain->channel.
       Return
       FC_DONE, or FC_NO_SIGNAL or FC_NOT_FINITE without a prediction.
       context  in, as above
       chain    in
       lead     in, samples before the contact chain->first that can be used
       samples  in, samples after it, which include the lookahead
       out      out, unit of the training */
    int32_t (*predict)(void *context, const struct fc_chain *chain, int32_t lead, int32_t samples,
                       fc_estimate *out);
    fc_judge judge;         /* for detectors of the kind FC_DETECTOR_PROGRAM */
} fc_program;

/* Channels of the samples. */
typedef struct {
    int32_t channels, taxels;
    int32_t finger[FC_CHANNELS_MOST];   /* number of the finger, -1 for none */
    double alpha[FC_CHANNELS_MOST];     /* exponential smoothing; 1 if the device has smoothed */
    bool is_by_hand;        /* a person moves the sensor, so there is no motor noise */
    bool has_floors;        /* noise at rest is known; otherwise each epoch is one closing */
    double floors[FC_CHANNELS_MOST];    /* V */
    bool keeps_first_state; /* use the first steady state only, and withdraw nothing */
} fc_stream;

typedef struct fc_chain {
    const fc_image *image;
    fc_stream stream;
    fc_program program;
    fc_gate gate;
    fc_past past;
    fc_detector detector;
    bool has_smoothed;
    double smoothed[FC_CHANNELS_MOST];
    bool has_begun;
    int64_t next;           /* number of the next sample */

    bool is_open;           /* a closing is in progress */
    int64_t start;          /* first sample of the closing */
    int64_t resettle;       /* end of the samples after which the steady state is measured again */
    bool is_confirmed, is_waiting; /* first contact: confirmed; waits for its confirmation */
    int64_t not_before;     /* onsets before this sample repeat a withdrawn contact */
    bool is_latched[FC_CHANNELS_MOST];

    bool has_first, has_second, is_over; /* contacts so far; the pinch is over */
    int32_t channel;        /* channel of the first contact */
    int64_t first, decided, second;
    bool is_touch_ready, is_settled;
    bool is_put_off;        /* an estimate waits for the next sample */
    bool is_second_put_off; /* and so does the report of the second contact */
    double baseline;
    fc_hints hints;
    fc_touch touch;
    float before[FC_BEFORE_MOST];
    fc_touch_room room;
    float *svm_room;
    bool varies;            /* the signal of the contact is not constant */
    int32_t predicted;      /* samples that the newest estimate needed */
    int32_t failed;         /* reason why no further estimate follows; 0 if there is none */
    bool is_predicted[FC_MOMENTS_MOST], is_skipped[FC_MOMENTS_MOST];
    fc_estimate estimates[FC_MOMENTS_MOST];
} fc_chain;

/* Return the bytes of work memory that a chain needs.
   image   in
   stream  in, of which only `channels` is read */
size_t fc_chain_bytes(const fc_image *image, const fc_stream *stream);

/* Set up a chain.
   c        out
   image    in, which must outlive the chain
   stream   in, copied
   program  in, copied
   memory   out, at an address that is a multiple of 8, (fc_chain_bytes). It must outlive the chain. */
void fc_chain_init(fc_chain *c, const fc_image *image, const fc_stream *stream,
                   const fc_program *program, void *memory);

/* Continue after lost samples or in a new epoch. Call this before the first sample, too.
   c              in, out
   next           in, number of the next sample, at least 0
   is_same_epoch  in, false if earlier samples tell nothing about the state of the motor */
void fc_chain_restart(fc_chain *c, int64_t next, bool is_same_epoch);

/* Process one sample.
   c          in, out
   vibration  in, V, (channels)
   loads      in, V, (taxels), or NULL without taxels or without floors */
void fc_chain_take(fc_chain *c, const double *vibration, const double *loads);

/* End the closing in progress, because the stream has ended.
   c  in, out */
void fc_chain_finish(fc_chain *c);

/* Set the measured closing speed of this closing, or of the next one, and the radius of objects.
   c      in, out
   hints  in, m/s and m, copied. The radius is above 0, infinite or NaN. */
void fc_chain_hint(fc_chain *c, const fc_hints *hints);

/* Return the number of samples until the next event is possible.
   c     in
   most  in, samples: largest number to return */
int32_t fc_chain_due(const fc_chain *c, int32_t most);

#ifdef __cplusplus
}
#endif
#endif
