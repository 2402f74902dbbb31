/* Noise, converters and filters of the simulated fingertips, and the slip of an object. */
#include "twin.h"

#include <math.h>
#include <string.h>

static const double RATE = 4936.0, VOLTS = 3.3, OFFSET = 1.65, COUNTS = 1024.0, GRAVITY = 9.81;
static const double PI = 3.141592653589793;

enum { SUBCOUNTS = 32, HIGHEST = 1023, ROUND = TAXELS * READINGS, STEPS_OF_SLIP = 20 };
enum { LINES = 2, ROWS = TAXELS / LINES }; /* columns and rows of a force array */

WIDE void fc_tones(double (*lines)[2], const double (*turns)[2], const double *amplitudes,
                   const double *depth, int32_t count, double *out, int64_t n)
{
    enum { SLOW = TONES_MOST - 1 }; /* index of the last line, for any number of lines */
    double re[TONES_MOST] = {0}, im[TONES_MOST] = {0}, c[TONES_MOST] = {0}, s[TONES_MOST] = {0};
    double a[TONES_MOST] = {0}, d[TONES_MOST] = {0}, part[TONES_MOST], real[TONES_MOST];
    for (int32_t k = 0; k <= count; k++) {
        const int32_t place = k == count ? SLOW : k;
        re[place] = lines[k][0];
        im[place] = lines[k][1];
        c[place] = turns[k][0];
        s[place] = turns[k][1];
    }
    for (int32_t k = 0; k < count; k++) {
        a[k] = amplitudes[k];
        d[k] = depth[k];
    }
    for (int64_t i = 0; i < n; i++) {
        const double beat = im[SLOW];
        double sum = out[i];
        LANEWISE for (int32_t k = 0; k < TONES_MOST; k++) {
            part[k] = a[k] * (1.0 + d[k] * beat) * im[k];
            real[k] = re[k] * c[k] - im[k] * s[k];
            im[k] = re[k] * s[k] + im[k] * c[k];
            re[k] = real[k];
        }
        for (int32_t k = 0; k < count; k++)
            sum += part[k];
        out[i] = sum;
    }
    for (int32_t k = 0; k <= count; k++) {
        lines[k][0] = re[k == count ? SLOW : k];
        lines[k][1] = im[k == count ? SLOW : k];
    }
}

void fc_filtered(const double *sections, int32_t count, const double *x, double *out, int64_t n)
{
    double state[SECTIONS_MOST][2] = {{0}};
    for (int64_t i = 0; i < n; i++) {
        double y = x[i];
        for (int32_t k = 0; k < count; k++) {
            const double *const b = sections + 6 * k, before = y;
            y = b[0] * before + state[k][0];
            state[k][0] = b[1] * before - b[4] * y + state[k][1];
            state[k][1] = b[2] * before - b[5] * y;
        }
        out[i] = y;
    }
}

static uint16_t reading(double count)
{
    return count >= 1.0 ? (uint16_t)(count < HIGHEST ? count : HIGHEST) : 0;
}

void fc_piezo_readings(const double *volts, uint16_t *out, int64_t n)
{
    for (int64_t i = 0; i < n; i++)
        out[i] = reading((volts[i] + OFFSET) * (COUNTS / VOLTS));
}

static double conductance(const VelostatParameters *p, double quick, double late)
{
    const double response = (1.0 - p->creep_share) * quick + p->creep_share * late;
    const bool is_unloaded = response == 0.0 && p->exponent > 0.0;
    const double power = is_unloaded ? 0.0 : pow(response, p->exponent);
    return p->leak + p->conductance * power;
}

/* Return the voltage of a taxel's column while its row is driven and the other rows are at ground.

   A row has the resistance `series`, and a column's divider `load`. Kirchhoff's current law at the
   rows leaves an equation for each of the two columns. */
static double column_volts(const double g[TAXELS], int32_t taxel, double series, double load)
{
    double a[LINES][LINES] = {{1.0, 0.0}, {0.0, 1.0}}, b[LINES] = {0};
    for (int32_t r = 0; r < ROWS; r++) {
        const double *h = g + LINES * r, share = load / (1.0 + series * (h[0] + h[1]));
        for (int32_t c = 0; c < LINES; c++) {
            b[c] += r == taxel / LINES ? VOLTS * share * h[c] : 0.0;
            a[c][c] += share * h[c];
            a[c][c] += share * series * h[c] * h[1 - c];
            a[c][1 - c] -= share * series * h[c] * h[1 - c];
        }
    }
    const int32_t c = taxel % LINES, d = 1 - c;
    return (b[c] * a[d][d] - b[d] * a[c][d]) / (a[0][0] * a[1][1] - a[0][1] * a[1][0]);
}

WIDE void fc_force_readings(const double *force, const double *shares,
                            const VelostatParameters *p, const double *noise, double dt,
                            double *state, int64_t first, uint16_t *out, int64_t n)
{
    enum { WIDTH = 8 }; /* of a vector */
    double quick[WIDTH] = {0}, late[WIDTH] = {0}, share[WIDTH] = {0};
    const double threshold = p->threshold, rise = p->rise, fall = p->fall;
    const double creep = p->creep, resistor = p->resistor;
    memcpy(quick, state, TAXELS * sizeof *state);
    memcpy(late, state + TAXELS, TAXELS * sizeof *state);
    memcpy(share, shares, TAXELS * sizeof *shares);
    for (int64_t i = 0; i < n; i++) {
        LANEWISE for (int32_t k = 0; k < WIDTH; k++) {
            const double above = force[i] * share[k] - threshold, load = 0.0 > above ? 0.0 : above;
            const double tau = load > quick[k] ? rise : fall;
            quick[k] += (load - quick[k]) * dt / tau;
            late[k] += (load - late[k]) * dt / creep;
        }
        double g[TAXELS];
        for (int32_t k = 0; k < TAXELS; k++)
            g[k] = conductance(p, quick[k], late[k]);
        const double volts = column_volts(g, (int32_t)((first + i) % TAXELS), p->row, resistor);
        out[i] = reading((volts + noise[i]) * (COUNTS / VOLTS));
    }
    memcpy(state, quick, TAXELS * sizeof *state);
    memcpy(state + TAXELS, late, TAXELS * sizeof *state);
}

static int64_t clipped(uint16_t count)
{
    return count < HIGHEST ? count : HIGHEST;
}

/* Return the reading of a taxel alone in its column, as firmware/core/fc_filter.c does. */
static int16_t alone(int64_t mean, int64_t others)
{
    const int64_t full = (int64_t)COUNTS * SUBCOUNTS, top = HIGHEST * SUBCOUNTS;
    const int64_t left = others < full ? full - others : 1;
    const int64_t value = (mean * full + left / 2) / left;
    return (int16_t)(value < top ? value : top);
}

void fc_filter(const uint16_t *scans, int64_t n, int64_t *place, int64_t *smoothed,
               int64_t *readings, int64_t *sums, int16_t *out)
{
    for (int64_t i = 0; i < n; i++, scans += SCAN, out += COLUMNS) {
        if (*place < 0) {
            for (int f = 0; f < 2; f++)
                smoothed[f] = clipped(scans[f]) * SUBCOUNTS;
            *place = 0;
        }
        const int64_t taxel = *place % TAXELS, slot = *place / TAXELS;
        for (int f = 0; f < 2; f++) {
            int64_t *const sum = sums + f * TAXELS;
            int64_t *const kept = readings + (f * TAXELS + taxel) * READINGS;
            const int64_t count = clipped(scans[2 + f]);
            smoothed[f] = (smoothed[f] + clipped(scans[f]) * SUBCOUNTS) >> 1;
            if (kept[0] < 0) {
                for (int k = 0; k < READINGS; k++)
                    kept[k] = count;
                sum[taxel] = READINGS * count;
            }
            sum[taxel] += count - kept[slot];
            kept[slot] = count;
            out[f] = (int16_t)smoothed[f];
            int64_t mean[TAXELS], column[LINES] = {0};
            for (int k = 0; k < TAXELS; k++) {
                mean[k] = sum[k] * (SUBCOUNTS / READINGS);
                column[k % LINES] += mean[k];
            }
            for (int k = 0; k < TAXELS; k++)
                out[2 + TAXELS * f + k] = alone(mean[k], column[k % LINES] - mean[k]);
            out[2 + 2 * TAXELS + f] = scans[4 + f] != 0;
        }
        *place = (*place + 1) % ROUND;
    }
}

void fc_smoothed(const uint16_t *counts, int16_t *out, int64_t n)
{
    int64_t state = n > 0 ? clipped(counts[0]) * SUBCOUNTS : 0;
    for (int64_t i = 0; i < n; i++) {
        state = (state + clipped(counts[i]) * SUBCOUNTS) >> 1;
        out[i] = (int16_t)state;
    }
}

void fc_slide(const double *forces, const double *hanging, double mass, double friction, double dt,
              const double *slid, double *out, int64_t n)
{
    double distance = slid[0], speed = slid[1];
    for (int64_t i = 0; i < n; i++, forces += 2, out += 2) {
        const double rubbing = friction * (forces[0] + forces[1]) / mass;
        const double gravity = GRAVITY * hanging[i];
        if (speed > 0.0 || rubbing < gravity) {
            const double sum = speed + (gravity - rubbing) * dt, faster = 0.0 > sum ? 0.0 : sum;
            distance += 0.5 * (speed + faster) * dt;
            speed = faster;
        }
        out[0] = distance;
        out[1] = speed;
    }
}

/* Quantities of a sliding pad, computed from SlipParameters. */
typedef struct {
    double k, c, m, dt, friction, ratio, weakening, grain;
} pad;

/* Advance one patch by a step, and return its pull on the pad. */
static double slide_patch(const pad *p, const double *factors, double *patch, double press,
                          double surface)
{
    const double at = patch[PATCH_PATH] >= 0.0 && patch[PATCH_PATH] < 1e15 ? patch[PATCH_PATH] : 0.0;
    const int64_t place = (int64_t)at;
    const double between = at - (double)place;
    const double left = factors[place % PLACES], right = factors[(place + 1) % PLACES];
    const double most = p->friction * (left + between * (right - left)) * press;
    double back = p->k * patch[PATCH_AT] + p->c * patch[PATCH_SPEED];
    if (patch[PATCH_STICKS] > 0.0) {
        patch[PATCH_SPEED] = surface;
        patch[PATCH_AT] += surface * p->dt;
        back = p->k * patch[PATCH_AT] + p->c * surface;
        if (fabs(back) > most)
            patch[PATCH_STICKS] = 0.0;
        return back;
    }
    const double off = surface - patch[PATCH_SPEED], kinetic = most / p->ratio;
    const double drag = kinetic + (most - kinetic) * exp(-fabs(off) / p->weakening);
    patch[PATCH_SPEED] += ((off > 0.0 ? drag : -drag) - back) / p->m * p->dt;
    patch[PATCH_AT] += patch[PATCH_SPEED] * p->dt;
    patch[PATCH_PATH] += fabs(off) * p->dt / p->grain;
    if ((surface - patch[PATCH_SPEED]) * off <= 0.0 && fabs(p->k * patch[PATCH_AT]) <= most) {
        patch[PATCH_STICKS] = 1.0;
        patch[PATCH_SPEED] = surface;
    }
    return back;
}

void fc_slide_patches(const double *normal, const double *speed, const double *pull, double mass,
                      double friction, const SlipParameters *p, const FingerParameters *finger,
                      const double *factors, double *patches, int32_t count, double *state,
                      double *out, int64_t n)
{
    const double dt = 1.0 / (RATE * STEPS_OF_SLIP), stiffness = p->stiffness, damping = p->damping;
    const double k = stiffness / p->patches, m = p->mass / p->patches, c = 2.0 * damping * sqrt(k * m);
    const double shear = 2.0 * stiffness / mass, loss = 2.0 * damping * sqrt(shear);
    const bool stiff = shear * dt * dt > 0.04;
    const double volts_per_newton = p->coupling * finger->piezo_volts_per_newton;
    const double leak = 1.0 - exp(-dt / finger->piezo_time_constant);
    const double opened = 1.0 - exp(-2.0 * PI * finger->buffer_cutoff * dt), gain = finger->gain;
    const pad sliding = {k, c, m, dt, friction, p->ratio, p->weakening, p->grain};
    for (int64_t i = 0; i < n; i++) {
        for (int32_t step = 0; step < STEPS_OF_SLIP; step++) {
            const double part = (step + 1.0) / STEPS_OF_SLIP;
            const double force = state[LAST_NORMAL] + part * (normal[i] - state[LAST_NORMAL]);
            const double press = (0.0 > force ? 0.0 : force) / p->patches;
            const double slides = state[LAST_SPEED] + part * (speed[i] - state[LAST_SPEED]);
            const double load = state[LAST_PULL] + part * (pull[i] - state[LAST_PULL]);
            if (stiff) {
                const double wanted = load / stiffness;
                state[SHEAR_SPEED] = (wanted - state[SHEAR_AT]) / dt;
                state[SHEAR_AT] = wanted;
            } else {
                const double pull_back = shear * (load / stiffness - state[SHEAR_AT]);
                state[SHEAR_SPEED] += (pull_back - loss * state[SHEAR_SPEED]) * dt;
                state[SHEAR_AT] += state[SHEAR_SPEED] * dt;
            }
            double along = 0.0;
            for (int32_t j = 0; j < count; j++)
                along += slide_patch(&sliding, factors + j * PLACES, patches + PATCH_STATES * j, press,
                                     slides + state[SHEAR_SPEED]);
            const double pressed = volts_per_newton * along;
            state[SLIP_LEAKED] += leak * (pressed - state[SLIP_LEAKED]);
            state[SLIP_BUFFER] += opened * (gain * (pressed - state[SLIP_LEAKED]) - state[SLIP_BUFFER]);
        }
        state[LAST_NORMAL] = normal[i];
        state[LAST_SPEED] = speed[i];
        state[LAST_PULL] = pull[i];
        for (int32_t j = SHEAR_AT; j < SLIP_STATES; j++)
            if (fabs(state[j]) < 1e-30) /* numbers too small to be normal are slow */
                state[j] = 0.0;
        out[i] = state[SLIP_BUFFER];
    }
}
