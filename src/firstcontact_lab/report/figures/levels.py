"""What a model says of a stiffness it has never met."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from firstcontact.core import INK
from firstcontact.models import LabelledWindows, Values
from firstcontact_lab.report import names
from firstcontact_lab.report.figures.style import canvas, uri
from firstcontact_lab.report.findings import Figure


def leave_one_out_figure(drawn: Mapping[str, tuple[LabelledWindows, Values]]) -> Figure:
    """Predictions with the pinch's own Shore level left out of training."""
    with canvas() as (figure, axes):
        ax = axes[0, 0]
        levels = np.unique(next(iter(drawn.values()))[0].y)
        gap = float(np.diff(levels).min())
        ax.plot(
            [levels[0], levels[-1]],
            [levels[0], levels[-1]],
            color=INK,
            lw=1,
            ls="--",
            label="true value",
        )
        for number, (model, (data, predicted)) in enumerate(drawn.items()):
            look = names.estimator(model)
            shift = (number - (len(drawn) - 1) / 2) * 0.32 * gap
            for level in levels:
                ax.boxplot(
                    [predicted[data.y == level]],
                    positions=[level + shift],
                    widths=0.26 * gap,
                    patch_artist=True,
                    manage_ticks=False,
                    boxprops={"facecolor": look.colour, "alpha": 0.45, "lw": 0.8},
                    medianprops={"color": look.colour, "lw": 1.8},
                    whiskerprops={"color": look.colour, "lw": 0.9},
                    capprops={"color": look.colour, "lw": 0.9},
                    flierprops={
                        "marker": ".",
                        "ms": 2,
                        "mec": look.colour,
                        "alpha": 0.3,
                        "rasterized": True,
                    },
                )
            ax.plot(
                [],
                [],
                color=look.colour,
                lw=6,
                alpha=0.45,
                label=look.title,
            )
        ax.set_xticks(levels, [f"{level:g}" for level in levels])
        ax.set(xlabel="True Shore A, left out of training", ylabel="Estimated Shore A")
        ax.legend(loc="upper left")
        image = uri(figure)
    return Figure(
        "levels",
        "A Shore level left out",
        "Each level is estimated by models that learned from the other levels only. The softest "
        "and the stiffest lie outside of what was learned.",
        image,
    )
