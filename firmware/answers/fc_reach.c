#include "fc_exact.h"
#include "fc_reach.h"

#include <math.h>
#include <stdlib.h>

/* Bounds are computed in double precision, far below its range. */
static const double MOST = 1e30, INPUTS_MOST = 6.0;

static double larger(double a, double b)
{
    return a > b ? a : b;
}

static double largest(const float *x, int32_t n)
{
    double most = 0.0;
    for (int32_t k = 0; k < n; k++)
        most = larger(most, fabs((double)x[k]));
    return most;
}

/* Return the largest output of a layer for inputs up to a bound. */
static double layer(const fc_whole *w, const float *bias, double in)
{
    const int32_t columns = (w->inputs + 3) / 4 * 4;
    double most = 0.0;
    for (int32_t i = 0; i < w->outputs; i++) {
        double sum = 0.0;
        for (int32_t k = 0; k < columns; k++)
            sum += abs(w->weight[i * columns + k]);
        most = larger(most, sum * fabs((double)w->scale[i]) * in + fabs((double)bias[i]));
    }
    return most;
}

/* Return the bound of two thin layers that replace one; infinite above MOST. */
static double pair(const fc_whole *w, const float *bias, double in)
{
    const double along = layer(w, bias, in), out = layer(w + 1, w[1].bias, along);
    return along < MOST && out < MOST ? out : INFINITY;
}

static double dense(const fc_dense *d, double in)
{
    double most = 0.0;
    for (int32_t i = 0; i < d->outputs; i++) {
        double sum = 0.0;
        for (int32_t k = 0; k < d->inputs; k++)
            sum += fabs((double)d->weight[i * d->inputs + k]);
        most = larger(most, sum * in + fabs((double)d->bias[i]));
    }
    return most;
}

static bool scaled(const fc_anytime *m)
{
    bool good = largest(m->mean, FC_NUMBERS) < MOST && largest(m->each, FC_NUMBERS) < MOST;
    for (int32_t k = 0; k < FC_NUMBERS; k++)
        good &= m->each[k] > 1.0f / (float)MOST; /* infinite inputs become bounded */
    for (int32_t k = 0; k < m->stages * FC_TRAITS; k++)
        good &= fabs(m->usual[k]) < MOST;
    return good;
}

bool fc_reach_is_bounded(const fc_anytime *m)
{
    const double hidden = pair(m->query1, m->query1[0].bias, INPUTS_MOST);
    const double query = pair(m->query2, m->query2[0].bias, hidden);
    bool good = scaled(m) && query < MOST;
    for (int32_t k = 0; good && k < m->rigs; k++) {
        const fc_rig *const r = m->rig + k;
        const int32_t directions = m->body1[0].outputs, known = m->stages * FC_FOUND * r->levels;
        const double found = larger(hidden, largest(r->values, known));
        double body = 0.0;
        for (int32_t s = 0; s < m->stages; s++)
            body = larger(body, pair(m->body1, r->along + s * directions, found));
        body = pair(m->body2, m->body2[0].bias, body);
        body = pair(m->body3, m->body3[0].bias, body);
        good = query * largest(r->keys, known) * FC_FOUND < MOST && dense(&m->answer, body) < MOST;
    }
    return good;
}
