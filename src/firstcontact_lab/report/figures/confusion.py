"""What is mistaken for what."""

from __future__ import annotations

import numpy as np

from firstcontact.core import INK, percent
from firstcontact_lab.report import names
from firstcontact_lab.report.figures.style import canvas, uri
from firstcontact_lab.report.findings import Figure
from firstcontact_lab.report.results.stiffness import SplitScores


def confusion_figure(model: str, split: str, scores: SplitScores, unit: str = "Shore A") -> Figure:
    """Confusion matrix of a classification, rows as shares of the true class."""
    counts = np.array(scores.confusion)
    share = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    ticks = [f"{c:g}" if isinstance(c, float) else str(c) for c in scores.classes or ()]
    with canvas(size=(6.2, 4.2)) as (figure, axes):
        ax = axes[0, 0]
        image_ = ax.imshow(share, cmap="Blues", vmin=0, vmax=1, aspect="auto")
        for (row, column), value in np.ndenumerate(share):
            if counts[row, column]:
                ax.text(
                    column,
                    row,
                    percent(value) if value < 1 else "100 %",
                    ha="center",
                    va="center",
                    fontsize=8.5,
                    color="white" if value > 0.55 else INK,
                )
        ax.set_xticks(range(len(ticks)), ticks)
        ax.set_yticks(range(len(ticks)), ticks)
        ax.set(xlabel=f"Predicted ({unit})", ylabel=f"True ({unit})")
        ax.grid(visible=False)
        ax.spines[:].set_visible(False)
        bar = figure.colorbar(image_, ax=ax, shrink=0.85)
        bar.set_label("Share of the true class")
        bar.ax.spines["outline"].set_visible(False)
        image = uri(figure)
    return Figure(
        f"confusion-{model}",
        f"Confusion, {names.estimator(model).title}, {names.SPLITS.get(split, split)}",
        f"{scores.n:,} pinches, each predicted by a model that did not learn from "
        + ("its session." if split == "by_session" else "it."),
        image,
    )
