"""When the first trigger comes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import INK, Dataset
from firstcontact.models import resampler_lookahead
from firstcontact_lab.report import names
from firstcontact_lab.report.figures.style import canvas, uri
from firstcontact_lab.report.findings import Figure

#: Triggers further from the contact than this, ms, are counted at the edges.
EDGE = 15.0


def delay_figure(
    dataset: Dataset, delays: Mapping[str, NDArray[np.float64]], early: float
) -> Figure:
    """Histogram of the first decision after the known contact (ms), by detector.

    ``early`` is how much earlier than its label a contact may be, s.
    """
    late = f" (labels may come up to {1e3 * early:g} ms late)" if early else ""
    waited = 1e3 * resampler_lookahead(dataset)
    counted = f" The resampler's look-ahead of {waited:.1f} ms is counted." if waited else ""
    known = "label" if early else "known contact"
    rate = dataset.layout.rate
    with canvas(len(delays), 1, (6.2, 1.2 + 1.4 * len(delays)), sharex=True) as (figure, axes):
        for ax, (name, values) in zip(axes[:, 0], delays.items(), strict=True):
            found = values[np.isfinite(values)] + waited
            # Whole samples to a bar, or bars would differ by what falls into them.
            width = 1e3 * max(1, round(0.0005 * rate)) / rate
            reach = np.ceil(EDGE / width - 0.5) + 0.5
            bins = width * np.arange(-reach, reach + 1)
            ax.hist(np.clip(found, bins[0], bins[-1]), bins=bins, color=names.detector(name).colour)
            ax.axvline(0, color=INK, lw=1, ls="--")
            before = int((found < -EDGE).sum())
            missed = int(sum(p.first is not None for p in dataset.pinches) - len(found))
            ax.set_title(names.detector(name).title)
            ax.text(
                0.05,
                0.93,
                f"{before:,} earlier than −{EDGE:g} ms\n{missed:,} never",
                transform=ax.transAxes,
                va="top",
                fontsize=8,
            )
            ax.set_ylabel("Pinches")
            ax.grid(axis="x", visible=False)
        axes[-1, 0].set_xlabel(f"First trigger decided, after the {known} (ms)")
        axes[-1, 0].set_xlim(-EDGE - 1, EDGE + 1)
        image = uri(figure)
    return Figure(
        "delays",
        "When the first trigger comes",
        f"Right of the dashed line: how long after the {known} the detector had decided, whichever "
        f"finger. Left of it: a trigger before the {known}{late}. The outermost bars hold all "
        f"beyond.{counted}",
        image,
    )
