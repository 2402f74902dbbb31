#include "fc_pace.h"

void fc_pace_init(fc_pace *p, uint32_t clock_hz, uint32_t rate_hz)
{
    p->whole = clock_hz / rate_hz;
    p->rest = clock_hz % rate_hz;
    p->rate = rate_hz;
    p->sum = 0;
}

uint32_t fc_pace_next(fc_pace *p)
{
    p->sum += p->rest;
    if (p->sum < p->rate)
        return p->whole;
    p->sum -= p->rate;
    return p->whole + 1u;
}
