"""One pinch: both fingers, all kinds of sensors."""

from __future__ import annotations

import numpy as np

from firstcontact.core import BLUE, INK, ORANGE, ChannelKind, Finger, Pinch, finger_name
from firstcontact_lab.report.figures.style import canvas, uri, vibration_axis
from firstcontact_lab.report.findings import Figure

COLOURS = {Finger.INDEX: BLUE, Finger.THUMB: ORANGE, None: BLUE}


def timing_figure(pinch: Pinch, before: float = 0.030, after: float = 0.110) -> Figure:
    """Vibration and, where there, force of both fingers around the contacts of a pinch.

    ``before`` and ``after`` are seconds around the first contact, which the
    pinch must have.
    """
    rows = 2 if pinch.layout.has_force else 1
    rate = pinch.layout.rate
    assert pinch.first is not None
    zero = pinch.first.sample - pinch.first_sample
    time = 1e3 * (np.arange(len(pinch.data)) - zero) / rate
    shown = (time >= -1e3 * before) & (time <= 1e3 * after)
    with canvas(rows, 1, (6.2, 4.4 if rows == 2 else 3.2), sharex=True) as (figure, axes):
        for column, finger in enumerate(pinch.layout.vibration_fingers):
            volts = pinch.vibration()[:, column]
            axes[0, 0].plot(
                time[shown], volts[shown], color=COLOURS[finger], lw=1.1, label=finger_name(finger)
            )
        axes[0, 0].set_ylabel(vibration_axis(pinch.layout)[0])
        axes[0, 0].legend(loc="lower right", ncols=2)
        if rows == 2:
            for finger in Finger:
                if pinch.layout.columns(ChannelKind.FORCE, finger):
                    total = pinch.force(finger).mean(axis=1)
                    axes[1, 0].plot(time[shown], total[shown], color=COLOURS[finger])
            axes[1, 0].set_ylabel("Force array,\nmean of taxels (V)")
        axes[-1, 0].set_xlabel("Time after the first contact (ms)")
        for number, contact in enumerate(pinch.truth[:2]):
            at = 1e3 * (contact.sample - pinch.truth[0].sample) / rate
            for ax in axes[:, 0]:
                ax.axvline(at, color=COLOURS[contact.finger], lw=1, ls="--")
            axes[0, 0].annotate(
                ("first contact", "second contact")[number],
                (at, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(2 if number == 0 else -2, 3),  # above the axes: no trace is there
                textcoords="offset points",
                ha="right" if number == 0 else "left",
                fontsize=8,
                color=INK,
            )
        image = uri(figure)
    sensor = pinch.layout.vibration[0].sensor
    what = f"{sensor} and force" if rows == 2 else sensor
    name = pinch.label.specimen or pinch.label.object or "an object"
    return Figure(
        "timing",
        "One pinch, both fingers",
        f"A pinch of {name}, the one whose offset is the closest to the mean: {what} traces, with "
        "the known contacts as dashed lines in the colour of the finger.",
        image,
    )
