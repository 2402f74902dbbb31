/* Python module of the wire: decoding of consecutive samples frames, with the code of the
   firmware. The Python code of the package is the reference. */
#include <string.h>

#include "arrays.h"
#include "fc_protocol.h"

/* Bytes of a payload before its samples; longest stuffed frame. */
enum { SAMPLES_HEAD = 9, LONGEST = 16384 };

/* State of a stream, and size of a sample, bytes. */
typedef struct {
    uint32_t counter, sample, overflow;
    size_t size;
} expected;

/* Decode a frame. Return the number of bytes of samples in it; 0 if it is any other frame. */
static size_t samples_in(uint8_t *wire, size_t n, const expected *next, fc_frame *frame)
{
    if (fc_frame_decode(wire, n, frame) != 0 || frame->type != FC_SAMPLES
        || frame->counter != next->counter || frame->n <= SAMPLES_HEAD
        || fc_get_u32(frame->payload) != next->sample
        || fc_get_u32(frame->payload + 4) != next->overflow)
        return 0;
    const size_t size = frame->n - SAMPLES_HEAD;
    return size == frame->payload[SAMPLES_HEAD - 1] * next->size ? size : 0;
}

/* decode_samples(data, width, counter, sample, overflow): number of bytes used, number of frames,
   and their samples. Decoding stops at the first frame that does not have the expected numbers. */
static PyObject *decode_samples(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    uint8_t wire[LONGEST];
    fc_frame frame;
    expected next;
    char *bytes;
    Py_ssize_t length;
    (void)self;
    if (n != 5)
        return PyErr_Format(PyExc_TypeError, "5 arguments are needed, not %zd", n);
    next.size = 2 * PyLong_AsSize_t(args[1]);
    next.counter = (uint32_t)PyLong_AsUnsignedLongMask(args[2]);
    next.sample = (uint32_t)PyLong_AsUnsignedLongMask(args[3]);
    next.overflow = (uint32_t)PyLong_AsUnsignedLongMask(args[4]);
    if (PyErr_Occurred() || PyBytes_AsStringAndSize(args[0], &bytes, &length) < 0)
        return NULL;
    /* COBS makes no frame shorter, so the samples need less room than the bytes. */
    uint8_t *const samples = PyMem_Malloc((size_t)length + 1);
    if (samples == NULL)
        return PyErr_NoMemory();
    const uint8_t *at = (const uint8_t *)bytes, *const end = at + length;
    size_t count = 0;
    Py_ssize_t frames = 0;
    for (const uint8_t *zero; (zero = memchr(at, 0, (size_t)(end - at))) != NULL; at = zero + 1) {
        if (zero - at > LONGEST)
            break;
        memcpy(wire, at, (size_t)(zero - at));
        const size_t size = samples_in(wire, (size_t)(zero - at), &next, &frame);
        if (size == 0)
            break;
        memcpy(samples + count, frame.payload + SAMPLES_HEAD, size);
        count += size;
        frames++;
        next.counter++;
        next.sample += frame.payload[SAMPLES_HEAD - 1];
    }
    PyObject *const out = Py_BuildValue("nny#", (Py_ssize_t)(at - (const uint8_t *)bytes), frames,
                                        (char *)samples, (Py_ssize_t)count);
    PyMem_Free(samples);
    return out;
}

static PyMethodDef methods[] = {
    {"decode_samples", (PyCFunction)(void (*)(void))decode_samples, METH_FASTCALL, NULL},
    {NULL, NULL, 0, NULL},
};

COMPILED_MODULE("Decoding of the wire's frames.", methods, NULL)
