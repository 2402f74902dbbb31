/* Feeds samples to the model, and reacts to its events. Written by `firstcontact export-model`.
   This one reads two numbers a line, index and thumb in V. Put your converter in their place. */
#include <stdio.h>

#include "fc_model_image.h"

static void on_event(void *context, const fc_event *event) {
    (void)context;
    if (event->kind == FC_CONTACT_FOUND) printf("contact %ld\n", (long)event->sample);
    if (event->kind == FC_ESTIMATED) {
        printf("estimate %.1f (%.1f to %.1f)\n", (double)event->estimate.value,
               (double)event->estimate.low, (double)event->estimate.high);
    }
}

int main(void) {
    static fc_image image;
    static fc_chain chain;
    static double memory[FC_MODEL_MEMORY / 8];
    const fc_program program = {.emit = on_event};
    fc_stream stream = {.channels = 2, .finger = {0, 1}, .alpha = {0.5, 0.5}}; /* see README.md */
    double volts[2];
    const char *fault =
        fc_image_read((const uint8_t *)fc_model_image, FC_MODEL_BYTES, &image);
    if (fault != NULL) {
        fprintf(stderr, "%s\n", fault);
        return 1;
    }
    fc_chain_init(&chain, &image, &stream, &program, memory);
    fc_chain_restart(&chain, 0, false); /* without noise floors, a closing begins here */
    while (scanf("%lf %lf", &volts[0], &volts[1]) == 2) fc_chain_take(&chain, volts, NULL);
    fc_chain_finish(&chain);
    return 0;
}
