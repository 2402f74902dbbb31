"""Figures of contact detection: delays in all pinches, and decisions in one pinch."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import WindowDecisions, WindowDetector
from firstcontact.core import GREY, INK, ORANGE, RED, Dataset, Pinch
from firstcontact.models import resampler_lookahead
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import Figure
from firstcontact_lab.report.style import canvas, uri, vibration_axis

#: Triggers further from the contact than this, ms, are counted at the edges.
EDGE = 15.0


def delay_figure(
    dataset: Dataset, delays: Mapping[str, NDArray[np.float64]], early: float
) -> Figure:
    """Draw a histogram for each detector: time from the known contact to the first decision."""
    late = f" (labels may come up to {1e3 * early:g} ms late)" if early else ""
    waited = 1e3 * resampler_lookahead(dataset)
    counted = f" The resampler's look-ahead of {waited:.1f} ms is counted." if waited else ""
    zero = "label" if early else "known contact"
    rate = dataset.layout.rate
    with canvas(len(delays), 1, (6.2, 1.2 + 1.4 * len(delays)), sharex=True) as (figure, axes):
        for ax, (name, values) in zip(axes[:, 0], delays.items(), strict=True):
            detections = values[np.isfinite(values)] + waited
            # Each bar covers a whole number of samples, the same number in each bar.
            width = 1e3 * max(1, round(0.0005 * rate)) / rate
            reach = np.ceil(EDGE / width - 0.5) + 0.5
            bins = width * np.arange(-reach, reach + 1)
            ax.hist(
                np.clip(detections, bins[0], bins[-1]),
                bins=bins,
                color=names.detector(name).colour,
            )
            ax.axvline(0, color=INK, lw=1, ls="--")
            n_early = int((detections < -EDGE).sum())
            missed = int(sum(p.first is not None for p in dataset.pinches) - len(detections))
            ax.set_title(names.detector(name).title)
            ax.text(
                0.05,
                0.93,
                f"{n_early:,} earlier than −{EDGE:g} ms\n{missed:,} never",
                transform=ax.transAxes,
                va="top",
                fontsize=8,
            )
            ax.set_ylabel("Pinches")
            ax.grid(axis="x", visible=False)
        axes[-1, 0].set_xlabel(f"First decision after the {zero} (ms)")
        axes[-1, 0].set_xlim(-EDGE - 1, EDGE + 1)
        image = uri(figure)
    return Figure(
        "delays",
        "Time of the first detection",
        f"Decisions left of the line ({zero}) came too early{late}. The outermost bars contain all "
        f"decisions beyond the axis.{counted}",
        image,
    )


def detectors_figure(
    pinch: Pinch,
    decisions: Mapping[str, WindowDecisions],
    start: int,
    early: float = 0.0,
    n_early: float = 0.090,
    suffix: float = 0.030,
) -> Figure:
    """Draw the vibration of the first finger, its 3σ band, and where each detector fired."""
    assert pinch.first is not None
    rate, fingers = pinch.layout.rate, pinch.layout.vibration_fingers
    column = fingers.index(pinch.first.finger) if pinch.first.finger in fingers else 0
    label, factor = vibration_axis(pinch.layout, milli=True)
    values = factor * pinch.vibration()[:, column]
    numbers = pinch.first_sample + np.arange(len(values))
    time = 1e3 * (numbers - pinch.first.sample) / rate
    visible = (time >= -1e3 * n_early) & (time <= 1e3 * suffix)
    steady = values[start - pinch.first_sample :][: WindowDetector.sizes(rate).steady]
    if not len(steady) or np.ptp(steady) == 0.0:
        steady = values  # without a steady state, draw the figure with the whole signal
    mean, sigma = float(steady.mean()), float(steady.std()) or 1.0
    with canvas(2, 1, (6.2, 4.2), sharex=True, gridspec_kw={"height_ratios": [3, 1]}) as (
        figure,
        axes,
    ):
        top, low = axes[:, 0]
        top.axhspan(
            mean - 3 * sigma,
            mean + 3 * sigma,
            color=ORANGE,
            alpha=0.15,
            lw=0,
            label="±3σ of the steady state",
        )
        top.plot(
            time[visible],
            values[visible],
            color=INK,
            lw=1.0,
            label=pinch.layout.vibration[column].sensor,
        )
        # The axis shows the level at which detectors decide; the contact itself exceeds it.
        top.set_ylim(mean - 12 * sigma, mean + 20 * sigma)
        top.set_ylabel(label)
        top.legend(loc="upper left", ncols=2)
        for row, (name, decision) in enumerate(decisions.items()):
            ends = 1e3 * (decision.ends - pinch.first.sample) / rate
            fired = decision.fired[:, column]
            inside = (ends >= -1e3 * n_early) & (ends <= 1e3 * suffix)
            low.scatter(
                ends[inside & ~fired],
                np.full((inside & ~fired).sum(), row),
                s=12,
                facecolors="none",
                edgecolors=GREY,
                lw=0.7,
            )
            low.scatter(
                ends[inside & fired],
                np.full((inside & fired).sum(), row),
                s=22,
                color=names.detector(name).colour,
            )
        low.set_yticks(range(len(decisions)), [names.detector(n).title for n in decisions])
        low.set_ylim(len(decisions) - 0.4, -0.6)
        low.grid(axis="y", visible=False)
        low.set_xlabel(f"Time after the {'label' if early else 'known contact'} (ms)")
        for ax in (top, low):
            ax.axvline(0, color=RED, lw=1.2, ls="--")
        image = uri(figure)
    return Figure(
        "detectors",
        "Decisions of the detectors in one pinch",
        "Each circle is a 20 ms window, drawn at its end; filled where the detector reports a "
        "contact. "
        + (
            f"The dashed line is the label, up to {1e3 * early:g} ms after the contact; a filled "
            "circle further left than that is a false alarm."
            if early
            else "The dashed line is the known contact; a filled circle left of it is a false "
            "alarm."
        ),
        image,
    )
