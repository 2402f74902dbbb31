"""Percentages for tables, pages and the terminal."""

from __future__ import annotations

#: Largest number of decimals. It is used if fewer would round a share below 1 up to 100 %.
MOST_DECIMALS = 2


def percent(share: float, decimals: int = 1) -> str:
    """Return a share as a percentage that is never rounded up to 100.

    Parameters
    ----------
    share
        Fraction between 0 and 1.
    decimals
        Number of decimals. A share just below 1 is shown with up to two decimals and not rounded
        up.
    """
    for places in range(decimals, MOST_DECIMALS + 1):
        text = f"{100 * share:.{places}f}"
        if share >= 1 or float(text) < 100:
            return f"{text} %"
    return "99.99 %"
