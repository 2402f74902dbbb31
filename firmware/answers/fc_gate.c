#include "fc_exact.h"
#include "fc_gate.h"

#include <string.h>

enum { LOST, REST, STARTING, OPEN };
/* RUNNING: ratio to the noise floor above which a motor runs. LOADED: rise of a taxel above its
   lowest level at rest that counts as load, V. */
static const double RUNNING = 1.4, LOADED = 0.3;

void fc_gate_start(fc_gate *g, const double *floors, uint32_t begun)
{
    memset(g, 0, sizeof *g);
    for (int f = 0; f < FC_SENSORS; f++)
        g->limit[f] = (RUNNING * floors[f]) * (RUNNING * floors[f]);
    g->held = (uint32_t)-FC_GATE_STEPS;
    g->skipped = (FC_GATE_STEP - (int32_t)(begun % FC_GATE_STEP)) % FC_GATE_STEP;
    g->state = LOST;
}

static double median(const double *x)
{
    double ordered[FC_GATE_STEPS];
    for (int k = 0; k < FC_GATE_STEPS; k++) {
        int place = k;
        for (; place > 0 && ordered[place - 1] > x[k]; place--)
            ordered[place] = ordered[place - 1];
        ordered[place] = x[k];
    }
    return ordered[FC_GATE_STEPS / 2];
}

/* Return true if most of the last 13 steps are at rest, around their common mean. */
static bool quiet(const fc_gate *g)
{
    if (g->steps + 1 < FC_GATE_STEPS)
        return false;
    for (int f = 0; f < FC_SENSORS; f++) {
        double total[FC_GATE_STEPS], power[FC_GATE_STEPS];
        for (int k = 0; k < FC_GATE_STEPS; k++)
            total[k] = g->sum[k][f];
        const double mean = median(total) / FC_GATE_STEP;
        for (int k = 0; k < FC_GATE_STEPS; k++)
            power[k] = (g->square[k][f] - 2.0 * mean * g->sum[k][f]) / FC_GATE_STEP + mean * mean;
        if (!(median(power) <= g->limit[f]))
            return false;
    }
    return true;
}

static bool loaded(const fc_gate *g)
{
    for (int k = 0; g->rested && k < FC_LOADS; k++)
        if (g->load[k] > g->unloaded[k] + LOADED)
            return true;
    return false;
}

static void learn_unloaded(fc_gate *g)
{
    for (int k = 0; k < FC_LOADS; k++)
        if (!g->rested || g->load[k] < g->unloaded[k])
            g->unloaded[k] = g->load[k];
    g->rested = true;
}

static void go(fc_gate *g, int8_t state)
{
    g->state = state;
    g->since = g->steps;
}

static bool passed(uint32_t now, uint32_t then)
{
    return (int32_t)(now - then) >= FC_GATE_STEPS;
}

static fc_turn turn(fc_gate *g)
{
    const bool rests = quiet(g);
    if (g->state == LOST || g->state == OPEN) {
        /* The steady state of the motor must be younger than the gate's opening. */
        if (!rests || !passed(g->steps, g->since))
            return FC_STAYS;
        go(g, REST);
        return g->open ? FC_SHUTS : FC_STAYS;
    }
    if (rests) {
        if (g->state == STARTING)
            go(g, REST);
        learn_unloaded(g);
        return FC_STAYS;
    }
    if (g->state == REST) {
        go(g, STARTING);
        g->since -= FC_GATE_STEPS / 2;
        return FC_STAYS;
    }
    if (loaded(g))
        g->held = g->steps;
    if (!passed(g->steps, g->since) || !passed(g->steps, g->held))
        return FC_STAYS;
    go(g, OPEN);
    return FC_OPENS;
}

fc_turn fc_gate_take(fc_gate *g, const double *volts, const double *loads)
{
    if (g->skipped > 0) {
        g->skipped--;
        return FC_STAYS;
    }
    for (int f = 0; f < FC_SENSORS; f++) {
        g->adding[f] += volts[f];
        g->adding_square[f] += volts[f] * volts[f];
    }
    for (int k = 0; k < FC_LOADS; k++)
        g->adding_load[k] += loads[k];
    if (++g->waiting < FC_GATE_STEP)
        return FC_STAYS;
    memmove(g->sum[0], g->sum[1], sizeof g->sum - sizeof g->sum[0]);
    memmove(g->square[0], g->square[1], sizeof g->square - sizeof g->square[0]);
    for (int f = 0; f < FC_SENSORS; f++) {
        g->sum[FC_GATE_STEPS - 1][f] = g->adding[f];
        g->square[FC_GATE_STEPS - 1][f] = g->adding_square[f];
        g->adding[f] = g->adding_square[f] = 0.0;
    }
    for (int k = 0; k < FC_LOADS; k++) {
        g->load[k] = g->adding_load[k] / FC_GATE_STEP;
        g->adding_load[k] = 0.0;
    }
    g->waiting = 0;
    const fc_turn found = turn(g);
    g->steps++;
    if (found != FC_STAYS)
        g->open = found == FC_OPENS;
    return found;
}
