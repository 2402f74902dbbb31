"""Regression on unseen objects."""

from __future__ import annotations

import numpy as np

from firstcontact.core import INK
from firstcontact.models import LabelledWindows, Values
from firstcontact.recording import figure_label
from firstcontact_lab.report import names
from firstcontact_lab.report.figures.style import canvas, uri
from firstcontact_lab.report.findings import Figure


def boxes_figure(model: str, data: LabelledWindows, predicted: Values) -> Figure:
    """One box an object, with its true Shore A as a bar behind it."""
    asked = np.isfinite(predicted)
    things = np.where(data.specimens == "", data.objects, data.specimens)[asked]
    truth, answers = data.y[asked], predicted[asked]
    order = sorted(set(things.tolist()), key=lambda s: (float(truth[things == s].mean()), s))
    with canvas(size=(6.2, 4.0)) as (figure, axes):
        ax = axes[0, 0]
        true = [float(truth[things == s].mean()) for s in order]
        for i, value in enumerate(true):
            ax.plot(
                [i - 0.42, i + 0.42],
                [value, value],
                color=INK,
                lw=3,
                solid_capstyle="butt",
                label="true value" if i == 0 else None,
                zorder=2,
            )
        ax.boxplot(
            [answers[things == s] for s in order],
            positions=range(len(order)),
            widths=0.55,
            patch_artist=True,
            boxprops={"facecolor": names.estimator(model).colour, "alpha": 0.45, "lw": 0.8},
            medianprops={"color": names.estimator(model).colour, "lw": 1.8},
            whiskerprops={"color": names.estimator(model).colour, "lw": 0.9},
            capprops={"color": names.estimator(model).colour, "lw": 0.9},
            flierprops={"marker": ".", "ms": 3, "mec": names.estimator(model).colour, "alpha": 0.6},
        )
        written = [figure_label(s.replace("_", " ")) for s in order]
        labels = [f"{name}\n({v:g})" for name, v in zip(written, true, strict=True)]
        ax.set_xticks(range(len(order)), labels, fontsize=8)
        if len(order) > 8 or max(map(len, written)) > 10:
            ax.tick_params(axis="x", rotation=35)
        ax.set(ylabel="Estimated Shore A", xlabel="Object (true Shore A)")
        if min(answers.min(), truth.min()) >= 0 and max(answers.max(), truth.max()) <= 80:
            ax.set_ylim(0, 80)  # the same for all models and conditions
        ax.grid(axis="x", visible=False)
        ax.legend(loc="upper left")
        image = uri(figure)
    return Figure(
        f"boxes-{model}",
        f"Unseen objects, {names.estimator(model).title}",
        "Estimates for each object (box: middle half, whiskers: 1.5 times that) by a model that "
        "has never seen it; thick bars are the true values.",
        image,
    )
