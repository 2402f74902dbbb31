/* Arrays that Python passes: contiguous buffers of numbers of one kind, in this machine's byte
   order. */
#ifndef FIRSTCONTACT_ARRAYS_H
#define FIRSTCONTACT_ARRAYS_H

#include <Python.h>

#include <stdbool.h>

/* Kinds of numbers, as buffers name them; pairs of F64 are complex numbers. */
enum kind { F32 = 'f', F64 = 'd', PAIR = 'z', I16 = 'h', U16 = 'H', I32 = 'i', I64 = 'q' };

/* Bytes of a number. */
Py_ssize_t array_size(enum kind kind);

/* Get the buffer of an array of any length. Set an error and return false if its kind differs. */
bool array_get(PyObject *object, Py_buffer *view, enum kind kind, bool is_written);

/* Get the buffer of an array of exactly this many numbers. */
bool array_take(PyObject *object, Py_buffer *view, Py_ssize_t count, enum kind kind, bool is_written);

#endif
