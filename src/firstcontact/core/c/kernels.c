/* Python module of the kernels. */
#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030B0000
#include <Python.h>

#include "frames.h"
#include "twin_module.h"

#define FUNCTION(name, function) {name, (PyCFunction)(void (*)(void))function, METH_FASTCALL, NULL}
#define METHOD(name) FUNCTION(#name, name)
#define TWIN(name) FUNCTION(#name, twin_##name)

static PyMethodDef methods[] = {
    METHOD(decode_samples),
    TWIN(integrate_all), TWIN(tones), TWIN(filtered), TWIN(piezo_counts),
    TWIN(force_counts), TWIN(filter_scans), TWIN(smooth), TWIN(slide), TWIN(slide_patches),
    {NULL, NULL, 0, NULL},
};

#ifndef SOURCES_DIGEST
#define SOURCES_DIGEST ""
#endif

static PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "_compiled", "Kernels of the wire's frames and the twin. " SOURCES_DIGEST, 0, methods,
    NULL, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__compiled(void)
{
    return PyModuleDef_Init(&definition);
}
