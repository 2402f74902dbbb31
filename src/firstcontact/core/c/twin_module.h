/* Python functions of the twin's kernels. */
#ifndef FIRSTCONTACT_TWIN_MODULE_H
#define FIRSTCONTACT_TWIN_MODULE_H

#include <Python.h>

#define TWIN_FUNCTION(name) PyObject *twin_##name(PyObject *, PyObject *const *, Py_ssize_t)

TWIN_FUNCTION(integrate_all);
TWIN_FUNCTION(tones);
TWIN_FUNCTION(filtered);
TWIN_FUNCTION(piezo_counts);
TWIN_FUNCTION(force_counts);
TWIN_FUNCTION(filter_scans);
TWIN_FUNCTION(smooth);
TWIN_FUNCTION(slide);
TWIN_FUNCTION(slide_patches);

#endif
