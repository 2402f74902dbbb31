#include "fc_cobs.h"

size_t fc_cobs_stuff(const uint8_t *in, size_t n, uint8_t *out)
{
    size_t code = 0; /* position for the length of the current run */
    size_t w = 1;
    for (size_t i = 0; i < n; i++) {
        if (in[i] != 0) {
            out[w++] = in[i];
            if (w - code < 255u)
                continue;
        }
        /* A run ends at a zero, or after 254 bytes without one. */
        out[code] = (uint8_t)(w - code);
        code = w++;
    }
    out[code] = (uint8_t)(w - code);
    return w;
}

ptrdiff_t fc_cobs_unstuff(const uint8_t *in, size_t n, uint8_t *out)
{
    size_t w = 0;
    size_t i = 0;
    if (n == 0)
        return -1;
    while (i < n) {
        const uint8_t code = in[i];
        if (code == 0 || code > n - i)
            return -1;
        for (size_t k = 1; k < code; k++) {
            if (in[i + k] == 0)
                return -1;
            out[w++] = in[i + k];
        }
        i += code;
        if (code != 255u && i < n)
            out[w++] = 0;
    }
    return (ptrdiff_t)w;
}
