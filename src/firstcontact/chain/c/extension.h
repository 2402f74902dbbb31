/* What the files of the chain's Python module share. Arrays come as contiguous buffers, whose sizes
   are checked in these files. */
#ifndef FIRSTCONTACT_EXTENSION_H
#define FIRSTCONTACT_EXTENSION_H

#include "arrays.h"
#include "fc_chain.h"

/* Name of the capsules of images. */
#define IMAGE "firstcontact.image"

/* Image with its own copy of the bytes. */
typedef struct {
    fc_image image;
    double bytes[];
} held_image;

/* Functions of stream_module.c and touch_module.c. */
extern PyMethodDef STREAM_FUNCTIONS[], TOUCH_FUNCTIONS[];

#define FAST(f) (PyCFunction)(void (*)(void))(f)

static inline void release(Py_buffer *views, int n)
{
    while (n--)
        PyBuffer_Release(views + n);
}

static inline PyObject *refuse(const char *why)
{
    if (!PyErr_Occurred())
        PyErr_SetString(PyExc_ValueError, why);
    return NULL;
}

static inline bool has(Py_ssize_t n, Py_ssize_t wanted)
{
    if (n != wanted)
        PyErr_Format(PyExc_TypeError, "%zd arguments are needed, not %zd", wanted, n);
    return n == wanted;
}

#endif
