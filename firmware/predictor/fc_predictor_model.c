#include "fc_predictor_model.h"

#include <string.h>

static char *put_text(char *to, const char *text)
{
    while (*text != '\0')
        *to++ = *text++;
    return to;
}

static char *put_number(char *to, uint32_t number)
{
    char digits[10];
    int n = 0;
    do
        digits[n++] = (char)('0' + number % 10);
    while ((number /= 10) > 0);
    while (n > 0)
        *to++ = digits[--n];
    return to;
}

/* Describe the accepted models, and the fault of the newest stored one ("" for none). */
static void tell_room(fc_predictor *a, const char *fault)
{
    char *to = put_text(a->room, "{\"format\":");
    to = put_number(to, FC_IMAGE_VERSION);
    to = put_number(put_text(to, ",\"room\":"), a->store.memory->slot_bytes - FC_SLOT_HEAD);
    to = put_text(put_text(put_text(to, ",\"fault\":\""), fault), "\"}");
    a->device->models = a->room;
    a->device->models_bytes = (size_t)(to - a->room);
}

/* Return NULL, or why this device cannot use the bytes as a model. */
static const char *read_model(const uint8_t *bytes, uint32_t n, fc_image *image)
{
    fc_stream stream;
    const char *const why = fc_image_read(bytes, n, image);
    return why != NULL ? why : fc_predictor_fits(image, &stream);
}

static const char *read_kept(fc_predictor *a)
{
    uint32_t n;
    const uint8_t *bytes = fc_store_model(&a->store, &n);
    if (bytes == NULL)
        return "";
    if (a->board.fast != NULL && n > a->board.fast_bytes)
        return "the model is longer than there is room for";
    if (a->board.fast != NULL)
        bytes = memcpy(a->board.fast, bytes, n);
    return read_model(bytes, n, &a->image);
}

const char *fc_predictor_load(fc_predictor *a)
{
    const char *const why = read_kept(a);
    a->ready = why == NULL || (fc_store_fall_back(&a->store) && read_kept(a) == NULL);
    if (a->ready)
        fc_predictor_start(a);
    a->device->active_model = a->ready ? a->image.text : NULL;
    a->device->active_model_bytes = a->image.text_bytes;
    tell_room(a, why == NULL ? "" : why);
    return why;
}

uint8_t fc_predictor_receive(void *own, const fc_frame *frame, uint32_t *next, const char **why)
{
    fc_predictor *const a = own;
    fc_store *const s = &a->store;
    const char *fault = "a frame about a model is too short";
    if (frame->type == FC_MODEL_BEGIN && frame->n >= 4) {
        s->taking = s->kept = false; /* also if this one is refused below */
        if (fc_get_u32(frame->payload) != FC_IMAGE_VERSION)
            fault = "the model has another format than this firmware reads";
        else if (frame->n == 12)
            fault = fc_store_begin(s, fc_get_u32(frame->payload + 4),
                                   fc_get_u32(frame->payload + 8));
    } else if (frame->type == FC_MODEL_CHUNK && frame->n > 4) {
        fault = fc_store_chunk(s, fc_get_u32(frame->payload), frame->payload + 4,
                               (uint32_t)frame->n - 4);
    } else if (frame->type == FC_MODEL_END && s->kept) {
        fault = NULL; /* a repeated request: the reply was lost */
    } else if (frame->type == FC_MODEL_END) {
        static fc_image trial;
        const uint8_t *const bytes = fc_store_whole(s, &fault);
        if (bytes != NULL)
            fault = read_model(bytes, s->length, &trial);
        if (fault == NULL)
            fault = fc_store_keep(s);
        if (fault == NULL)
            fault = fc_predictor_load(a);
    }
    *next = s->next;
    *why = fault != NULL ? fault : "";
    if (fault != NULL)
        return FC_MODEL_REFUSED;
    return frame->type == FC_MODEL_END ? FC_MODEL_KEPT : FC_MODEL_GOES_ON;
}

void fc_predictor_take_hint(void *own, const fc_frame *frame)
{
    if (frame->n == FC_HINT_BYTES)
        (void)fc_predictor_hint(own, fc_get_float(frame->payload), fc_get_float(frame->payload + 4),
                              fc_get_float(frame->payload + 8));
}
