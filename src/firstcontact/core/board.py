"""Resistances on the amplifier board, in ohm, for the twin, the calibration and the build page.

This module imports nothing, because KiCad's Python runs it, too.
"""

#: From a column of the force array to ground: its divider.
DIVIDER_OHM = 22000.0
#: From a row of the force array to the pin that drives it.
ROW_OHM = 330.0
#: Inside a pin that drives a row (data sheet of the i.MX RT1060).
PIN_OHM = 23.0
