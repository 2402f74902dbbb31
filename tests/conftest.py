"""What all tests share."""

from __future__ import annotations

import os

from hypothesis import settings

# Tests assert no times: neither here nor by the way.
settings.register_profile("firstcontact", deadline=None)
settings.load_profile("firstcontact")

# Figures are drawn to files; no test needs a display.
os.environ["MPLBACKEND"] = "Agg"
