"""Materials in their order of hardness."""

from __future__ import annotations

import numpy as np

from firstcontact.core import BLUE, GREY, INK, RED, percent
from firstcontact.models import ClassificationScores, LabelledWindows, Values
from firstcontact.recording import figure_label
from firstcontact_lab.report.figures.style import canvas, shades, uri
from firstcontact_lab.report.findings import Figure


def hardness_figure(data: LabelledWindows, centroid: Values) -> Figure:
    """Spectral centroid of every pinch, a row a material."""
    materials = sorted(
        set(data.objects.tolist()),
        key=lambda m: (float(data.y[data.objects == m].mean()), m),
    )
    ranks = np.unique(data.y)
    colours = dict(zip(ranks.tolist(), shades(len(ranks)), strict=True))
    rng = np.random.default_rng(0)
    with canvas(size=(6.2, 1.2 + 0.42 * len(materials))) as (figure, axes):
        ax = axes[0, 0]
        for row, material in enumerate(materials):
            its = data.objects == material
            colour = colours[float(data.y[its][0])]
            values = centroid[its]
            ax.scatter(
                values,
                row + rng.uniform(-0.18, 0.18, len(values)),
                s=16,
                color=colour,
                alpha=0.7,
                lw=0,
            )
            ax.plot([values.mean()] * 2, [row - 0.32, row + 0.32], color=INK, lw=2)
        labels = [
            f"{figure_label(m.replace('_', ' '))}  (rank {data.y[data.objects == m].mean():g})"
            for m in materials
        ]
        ax.set_yticks(range(len(materials)), labels, fontsize=8.5)
        ax.set(
            xlabel="Spectral centroid of the first 15 ms (Hz)", ylim=(-0.6, len(materials) - 0.4)
        )
        ax.grid(axis="y", visible=False)
        image = uri(figure)
    return Figure(
        "hardness",
        "Order of hardness, nothing learned",
        "One point a pinch; bars are the means that the rank correlation is taken over. The score "
        "was declared beforehand: a harder surface is expected further to the right.",
        image,
    )


def materials_figure(left_out: ClassificationScores, random: ClassificationScores) -> Figure:
    """Accuracy with a material left out, beside random folds and the best constant prediction."""
    chance = left_out.best_constant
    with canvas(size=(6.2, 2.6)) as (figure, axes):
        ax = axes[0, 0]
        rows = [
            ("material left out", left_out, BLUE),
            ("random folds (not to be trusted)", random, GREY),
        ]
        for row, (_, scores, colour) in enumerate(rows):
            ax.barh(row, 100 * scores.accuracy, color=colour, height=0.55)
            ends = scores.intervals.get("accuracy")
            if ends:
                ax.plot([100 * e for e in ends], [row, row], color=INK, lw=1.2)
            ax.text(
                2,
                row,
                percent(scores.accuracy, 0),
                va="center",
                color="white",
                fontweight="bold",
                fontsize=9,
            )
        ax.axvline(100 * chance, color=RED, ls="--", lw=1.2)
        ax.text(
            100 * chance + 1,
            1.62,
            f"best constant {percent(chance, 0)}",
            color=RED,
            fontsize=8.5,
            va="top",
        )
        ax.set_yticks(range(len(rows)), [name for name, _, _ in rows])
        ax.set(xlabel="Accuracy of the hardness class (%)", xlim=(0, 100), ylim=(-0.5, 1.7))
        ax.grid(axis="y", visible=False)
        image = uri(figure)
    return Figure(
        "materials",
        "A material left out",
        "Random folds let a model recognise the material it learned from. With the whole "
        "material left out, the question is about hardness. Lines are 95 % intervals (materials "
        "drawn whole).",
        image,
    )
