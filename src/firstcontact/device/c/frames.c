/* Python module of the wire: decoding of consecutive samples frames, with the COBS and CRC of the
   firmware. The Python code of the package is the reference. */
#include <string.h>

#include "arrays.h"
#include "fc_cobs.h"
#include "fc_crc32.h"

/* Type of a samples frame; bytes before its samples, and of its CRC; longest frame without
   zeros. */
enum { SAMPLES = 0x02, HEAD = 14, CRC = 4, LONGEST = 16384 };

/* State of a stream, and size of a sample, bytes. */
typedef struct {
    uint32_t counter, sample, overflow;
    size_t size;
} expected;

static uint32_t word(const uint8_t *at)
{
    return at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

/* Return the number of bytes of samples in a frame without its COBS; 0 if it is any other frame. */
static size_t samples_in(const uint8_t *frame, ptrdiff_t n, const expected *next)
{
    if (n <= HEAD + CRC || frame[0] != SAMPLES || word(frame + 1) != next->counter
        || word(frame + 5) != next->sample || word(frame + 9) != next->overflow)
        return 0;
    const size_t size = (size_t)n - HEAD - CRC;
    if (size != frame[13] * next->size || word(frame + n - CRC) != fc_crc32(frame, (size_t)n - CRC))
        return 0;
    return size;
}

/* decode_samples(data, width, counter, sample, overflow): number of bytes used, number of frames,
   and their samples. Decoding stops at the first frame that does not have the expected numbers. */
static PyObject *decode_samples(PyObject *self, PyObject *const *args, Py_ssize_t n)
{
    uint8_t frame[LONGEST];
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
        const size_t size = samples_in(frame, fc_cobs_unstuff(at, (size_t)(zero - at), frame), &next);
        if (size == 0)
            break;
        memcpy(samples + count, frame + HEAD, size);
        count += size;
        frames++;
        next.counter++;
        next.sample += frame[13];
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
