/* Decoding of consecutive samples frames. The Python code of the package is the reference. */
#ifndef FIRSTCONTACT_FRAMES_H
#define FIRSTCONTACT_FRAMES_H

#include <Python.h>

/* decode_samples(data, width, counter, sample, overflow): number of bytes used, number of frames,
   and their samples. Decoding stops at the first frame that does not have the expected numbers. */
PyObject *decode_samples(PyObject *self, PyObject *const *args, Py_ssize_t n);

#endif
