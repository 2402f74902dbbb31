"""Constants of the loudness features: levels of a window's newest samples."""

from __future__ import annotations

from firstcontact.signal import samples_in

#: Lengths of the newest parts, s: from two samples to three milliseconds.
PARTS = (0.0004, 0.0008, 0.0014, 0.0022, 0.003)
#: Length of the recent part at the end of a window, s. The rest is the quiet part.
RECENT = 0.006
#: Order of the linear prediction.
ORDER = 12
#: Added to a level, in sigmas, before its logarithm. Smaller levels do not matter.
FLOOR = 0.1
#: Number of features of the signal, and of its prediction error.
EACH = len(PARTS) + 3


def parts(rate: float) -> list[int]:
    """Return the lengths of spans that end with a window, ascending, in samples."""
    lengths: list[int] = []
    for part in (*PARTS, RECENT):
        lengths.append(max(samples_in(part, rate), lengths[-1] + 1 if lengths else 1))
    return lengths
