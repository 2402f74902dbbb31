"""What both detectors say of one pinch."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from firstcontact.contact import WindowDecisions, WindowDetector
from firstcontact.core import GREY, INK, ORANGE, RED, Pinch
from firstcontact_lab.report import names
from firstcontact_lab.report.figures.style import canvas, uri, vibration_axis
from firstcontact_lab.report.findings import Figure


def detectors_figure(
    pinch: Pinch,
    verdicts: Mapping[str, WindowDecisions],
    start: int,
    early: float = 0.0,
    before: float = 0.090,
    after: float = 0.030,
) -> Figure:
    """Vibration of the finger that touched first, the 3σ band, and the windows that fired.

    ``start`` is the sample at which the closing starts, and with it the steady state;
    ``early`` how much earlier than its label a contact may be, s.
    """
    assert pinch.first is not None
    rate, fingers = pinch.layout.rate, pinch.layout.vibration_fingers
    column = fingers.index(pinch.first.finger) if pinch.first.finger in fingers else 0
    label, factor = vibration_axis(pinch.layout, milli=True)
    values = factor * pinch.vibration()[:, column]
    numbers = pinch.first_sample + np.arange(len(values))
    time = 1e3 * (numbers - pinch.first.sample) / rate
    shown = (time >= -1e3 * before) & (time <= 1e3 * after)
    steady = values[start - pinch.first_sample :][: WindowDetector.sizes(rate).steady]
    if not len(steady) or np.ptp(steady) == 0.0:
        steady = values  # nothing to measure: the picture is drawn all the same
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
            time[shown],
            values[shown],
            color=INK,
            lw=1.0,
            label=pinch.layout.vibration[column].sensor,
        )
        # Zoomed to where detectors decide: the contact itself runs out of the picture.
        top.set_ylim(mean - 12 * sigma, mean + 20 * sigma)
        top.set_ylabel(label)
        top.legend(loc="upper left", ncols=2)
        for row, (name, verdict) in enumerate(verdicts.items()):
            ends = 1e3 * (verdict.ends - pinch.first.sample) / rate
            fired = verdict.fired[:, column]
            inside = (ends >= -1e3 * before) & (ends <= 1e3 * after)
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
        low.set_yticks(range(len(verdicts)), [names.detector(n).title for n in verdicts])
        low.set_ylim(len(verdicts) - 0.4, -0.6)
        low.grid(axis="y", visible=False)
        low.set_xlabel(f"Time after the {'label' if early else 'known contact'} (ms)")
        for ax in (top, low):
            ax.axvline(0, color=RED, lw=1.2, ls="--")
        image = uri(figure)
    return Figure(
        "detectors",
        "What the detectors say",
        "One pinch, zoomed to its noise. Below, each circle is a 20 ms window, drawn at its end; "
        "filled: the detector says contact. "
        + (
            f"The dashed line is the label, up to {1e3 * early:g} ms after the contact; a filled "
            "circle further left than that is a false alarm."
            if early
            else "The dashed line is the known contact; a filled circle left of it is a false "
            "alarm."
        ),
        image,
    )
