/* Arrays that Python passes. */
#include "arrays.h"

#include <string.h>

/* A long has 4 or 8 bytes, so its format stands for two kinds: the size decides. */
static const struct {
    enum kind kind;
    const char *formats[2];
    Py_ssize_t size;
} KINDS[] = {
    {F32, {"f", "f"}, 4}, {F64, {"d", "d"}, 8}, {PAIR, {"Zd", "Zd"}, 16}, {I16, {"h", "h"}, 2},
    {U16, {"H", "H"}, 2}, {I32, {"i", "l"}, 4}, {I64, {"q", "l"}, 8},
};

static int row(enum kind kind)
{
    int k = 0;
    while (KINDS[k].kind != kind)
        k++;
    return k;
}

Py_ssize_t array_size(enum kind kind)
{
    return KINDS[row(kind)].size;
}

bool array_get(PyObject *object, Py_buffer *view, enum kind kind, bool is_written)
{
    const int k = row(kind);
    const int flags = PyBUF_C_CONTIGUOUS | PyBUF_FORMAT | (is_written ? PyBUF_WRITABLE : 0);
    if (PyObject_GetBuffer(object, view, flags) < 0) {
        view->obj = NULL;
        return false;
    }
    const char *const format = view->format == NULL ? "B" : view->format;
    if (view->itemsize == KINDS[k].size
        && (!strcmp(format, KINDS[k].formats[0]) || !strcmp(format, KINDS[k].formats[1])))
        return true;
    PyErr_Format(PyExc_ValueError, "an array holds numbers of kind %s, not %s", format,
                 KINDS[k].formats[0]);
    PyBuffer_Release(view);
    return false;
}

bool array_take(PyObject *object, Py_buffer *view, Py_ssize_t count, enum kind kind, bool is_written)
{
    const Py_ssize_t bytes = count * array_size(kind);
    if (!array_get(object, view, kind, is_written))
        return false;
    if (view->len == bytes)
        return true;
    PyErr_Format(PyExc_ValueError, "an array has %zd bytes, not %zd", view->len, bytes);
    PyBuffer_Release(view);
    return false;
}
