/* Mechanics of pinches. Several are integrated side by side in the lanes of a vector unit. Each
   lane is a finger of a pinch. All lanes advance together, each by a step of its own length. */
#include "twin.h"

#include <math.h>
#include <string.h>

enum {
    SIDE = 4,            /* pinches side by side */
    LANES = 2 * SIDE,    /* index fingers, then thumbs */
    VARIABLES = FINGER_STATES + 2, /* states of a finger, then position and speed of its face */
    FACE = FINGER_STATES,
    STAGES = 4,
    INSTANTS = 3         /* begin, middle and end of a step */
};

/* Loop over lanes, which becomes one or two vector instructions. Each loop has at most one choice
   of a kind: a compiler would turn two choices that depend on each other into branches. */
#define EACH_LANE(l) LANEWISE for (int l = 0; l < 2 * side; l++)

static const double NEAR = 2e-4, PI = 3.141592653589793;

/* Parameters and state of all lanes. Divisions are done once, as reciprocals. */
typedef struct {
    double x[VARIABLES][LANES], k[STAGES][VARIABLES][LANES];
    double h[INSTANTS][LANES], sixth[LANES], push[INSTANTS][LANES], gap[LANES], speed[LANES];
    double sign[LANES]; /* of a face's motion along the finger's */
    double speed_gain[LANES], drive_force[LANES], motor_force[LANES], back_damping[LANES];
    double link_stiffness[LANES], link_damping[LANES], mount_stiffness[LANES], mount_damping[LANES];
    double pad_stiffness[LANES], pad_stiffening[LANES], pad_arm_stiffness[LANES], pad_damping[LANES];
    double per_drive[LANES], per_phalanx[LANES], per_board[LANES], per_skin[LANES];
    double per_pad_relaxation[LANES], per_time_constant[LANES];
    double volts_per_newton[LANES], gain[LANES], cutoff[LANES];
    double stiffness[LANES], confinement[LANES], dent[LANES];
    double fast_share[LANES], slow_share[LANES], per_fast[LANES], per_slow[LANES], all[LANES], per_all[LANES];
    bool is_special[SIDE], is_plain; /* a touched object gives way, or a pad is confined */
    double bulk_stiffness[SIDE], bulk_damping[SIDE], clamp_stiffness[SIDE], clamp_damping[SIDE];
    double per_face[SIDE];
} lanes_t;

/* Progress of a pinch in its piece. */
typedef struct {
    fc_pinch *pinch; /* NULL if these lanes are idle */
    int64_t sample;
    /* finger that touches first; finger that touches after this step */
    int32_t first, touching, tries;
    bool waits; /* the step ends at a contact */
    int64_t step, steps;
    double t, end, stop, begin, interval, per_step, per_noise, loudness;
} walk;

static double larger(double a, double b)
{
    return b > a ? b : a;
}

static double smaller(double a, double b)
{
    return b < a ? b : a;
}

/* Return Hertz's force over its stiffness. `root` is that of the indentation, and `b` stands for
   the confinement of the pad by a rigid back. */
INLINE double hertz(double root, double b)
{
    const double q = b * root;
    return root * root * root * (1.0 + q * (1.5 + q * (2.6 + 5.0 * q)));
}

/* Return the derivative of hertz() over the indentation. */
INLINE double hertz_slope(double root, double b)
{
    const double q = b * root;
    return root * (1.5 + q * (3.0 + q * (6.5 + 15.0 * q)));
}

/* Return the root of the indentation where the wall gives way, too, by `dent` for each unit of
   hertz(). `all` is the root of the depth without the part of the arms in this. */
INLINE double dented(double all, double dent, double b)
{
    const double s = dent * all;
    double root = all * (1.0 + 0.164 * s) / (1.0 + 0.51 * s); /* within 17 % up to s = 30 */
    for (int i = 0; i < 2; i++) { /* Halley's method */
        const double error = root * root + dent * hertz(root, b) - all * all;
        const double slope = 2.0 * root * (1.0 + dent * hertz_slope(root, b));
        const double bend = 1.0 + 3.0 * dent * root;
        root -= error * slope / (slope * slope - error * bend + 1e-60);
    }
    return root;
}

static double contact_force(const lanes_t *b, int l, double depth)
{
    const double arms = b->fast_share[l] * b->x[FAST_ARM][l] + b->slow_share[l] * b->x[SLOW_ARM][l];
    const double dent = b->dent[l], left = depth - dent * arms;
    if (!(left > 0.0))
        return 0.0;
    const double all = sqrt(left), root = dent > 0.0 ? dented(all, dent, b->confinement[l]) : all;
    return larger(b->stiffness[l] * (hertz(root, b->confinement[l]) + arms), 0.0);
}

/* Compute the derivatives of one stage, k[stage]. */
INLINE void derive(lanes_t *b, const int stage, const int side)
{
    const int instant = (stage + 1) / 2;
    double(*const k)[LANES] = b->k[stage];
    double y[VARIABLES][LANES], force[LANES], depth[LANES], rate[LANES], root[LANES], motor[LANES];
    double mount[LANES], pad[LANES], arms[LANES], fading[LANES], left[LANES], better[LANES];
    double growth[LANES];
    for (int v = 0; v < VARIABLES; v++)
        EACH_LANE(l)
            y[v][l] = stage == 0 ? b->x[v][l] : b->x[v][l] + b->h[instant][l] * b->k[stage - 1][v][l];
    EACH_LANE(l) {
        depth[l] = y[SKIN_AT][l] + b->sign[l] * y[FACE][l] - b->gap[l];
        rate[l] = y[SKIN_SPEED][l] + b->sign[l] * y[FACE + 1][l];
        const double fast = b->fast_share[l] * y[FAST_ARM][l];
        const double slow = b->slow_share[l] * y[SLOW_ARM][l];
        arms[l] = fast + slow;
        fading[l] = fast * b->per_fast[l] + slow * b->per_slow[l];
        left[l] = depth[l] - b->dent[l] * arms[l];
    }
    EACH_LANE(l)
        left[l] = left[l] > 0.0 ? left[l] : 0.0; /* it is NaN before a contact */
    EACH_LANE(l)
        root[l] = sqrt(left[l]);
    if (b->is_plain) {
        EACH_LANE(l) {
            force[l] = b->stiffness[l] * (root[l] * root[l] * root[l] + arms[l]);
            growth[l] = 1.5 * root[l] * rate[l];
        }
    } else {
        EACH_LANE(l)
            better[l] = dented(root[l], b->dent[l], b->confinement[l]);
        EACH_LANE(l)
            root[l] = b->dent[l] > 0.0 ? better[l] : root[l];
        EACH_LANE(l) {
            const double slope = hertz_slope(root[l], b->confinement[l]);
            force[l] = b->stiffness[l] * (hertz(root[l], b->confinement[l]) + arms[l]);
            growth[l] = slope * (rate[l] + b->dent[l] * fading[l])
                        / (1.0 + b->dent[l] * slope * b->all[l]);
        }
    }
    EACH_LANE(l) {
        const double wanted = b->speed_gain[l] * (b->speed[l] - y[DRIVE_SPEED][l]);
        motor[l] = -b->drive_force[l] > wanted ? -b->drive_force[l] : wanted;
    }
    EACH_LANE(l)
        motor[l] = b->motor_force[l] < motor[l] ? b->motor_force[l] : motor[l];
    EACH_LANE(l) {
        const double held = motor[l] - b->back_damping[l] * y[DRIVE_SPEED][l];
        const int pushed = (b->back_damping[l] > 0.0) & (y[DRIVE_SPEED][l] < 0.0)
                           & (b->speed[l] >= 0.0);
        motor[l] = pushed ? held : motor[l];
    }
    EACH_LANE(l) {
        const double drive_v = y[DRIVE_SPEED][l], phalanx_v = y[PHALANX_SPEED][l];
        const double board_v = y[BOARD_SPEED][l], skin_v = y[SKIN_SPEED][l];
        const double pad_arm = y[PAD_ARM][l];
        const double link = b->link_stiffness[l] * (y[DRIVE_AT][l] - y[PHALANX_AT][l])
                            + b->link_damping[l] * (drive_v - phalanx_v);
        mount[l] = b->mount_stiffness[l] * (y[PHALANX_AT][l] - y[BOARD_AT][l])
                             + b->mount_damping[l] * (phalanx_v - board_v);
        const double squeeze = y[BOARD_AT][l] - y[SKIN_AT][l], squeezing = board_v - skin_v;
        pad[l] =
            (b->pad_stiffness[l] + b->pad_stiffening[l] * squeeze * squeeze) * squeeze
            + b->pad_arm_stiffness[l] * pad_arm + b->pad_damping[l] * squeezing;
        const double volts = b->volts_per_newton[l] * mount[l] - y[LEAKED][l];
        k[DRIVE_AT][l] = drive_v;
        k[DRIVE_SPEED][l] = (motor[l] - link) * b->per_drive[l];
        k[PHALANX_AT][l] = phalanx_v;
        k[PHALANX_SPEED][l] = (link - mount[l] + b->push[instant][l]) * b->per_phalanx[l];
        k[BOARD_AT][l] = board_v;
        k[BOARD_SPEED][l] = (mount[l] - pad[l]) * b->per_board[l];
        k[SKIN_AT][l] = skin_v;
        k[PAD_ARM][l] = squeezing - pad_arm * b->per_pad_relaxation[l];
        k[LEAKED][l] = volts * b->per_time_constant[l];
        k[BUFFER][l] = b->cutoff[l] * (b->gain[l] * volts - y[BUFFER][l]);
        k[FACE][l] = y[FACE + 1][l];
    }
    /* Off the finger, the face recovers by itself: the arms relax without a force. */
    EACH_LANE(l)
        growth[l] = force[l] > 0.0 ? growth[l] : fading[l] * b->per_all[l];
    EACH_LANE(l)
        force[l] = 0.0 > force[l] ? 0.0 : force[l];
    EACH_LANE(l) {
        k[FAST_ARM][l] = growth[l] - y[FAST_ARM][l] * b->per_fast[l];
        k[SLOW_ARM][l] = growth[l] - y[SLOW_ARM][l] * b->per_slow[l];
    }
    EACH_LANE(l)
        k[SKIN_SPEED][l] = (pad[l] - force[l]) * b->per_skin[l];
    for (int p = 0; p < side; p++) {
        const double a = y[FACE][p], z = y[FACE][side + p];
        const double a_v = y[FACE + 1][p], z_v = y[FACE + 1][side + p];
        const double bulk = b->bulk_stiffness[p] * (a - z) + b->bulk_damping[p] * (a_v - z_v);
        const double hold = 0.5 * (b->clamp_stiffness[p] * a + b->clamp_damping[p] * a_v);
        const double other = 0.5 * (b->clamp_stiffness[p] * z + b->clamp_damping[p] * z_v);
        k[FACE + 1][p] = (force[p] - bulk - hold) * b->per_face[p];
        k[FACE + 1][side + p] = (bulk - force[side + p] - other) * b->per_face[p];
    }
}

/* Advance all lanes by one classical Runge-Kutta step. */
INLINE void advance(lanes_t *b, const int side)
{
    derive(b, 0, side);
    derive(b, 1, side);
    derive(b, 2, side);
    derive(b, 3, side);
    for (int v = 0; v < VARIABLES; v++)
        EACH_LANE(l)
            b->x[v][l] += b->sixth[l]
                          * (b->k[0][v][l] + 2.0 * (b->k[1][v][l] + b->k[2][v][l]) + b->k[3][v][l]);
}

static double face_gap(const lanes_t *b, int lane)
{
    return b->x[SKIN_AT][lane] + b->sign[lane] * b->x[FACE][lane];
}

/* Set the next step of a pinch, up to the next contact or the end of the substep. */
INLINE void aim(lanes_t *b, walk *w, int place, const int side)
{
    const fc_pinch *const q = w->pinch;
    w->stop = w->end;
    w->touching = -1;
    for (int turn = 0; turn < 2 && w->waits; turn++) {
        const int f = turn == 0 ? 1 - w->first : w->first;
        if (isnan(q->gap[f]) && q->touch[f] < w->end) {
            w->stop = larger(q->touch[f], w->t);
            w->touching = f;
        }
    }
    const double dt = w->stop - w->t, h[INSTANTS] = {0.0, 0.5 * dt, dt};
    const double last = (double)(q->points - 2);
    const double *const other = q->noise + q->points;
    for (int k = 0; k < INSTANTS; k++) {
        const double at = (w->t + h[k]) * w->per_noise;
        const int64_t cell = at < 0.0 ? 0 : (int64_t)(at < last ? at : last);
        const double part = at - (double)cell, *const index = q->noise + cell;
        const double *const thumb = other + cell;
        b->push[k][place] = w->loudness * (index[0] + part * (index[1] - index[0]));
        b->push[k][side + place] = w->loudness * (thumb[0] + part * (thumb[1] - thumb[0]));
        b->h[k][place] = b->h[k][side + place] = h[k];
    }
    b->sixth[place] = b->sixth[side + place] = dt * (1.0 / 6.0);
}

INLINE void begin_step(lanes_t *b, walk *w, int place, const int side)
{
    w->t = w->end;
    w->end = w->begin + w->interval * (double)(w->step + 1) * w->per_step;
    w->tries = 0;
    aim(b, w, place, side);
}

/* Write the outputs of a sample. Return false if it is the last. */
INLINE bool begin_sample(lanes_t *b, walk *w, int place, const int side)
{
    fc_pinch *const q = w->pinch;
    const int64_t last = q->samples - 1, next = w->sample < last ? w->sample + 1 : last;
    double *const out = q->out + w->sample * 2 * OUTPUTS;
    const double now = q->times[w->sample];
    bool near = q->times[next] >= q->touch[w->first];
    for (int f = 0; f < 2; f++) {
        const int l = f * side + place;
        double *const row = out + f * OUTPUTS;
        row[OUT_BUFFER] = b->x[BUFFER][l];
        row[OUT_INDENTATION] = face_gap(b, l) - b->gap[l];
        row[OUT_FORCE] = contact_force(b, l, row[OUT_INDENTATION]);
        row[OUT_FACE] = f == 0 ? b->x[FACE][l] : -b->x[FACE][l];
        row[OUT_DRIVE_SPEED] = b->x[DRIVE_SPEED][l];
        if (row[OUT_INDENTATION] > 0.0 && isnan(q->touched[f]))
            q->touched[f] = now;
        near = near || row[OUT_INDENTATION] > -NEAR;
    }
    q->taken = w->sample + 1;
    if (larger(out[OUT_FORCE], out[OUTPUTS + OUT_FORCE]) > q->limit || w->sample == last)
        return false;
    b->is_special[place] =
        near && b->dent[place] + b->confinement[place] + b->confinement[side + place] > 0.0;
    b->is_plain = true;
    for (int p = 0; p < side; p++)
        b->is_plain = b->is_plain && !b->is_special[p];
    w->steps = q->substeps;
    const bool both = !isnan(q->touched[0] + q->touched[1]);
    if (both && now - larger(q->touched[0], q->touched[1]) > q->calm)
        w->steps = q->calm_steps;
    else if (!near)
        w->steps = q->substeps > 1 ? q->substeps / 2 : 1;
    const double moving = 0.5 * (out[OUT_DRIVE_SPEED] + out[OUTPUTS + OUT_DRIVE_SPEED]);
    w->loudness = q->full_speed <= 0.0 ? 1.0 : smaller(fabs(moving) * (1.0 / q->full_speed), 1.0);
    w->interval = q->times[next] - now;
    w->per_step = 1.0 / (double)w->steps;
    w->begin = w->end = now;
    w->waits = isnan(q->gap[0]) || isnan(q->gap[1]);
    const double *const speed = q->speeds + 2 * (w->sample < q->rows ? w->sample : q->rows - 1);
    b->speed[place] = speed[0];
    b->speed[side + place] = speed[1];
    w->step = 0;
    begin_step(b, w, place, side);
    return true;
}

/* Continue after a step. Return false at the end of the piece. */
INLINE bool follow(lanes_t *b, walk *w, int place, const int side)
{
    if (w->touching >= 0) {
        const int l = w->touching * side + place;
        w->pinch->gap[w->touching] = b->gap[l] = face_gap(b, l);
        w->t = w->stop;
        if (++w->tries < 3) {
            aim(b, w, place, side);
            return true;
        }
    }
    if (++w->step < w->steps) {
        begin_step(b, w, place, side);
        return true;
    }
    w->sample++;
    return begin_sample(b, w, place, side);
}

static void load(lanes_t *b, const fc_pinch *q, int place, int side)
{
    const ObjectParameters *const o = &q->object;
    for (int f = 0; f < 2; f++) {
        const int l = f * side + place;
        const FingerParameters *const p = &q->finger[f];
        for (int v = 0; v < FINGER_STATES; v++)
            b->x[v][l] = q->x[f * FINGER_STATES + v];
        for (int v = 0; v < 2; v++)
            b->x[FACE + v][l] = q->x[2 * FINGER_STATES + 2 * f + v];
        b->sign[l] = f == 0 ? -1.0 : 1.0;
        b->gap[l] = q->gap[f];
        b->per_drive[l] = 1.0 / p->drive_mass;
        b->speed_gain[l] = p->speed_gain;
        b->drive_force[l] = p->drive_force;
        b->motor_force[l] = q->motor_force;
        b->back_damping[l] = q->back_damping;
        b->link_stiffness[l] = p->link_stiffness;
        b->link_damping[l] = p->link_damping;
        b->per_phalanx[l] = 1.0 / p->phalanx_mass;
        b->mount_stiffness[l] = p->mount_stiffness;
        b->mount_damping[l] = p->mount_damping;
        b->per_board[l] = 1.0 / p->board_mass;
        b->pad_stiffness[l] = p->pad_stiffness;
        b->pad_stiffening[l] = p->pad_stiffening;
        b->pad_arm_stiffness[l] = p->pad_arm_stiffness;
        b->per_pad_relaxation[l] = 1.0 / p->pad_relaxation;
        b->pad_damping[l] = p->pad_damping;
        b->per_skin[l] = 1.0 / p->skin_mass;
        b->volts_per_newton[l] = p->piezo_volts_per_newton;
        b->per_time_constant[l] = 1.0 / p->piezo_time_constant;
        b->gain[l] = p->gain;
        b->cutoff[l] = 2.0 * PI * p->buffer_cutoff;
        b->stiffness[l] = q->stiffness[f];
        b->confinement[l] = p->pad_confinement * q->stiffness[f];
        b->dent[l] = q->stiffness[f] / o->dent_stiffness;
        b->fast_share[l] = o->arm_share;
        b->slow_share[l] = o->slow_share;
        b->per_fast[l] = 1.0 / o->arm_relaxation;
        b->per_slow[l] = 1.0 / o->slow_relaxation;
        b->all[l] = 1.0 + o->arm_share + o->slow_share;
        b->per_all[l] = 1.0 / b->all[l];
    }
    b->per_face[place] = 1.0 / o->face_mass;
    b->bulk_stiffness[place] = o->bulk_stiffness;
    b->bulk_damping[place] = o->bulk_damping;
    b->clamp_stiffness[place] = o->clamp_stiffness;
    b->clamp_damping[place] = o->clamp_damping;
}

static void store(const lanes_t *b, fc_pinch *q, int place, int side)
{
    for (int f = 0; f < 2; f++) {
        for (int v = 0; v < FINGER_STATES; v++)
            q->x[f * FINGER_STATES + v] = b->x[v][f * side + place];
        for (int v = 0; v < 2; v++)
            q->x[2 * FINGER_STATES + 2 * f + v] = b->x[FACE + v][f * side + place];
    }
}

INLINE void run(fc_pinch *pinches, int32_t count, const int side)
{
    lanes_t b;
    walk walks[SIDE];
    int32_t next = 0, busy = 0;
    memset(&b, 0, sizeof b);
    memset(walks, 0, sizeof walks);
    do {
        if (busy > 0)
            advance(&b, side);
        for (int place = 0; place < side; place++) {
            walk *const w = walks + place;
            bool goes_on = w->pinch != NULL && follow(&b, w, place, side);
            while (!goes_on) {
                if (w->pinch != NULL) {
                    store(&b, w->pinch, place, side);
                    w->pinch = NULL;
                    b.is_special[place] = false;
                    busy--;
                }
                if (next == count)
                    break;
                fc_pinch *const q = w->pinch = pinches + next++;
                busy++;
                w->sample = 0;
                w->per_noise = 1.0 / q->noise_dt;
                w->first = q->touch[0] <= q->touch[1] ? 0 : 1;
                load(&b, q, place, side);
                goes_on = begin_sample(&b, w, place, side);
            }
        }
    } while (busy > 0);
}

WIDE static void run_one(fc_pinch *pinch)
{
    run(pinch, 1, 1);
}

WIDE static void run_all(fc_pinch *pinches, int32_t count)
{
    run(pinches, count, SIDE);
}

void fc_integrate(fc_pinch *pinches, int32_t count)
{
    if (count == 1)
        run_one(pinches);
    else if (count > 1)
        run_all(pinches, count);
}
