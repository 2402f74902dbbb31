"""Time from the first to the second contact."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import BLUE, GREY, INK, RED, percent
from firstcontact.models import DURATION
from firstcontact_lab.report import _published as published
from firstcontact_lab.report.figures.style import canvas, uri
from firstcontact_lab.report.findings import Figure


def offset_figure(offsets: NDArray[np.float64]) -> Figure:
    """Histogram of offsets (ms) with mean and SD, here and published."""
    mean, sd = float(offsets.mean()), float(offsets.std(ddof=min(1, len(offsets) - 1)))
    window = 1e3 * DURATION
    with canvas() as (figure, axes):
        ax = axes[0, 0]
        top = max(60.0, float(np.ceil(offsets.max() / 10) * 10))
        bins = np.arange(0.0, top + 2.5, 2.5)
        counts, _, bars = ax.hist(offsets, bins=bins, color=BLUE, edgecolor="white", linewidth=0.6)
        for left, bar in zip(bins[:-1], bars, strict=False):
            if left + 1.25 < window:
                bar.set_alpha(0.55)
        height = float(counts.max())
        ax.axvline(window, color=INK, lw=1, ls=":")
        ax.text(
            window + 0.6, height * 1.42, "end of the 15 ms window", fontsize=8, va="top", color=INK
        )
        for level, m, s, colour, name in (
            (1.12, mean, sd, BLUE, "here"),
            (1.24, published.OFFSET_MEAN, published.OFFSET_SD, RED, "published"),
        ):
            ax.errorbar(
                m,
                height * level,
                xerr=s,
                fmt="o",
                color=colour,
                capsize=3,
                ms=5,
                label=f"{name}: {m:.2f} ± {s:.2f} ms",
            )
        ax.set(
            xlabel="Offset from first to second contact (ms)",
            ylabel="Pinches",
            xlim=(0, top),
            ylim=(0, height * 1.45),
        )
        ax.grid(axis="x", visible=False)
        ax.legend(loc="upper right", title="mean ± SD", title_fontsize=8.5)
        ax.spines["left"].set_color(GREY)
        image = uri(figure)
    share = (offsets < window).mean()
    return Figure(
        "offsets",
        "Time between the two contacts",
        f"{len(offsets):,} pinches. In {percent(share, 0)} of them (pale bars) the second contact "
        "falls inside the 15 ms window that stiffness is read from.",
        image,
    )
