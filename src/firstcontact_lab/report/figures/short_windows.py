"""Classes of hardness from short windows, of materials that were left out."""

from __future__ import annotations

import numpy as np

from firstcontact.core import BLUE, GREY, INK, ORANGE, RED
from firstcontact.recording import figure_label
from firstcontact_lab.report import names
from firstcontact_lab.report.figures.style import canvas, shades, uri
from firstcontact_lab.report.findings import Figure
from firstcontact_lab.report.results.real import Reading, RealMaterial, RealSet


def accuracy_figure(found: RealSet) -> Figure:
    """A line for each reading against the length of the window."""
    lengths = [float(ms) for ms in found.material_held_out]
    with canvas(size=(6.2, 4.0)) as (figure, axes):
        ax = axes[0, 0]
        for number, reading in enumerate(found.readings):
            first = number == 0
            ax.plot(
                lengths,
                [100 * share for share in reading.material_held_out.values()],
                color=_colour(reading, found.readings[0]),
                ls="--" if reading.known_contacts and not first else "-",
                marker="o",
                ms=6 if first else 4,
                lw=2.4 if first else 1.3,
                label=_label(reading),
                zorder=3 if first else 2,
            )
        ax.axhline(100 * found.chance, color=RED, ls=":", lw=1.2, label="constant prediction")
        ax.set_xticks(lengths, [f"{ms:g}" for ms in lengths])
        ax.set(xlabel="Length of the window (ms)", ylabel="Balanced accuracy (%)", ylim=(0, 103))
        figure.legend(loc="outside lower center", ncols=1)
        image = uri(figure)
    return Figure(
        "short",
        "Hardness from the first milliseconds",
        "Each material was left out of what its model learned from. Balanced: the mean over "
        "materials, then over classes.",
        image,
    )


def by_material_figure(found: RealSet) -> Figure:
    """Accuracy of each material at each length, as a map with numbers."""
    lengths = list(found.material_held_out)
    order = _sorted(found)
    shares = np.array([[100 * its.accuracy.get(ms, np.nan) for ms in lengths] for _, its in order])
    with canvas(size=(6.2, 1.3 + 0.42 * len(order))) as (figure, axes):
        ax = axes[0, 0]
        ax.imshow(shares, cmap="cividis", vmin=0, vmax=100, aspect="auto")
        for (row, column), share in np.ndenumerate(shares):
            if np.isfinite(share):
                dark = INK if share > 60 else "white"
                ax.text(column, row, f"{share:.0f}", ha="center", va="center", color=dark)
        ax.set_xticks(range(len(lengths)), [f"{ms} ms" for ms in lengths])
        ax.set_yticks(range(len(order)), [_named(m, its) for m, its in order], fontsize=8.5)
        ax.set(xlabel="Length of the window; numbers are % classed right")
        ax.grid(visible=False)
        image = uri(figure)
    return Figure(
        "short-materials",
        "Which materials are told when they were never met",
        f"{_label(found.readings[0])}. Softest above. A row near 0 % is a material that sounds "
        "like those of another class.",
        image,
    )


def order_figure(found: RealSet) -> Figure:
    """Mean centroid of each material, as sent and behind the published conditioning."""
    order = _sorted(found)[::-1]
    ranks = sorted({its.rank for _, its in order})
    colours = dict(zip(ranks, shades(len(ranks)), strict=True))
    with canvas(size=(6.2, 1.6 + 0.42 * len(order))) as (figure, axes):
        ax = axes[0, 0]
        for row, (_, its) in enumerate(order):
            ends = [its.conditioned_centroid_hz, its.centroid_hz]
            ax.plot(ends, [row, row], color=GREY, lw=1.2, zorder=1)
            ax.scatter(ends[1], row, s=60, color=[colours[its.rank]], zorder=2, lw=0)
            ax.scatter(
                ends[0], row, s=42, facecolor="white", edgecolor=[colours[its.rank]], lw=1.8,
                zorder=2,
            )  # fmt: skip
        ax.scatter([], [], s=60, color=GREY, label="signal as sent")
        ax.scatter([], [], s=42, facecolor="white", edgecolor=GREY, lw=1.8,
                   label="behind the published smoothing")  # fmt: skip
        ax.set_yticks(range(len(order)), [_named(m, its) for m, its in order], fontsize=8.5)
        ax.set(xlabel="Spectral centroid of the first 15 ms (Hz)", ylim=(-0.6, len(order) - 0.4))
        ax.set_xlim(left=0)
        ax.grid(axis="y", visible=False)
        figure.legend(loc="outside lower center", ncols=2)
        image = uri(figure)
    return Figure(
        "short-order",
        "What the smoothing leaves of the order",
        "Means of the materials, softest above, coloured by rank. Nothing was fitted; a harder "
        "material is expected further to the right.",
        image,
    )


def _label(reading: Reading) -> str:
    signal = "published smoothing" if reading.conditioned else "signal as sent"
    start = "labelled" if reading.known_contacts else "detected"
    return f"{names.estimator(reading.estimator).title}, {signal}, {start} contacts"


def _colour(reading: Reading, first: Reading) -> str:
    if reading.estimator != first.estimator:
        return names.estimator(reading.estimator).colour if not reading.conditioned else GREY
    return ORANGE if reading.conditioned else BLUE


def _sorted(found: RealSet) -> list[tuple[str, RealMaterial]]:
    return sorted(found.by_material.items(), key=lambda i: (i[1].rank, i[0]))


def _named(material: str, its: RealMaterial) -> str:
    return f"{figure_label(material.replace('_', ' '))}  (rank {its.rank:g})"
