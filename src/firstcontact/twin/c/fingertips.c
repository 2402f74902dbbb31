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

static double conductance(const double *p, double quick, double late)
{
    const double response = (1.0 - p[3]) * quick + p[3] * late;
    const double power = response == 0.0 && p[6] > 0.0 ? 0.0 : pow(response, p[6]); /* unloaded */
    return p[7] + p[5] * power;
}

/* Return the voltage of a taxel's column while its row is driven and the other rows are at ground.

   A row's pin has the resistance `pin`, and a column's divider `load`. Solved by Gauss-Seidel: a
   sweep reduces the error at least by the ratio of `pin` to the resistance of a row's taxels, about
   40, and the first sweep is exact without `pin`. */
static double column_volts(const double g[TAXELS], int32_t taxel, double pin, double load)
{
    enum { SWEEPS = 4 };
    double row[ROWS] = {0}, column[LINES] = {0};
    row[taxel / LINES] = VOLTS;
    for (int32_t sweep = 0; sweep < SWEEPS; sweep++) {
        for (int32_t r = 0; sweep > 0 && r < ROWS; r++) {
            double current = r == taxel / LINES ? VOLTS : 0.0, sum = 1.0;
            for (int32_t c = 0; c < LINES; c++) {
                current += pin * g[LINES * r + c] * column[c];
                sum += pin * g[LINES * r + c];
            }
            row[r] = current / sum;
        }
        for (int32_t c = 0; c < LINES; c++) {
            double current = 0.0, sum = 1.0;
            for (int32_t r = 0; r < ROWS; r++) {
                current += load * g[LINES * r + c] * row[r];
                sum += load * g[LINES * r + c];
            }
            column[c] = current / sum;
        }
    }
    return column[taxel % LINES];
}

WIDE void fc_force_readings(const double *force, const double *shares, const double *p,
                            const double *noise, double dt, double *state, int64_t first,
                            uint16_t *out, int64_t n)
{
    enum { WIDTH = 8 }; /* of a vector */
    double quick[WIDTH] = {0}, late[WIDTH] = {0}, share[WIDTH] = {0};
    const double threshold = p[0], rise = p[1], fall = p[2], creep = p[4], resistor = p[8];
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
        const double volts = column_volts(g, (int32_t)((first + i) % TAXELS), p[9], resistor);
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
    const double at = patch[3] >= 0.0 && patch[3] < 1e15 ? patch[3] : 0.0;
    const int64_t place = (int64_t)at;
    const double between = at - (double)place;
    const double left = factors[place % PLACES], right = factors[(place + 1) % PLACES];
    const double most = p->friction * (left + between * (right - left)) * press;
    double back = p->k * patch[0] + p->c * patch[1];
    if (patch[2] > 0.0) {
        patch[1] = surface;
        patch[0] += surface * p->dt;
        back = p->k * patch[0] + p->c * surface;
        if (fabs(back) > most)
            patch[2] = 0.0;
        return back;
    }
    const double off = surface - patch[1], kinetic = most / p->ratio;
    const double drag = kinetic + (most - kinetic) * exp(-fabs(off) / p->weakening);
    patch[1] += ((off > 0.0 ? drag : -drag) - back) / p->m * p->dt;
    patch[0] += patch[1] * p->dt;
    patch[3] += fabs(off) * p->dt / p->grain;
    if ((surface - patch[1]) * off <= 0.0 && fabs(p->k * patch[0]) <= most) {
        patch[2] = 1.0;
        patch[1] = surface;
    }
    return back;
}

void fc_slide_patches(const double *normal, const double *speed, const double *pull, double mass,
                      double friction, const double *p, const double *finger, const double *factors,
                      double *patches, int32_t count, double *state, double *out, int64_t n)
{
    const double dt = 1.0 / (RATE * STEPS_OF_SLIP), stiffness = p[1], damping = p[3];
    const double k = stiffness / p[0], m = p[2] / p[0], c = 2.0 * damping * sqrt(k * m);
    const double shear = 2.0 * stiffness / mass, loss = 2.0 * damping * sqrt(shear);
    const bool stiff = shear * dt * dt > 0.04;
    const double volts_per_newton = p[8] * finger[18];
    const double leak = 1.0 - exp(-dt / finger[19]);
    const double opened = 1.0 - exp(-2.0 * PI * finger[21] * dt), gain = finger[20];
    const pad sliding = {k, c, m, dt, friction, p[4], p[5], p[7]};
    for (int64_t i = 0; i < n; i++) {
        for (int32_t step = 0; step < STEPS_OF_SLIP; step++) {
            const double part = (step + 1.0) / STEPS_OF_SLIP;
            const double force = state[0] + part * (normal[i] - state[0]);
            const double press = (0.0 > force ? 0.0 : force) / p[0];
            const double slides = state[1] + part * (speed[i] - state[1]);
            const double load = state[2] + part * (pull[i] - state[2]);
            if (stiff) {
                const double wanted = load / stiffness;
                state[4] = (wanted - state[3]) / dt;
                state[3] = wanted;
            } else {
                state[4] += (shear * (load / stiffness - state[3]) - loss * state[4]) * dt;
                state[3] += state[4] * dt;
            }
            double along = 0.0;
            for (int32_t j = 0; j < count; j++)
                along += slide_patch(&sliding, factors + j * PLACES, patches + 4 * j, press,
                                     slides + state[4]);
            const double pressed = volts_per_newton * along;
            state[5] += leak * (pressed - state[5]);
            state[6] += opened * (gain * (pressed - state[5]) - state[6]);
        }
        state[0] = normal[i];
        state[1] = speed[i];
        state[2] = pull[i];
        for (int32_t j = 3; j < 7; j++)
            if (fabs(state[j]) < 1e-30) /* numbers too small to be normal are slow */
                state[j] = 0.0;
        out[i] = state[6];
    }
}
