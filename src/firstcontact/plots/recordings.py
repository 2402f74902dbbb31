"""Plots of pinches and datasets."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.files import replacing
from firstcontact.core.layout import ChannelKind, Finger, finger_name
from firstcontact.core.quantity import SHORE_A
from firstcontact.plots.style import PLAIN, QUIET, figure_label, new_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from firstcontact.core import Dataset, Pinch

#: Colour of each finger, distinct for colour-blind readers.
COLOURS = {Finger.INDEX: "#0b6e99", Finger.THUMB: "#d9722e", None: "#0b6e99"}
#: Most pinches in one plot, and the time shown before and after their first contacts, s.
MANY, SHOWN = 60, (0.002, 0.015)
#: Longest title, characters.
TITLE = 80
_HEIGHTS = {ChannelKind.VIBRATION: 3.0, ChannelKind.FORCE: 2.2, ChannelKind.STRIP: 0.9}


def plot_pinch(pinch: Pinch, title: str, path: Path) -> None:
    """Draw all channels of a pinch into an image file."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    # Names and units come from the recording. They must be drawn as text, not as formulas.
    with rc_context(PLAIN), replacing(path) as temporary:
        figure = Figure(layout="constrained")
        draw_pinch(pinch, figure, title)
        figure.savefig(temporary, dpi=150, format=path.suffix.lstrip(".").lower() or "png")


def draw_pinch(pinch: Pinch, figure: Figure, title: str = "") -> NDArray[Any]:
    """Draw all channels of a pinch into a figure. Return the axes, one for each kind of channel."""
    kinds = [kind for kind in _HEIGHTS if pinch.layout.columns(kind)]
    heights = [_HEIGHTS[kind] for kind in kinds]
    figure.set_size_inches(9.0, 1.1 + sum(heights))
    grid = figure.subplots(len(kinds), 1, sharex=True, squeeze=False, height_ratios=heights)
    zero = pinch.first.sample if pinch.first else pinch.first_sample
    number = pinch.first_sample + np.arange(len(pinch.data))
    time = (number - zero) / pinch.layout.rate * 1e3
    contact_times = [(c.sample - zero) / pinch.layout.rate * 1e3 for c in pinch.truth]
    for kind, axes in zip(kinds, grid[:, 0], strict=True):
        _DRAW[kind](axes, pinch, time)
        for contact, at in zip(pinch.truth, contact_times, strict=True):
            axes.axvline(at, color=COLOURS[contact.finger], lw=1, ls=(0, (4, 3)), zorder=0)
        axes.spines[["top", "right"]].set_visible(False)
        axes.margins(x=0)
        axes.grid(axis="y", color=QUIET, alpha=0.2, lw=0.6)
    grid[0, 0].margins(y=0.14)  # space for the names above the highest peak
    for contact, at, word, side in zip(
        pinch.truth, contact_times, ("first", "second"), ("right", "left"), strict=False
    ):
        grid[0, 0].annotate(
            f"{word}: {finger_name(contact.finger)}",
            (at, 1.0), xycoords=("data", "axes fraction"),
            xytext=(-4 if side == "right" else 4, -2), textcoords="offset points",
            ha=side, va="top", fontsize=9, color=COLOURS[contact.finger],
        )  # fmt: skip
    figure.align_ylabels(grid[:, 0])
    grid[0, 0].legend(loc="upper left", frameon=False, ncols=2)
    since = "first contact" if pinch.first else "the start of the pinch"
    grid[-1, 0].set_xlabel(f"time since {since} (ms)")
    figure.suptitle(figure_label(title, TITLE), x=0.02, ha="left", fontsize=12, fontweight="bold")
    return grid[:, 0]


def draw_dataset(data: Dataset, figure: Figure) -> Axes:
    """Draw the vibration after the first contact of up to 60 pinches, coloured by hardness.

    If no contact is known, draw whole pinches. Return the axes.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm, Normalize

    axes = new_axes(figure)
    quantity = next((p.label.value[0] for p in data if p.label.value), SHORE_A)
    labels = data.label_values(quantity)[~np.isnan(data.label_values(quantity))]
    ends = (labels.min(), labels.max()) if len(labels) else (0, 100)
    scale = LogNorm if quantity.is_logarithmic else Normalize
    colours = ScalarMappable(scale(*ends), "viridis_r")
    fingers, is_known = data.layout.vibration_fingers, any(pinch.first for pinch in data)
    shown = [p for p in data if not is_known or (p.first and p.first.finger in fingers)]
    shown = shown[:: -(-len(shown) // MANY) or 1]
    for pinch in shown:
        rate, first, values = pinch.layout.rate, pinch.first, pinch.vibration()
        if first is None:
            zero = begin = 0
            values = values[:, np.ptp(values, axis=0).argmax()]
        else:
            zero = first.sample - pinch.first_sample
            begin = max(zero - round(SHOWN[0] * rate), 0)
            values = values[begin : zero + round(SHOWN[1] * rate), fingers.index(first.finger)]
        hardness = getattr(pinch.label, quantity.name)
        axes.plot(
            (begin - zero + np.arange(len(values))) / rate * 1e3, values, lw=0.6, alpha=0.6,
            color=QUIET if hardness is None else colours.to_rgba(np.array(hardness)),
        )  # fmt: skip
    if len(labels):
        figure.colorbar(colours, ax=axes, label=quantity.axis)
    if shown:
        sensor = data.layout.vibration[0]
        axes.set_ylabel(f"{sensor.sensor} ({figure_label(sensor.unit, 12)})")
    axes.set_xlabel(f"time since {'first contact' if is_known else 'the start of the pinch'} (ms)")
    which = "finger that touches first" if is_known else "louder finger; no contact is known"
    axes.set_title(f"{len(shown)} of {len(data)} pinches, the {which}", loc="left")
    return axes


def _vibration(axes: Axes, pinch: Pinch, time: np.ndarray) -> None:
    values = pinch.vibration()
    for i, finger in enumerate(pinch.layout.vibration_fingers):
        axes.plot(time, values[:, i], color=COLOURS[finger], lw=0.9, label=finger_name(finger))
    first = pinch.layout.vibration[0]
    axes.set_ylabel(f"{first.sensor} ({figure_label(first.unit, 12)})")


def _force(axes: Axes, pinch: Pinch, time: np.ndarray) -> None:
    unit = ""
    for finger in Finger:
        columns = pinch.layout.columns(ChannelKind.FORCE, finger)
        if not columns:
            continue
        values = pinch.force(finger)
        axes.plot(time, values, color=COLOURS[finger], lw=0.6, alpha=0.35)
        axes.plot(time, values.mean(axis=1), color=COLOURS[finger], lw=1.6)
        unit = figure_label(pinch.layout.column_channels[columns[0]].unit, 12)
    axes.set_ylabel(f"force ({unit})" if unit else "force (raw)")
    axes.text(
        0.012, 0.95, "thin: taxels, thick: their mean", transform=axes.transAxes,
        va="top", fontsize=8, color=QUIET,
    )  # fmt: skip


def _strip(axes: Axes, pinch: Pinch, time: np.ndarray) -> None:
    for finger in Finger:
        if not pinch.layout.columns(ChannelKind.STRIP, finger):
            continue
        closed = pinch.strip(finger)[:, 0] > 0.5
        level = -float(finger)
        axes.fill_between(
            time, level - 0.3, level + 0.3, where=closed.tolist(), color=COLOURS[finger],
            step="post", lw=0,
        )  # fmt: skip
    axes.set_yticks([0.0, -1.0], [finger_name(finger) for finger in Finger])
    axes.set_ylim(-1.6, 0.6)
    axes.set_ylabel("strip closed")


_DRAW = {ChannelKind.VIBRATION: _vibration, ChannelKind.FORCE: _force, ChannelKind.STRIP: _strip}
