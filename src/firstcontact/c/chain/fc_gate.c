#include "fc_gate.h"

#include <string.h>

#include "fc_assert.h"
#include "fc_math.h"

/* Fewest steps for which the motor has run when most of FC_GATE_STEPS steps are loud. */
enum { HEARD_SINCE = FC_GATE_STEPS / 2 };

/* Rise of a taxel above its lowest voltage at rest that counts as a load, V. Velostat conducts at
   some 0.1 N less. After a firm grip, creep keeps the voltage 0.1 V too high for a second. */
static const double LOADED = 0.3;

void fc_gate_restart(fc_gate *g, int64_t first, bool is_same_epoch)
{
    /* Within an epoch, steps stay on one grid. So lost samples do not move later decisions. */
    const int64_t past = (g->grid - first) % g->step;
    g->skipped = is_same_epoch ? (int32_t)(past < 0 ? past + g->step : past) : 0;
    g->grid = first + g->skipped;
    g->state = FC_GATE_LOST;
    g->is_open = g->is_due = g->has_unloaded = false;
    g->steps = g->since = 0;
    g->held = -FC_GATE_STEPS;
    g->refused = g->waiting = g->newest = 0;
    memset(g->sums, 0, sizeof g->sums);
    memset(g->load_sums, 0, sizeof g->load_sums);
}

void fc_gate_touched(fc_gate *g, int64_t sample)
{
    if (g->is_by_hand) {
        g->is_due = true;
        g->due = sample + g->rearm;
    }
}

static double median(const double *x)
{
    double sorted[FC_GATE_STEPS];
    for (int32_t i = 0; i < FC_GATE_STEPS; i++) {
        int32_t place = i;
        for (; place > 0 && (sorted[place - 1] > x[i] || isnan(sorted[place - 1])); place--)
            sorted[place] = sorted[place - 1];
        sorted[place] = x[i];
    }
    return sorted[FC_GATE_STEPS / 2];
}

/* Return true if the median power of the newest steps is that of rest. */
static bool is_quiet(const fc_gate *g)
{
    if (g->steps + 1 < FC_GATE_STEPS)
        return false;
    for (int32_t c = 0; c < g->channels; c++) {
        double totals[FC_GATE_STEPS], power[FC_GATE_STEPS];
        for (int32_t k = 0; k < FC_GATE_STEPS; k++)
            totals[k] = g->sums[k].volts[c];
        const double mean = median(totals) / g->step;
        for (int32_t k = 0; k < FC_GATE_STEPS; k++)
            power[k] = (g->sums[k].squares[c] - 2.0 * mean * totals[k]) / g->step + mean * mean;
        if (!(median(power) <= g->limit[c]))
            return false;
    }
    return true;
}

static bool is_loaded(const fc_gate *g)
{
    for (int32_t k = 0; g->has_unloaded && k < g->taxels; k++)
        if (g->load_sums[k] / g->step > g->unloaded[k] + LOADED)
            return true;
    return false;
}

static void learn_unloaded(fc_gate *g)
{
    for (int32_t k = 0; k < g->taxels; k++) {
        const double load = g->load_sums[k] / g->step;
        if (!g->has_unloaded || load < g->unloaded[k] || isnan(g->unloaded[k]))
            g->unloaded[k] = load;
    }
    g->has_unloaded = true;
}

static void go(fc_gate *g, fc_gate_state state)
{
    g->state = state;
    g->since = g->steps;
}

static fc_gate_turn reopen(fc_gate *g)
{
    const bool was_open = g->is_open;
    g->is_open = true;
    g->is_due = false;
    g->refused = 0;
    return was_open ? FC_GATE_SHUTS_AND_OPENS : FC_GATE_OPENS;
}

/* Change the state after a complete step. */
static fc_gate_turn decide(fc_gate *g)
{
    const bool quiet = is_quiet(g);
    const bool may_open = !g->is_due || g->grid + g->step >= g->due;
    if (g->state == FC_GATE_LOST || g->state == FC_GATE_OPEN) {
        /* The steady state of the motor must be younger than the opening of the gate. */
        if (!quiet || !may_open || g->steps - g->since < FC_GATE_STEPS)
            return FC_GATE_STAYS;
        go(g, FC_GATE_REST);
        if (g->is_by_hand)
            return reopen(g);
        const bool was_open = g->is_open;
        g->is_open = false;
        return was_open ? FC_GATE_SHUTS : FC_GATE_STAYS;
    }
    if (quiet) {
        if (g->state == FC_GATE_STARTING) {
            g->refused += g->held >= g->since && g->steps - g->since >= FC_GATE_STEPS;
            go(g, FC_GATE_REST);
        }
        learn_unloaded(g);
        return g->is_due && may_open ? reopen(g) : FC_GATE_STAYS;
    }
    if (g->state == FC_GATE_REST) {
        go(g, FC_GATE_STARTING);
        g->since -= HEARD_SINCE;
        return FC_GATE_STAYS;
    }
    if (is_loaded(g))
        g->held = g->steps;
    const int64_t last = g->held > g->since ? g->held : g->since;
    if (!may_open || g->steps - last < FC_GATE_STEPS)
        return FC_GATE_STAYS;
    go(g, FC_GATE_OPEN);
    return reopen(g);
}

fc_gate_turn fc_gate_take(fc_gate *g, const double *vibration, const double *loads)
{
    FC_ASSERT(g != NULL && vibration != NULL);
    if (g->skipped > 0) {
        g->skipped--;
        return FC_GATE_STAYS;
    }
    fc_step *const sums = g->sums + g->newest;
    for (int32_t c = 0; c < g->channels; c++) {
        sums->volts[c] += vibration[c];
        sums->squares[c] += vibration[c] * vibration[c];
    }
    for (int32_t k = 0; k < g->taxels; k++)
        g->load_sums[k] += loads[k];
    if (++g->waiting < g->step)
        return FC_GATE_STAYS;
    const fc_gate_turn turn = decide(g);
    g->steps++;
    g->grid += g->step;
    g->waiting = 0;
    g->newest = (g->newest + 1) % FC_GATE_STEPS;
    memset(g->sums + g->newest, 0, sizeof *g->sums);
    memset(g->load_sums, 0, sizeof g->load_sums);
    return turn;
}
