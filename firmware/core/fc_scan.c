#include "fc_scan.h"

void fc_scan_init(fc_scan *s)
{
    s->taxel = 0;
}

void fc_scan_next(fc_scan *s)
{
    s->taxel = (uint8_t)((s->taxel + 1) % FC_TAXELS);
}

uint8_t fc_scan_row(const fc_scan *s)
{
    return s->taxel / FC_COLUMNS;
}

uint8_t fc_scan_column(const fc_scan *s)
{
    return s->taxel % FC_COLUMNS;
}
