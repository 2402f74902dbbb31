/* Pitch of the motor before a contact. Rotor, gears and harmonics rise with the closing speed, so
   the whole spectrum shifts on a logarithmic axis of frequency.

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". */
#ifndef FC_PITCH_H
#define FC_PITCH_H

#include <stdbool.h>
#include <stdint.h>

enum {
    FC_TURN = 512,          /* samples of the Fourier transform */
    FC_LINES = 400,         /* points of the spectrum, evenly spaced in ln(frequency) */
    FC_SHIFT_MOST = 88      /* largest shift that is searched, in points */
};

/* Constants of the spectrum at one rate. */
typedef struct {
    int32_t samples;        /* number of analysed samples before the contact, at most FC_TURN */
    const float *sine;      /* first quarter of a sine: FC_TURN / 4 + 1 */
    const float *fade;      /* window function, per count of the converter: samples */
    const float *part;      /* position of a point between two lines: FC_LINES */
    const int32_t *cell;    /* line of the transform below each point: FC_LINES */
} fc_pitch;

/* Compute the peaks of a spectrum above its smooth part.
   e       in
   signal  in, V, (e->samples)
   work    out, room for work, (FC_TURN)
   lines   out, ln(power), with mean 0, (FC_LINES) */
void fc_spectrum(const fc_pitch *e, const float *signal, float *work, float *lines);

/* Find the shift with the highest correlation to a reference.
   lines, reference  in, of fc_spectrum, (FC_LINES)
   shift             out, points
   correlation       out, from -1 to 1 */
void fc_shift(const float *lines, const float *reference, int32_t *shift, float *correlation);

#endif
