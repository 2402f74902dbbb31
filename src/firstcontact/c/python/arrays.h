/* Arrays that Python passes: contiguous buffers of numbers of one kind, in this machine's byte
   order. Definition of a compiled module. */
#ifndef FIRSTCONTACT_ARRAYS_H
#define FIRSTCONTACT_ARRAYS_H

#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030B0000
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

#ifndef SOURCES_DIGEST /* setup.py defines it */
#define SOURCES_DIGEST ""
#endif

/* Define the module `_compiled` of a room. `slots` may be NULL. */
#define COMPILED_MODULE(title, functions, slots) \
    static PyModuleDef definition = { \
        PyModuleDef_HEAD_INIT, "_compiled", title " " SOURCES_DIGEST, 0, functions, slots, \
        NULL, NULL, NULL, \
    }; \
    PyMODINIT_FUNC PyInit__compiled(void); \
    PyMODINIT_FUNC PyInit__compiled(void) \
    { \
        return PyModuleDef_Init(&definition); \
    }

#endif
