"""Plots of predictions and evaluations."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from firstcontact.core.display import BLUE, GREY, ORANGE
from firstcontact.core.quantity import QUANTITIES, SHORE_A
from firstcontact.plots.style import name_hardness, new_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from firstcontact.models import Evaluation, Predictions


def draw_predictions(predictions: Predictions, figure: Figure) -> Axes:
    """Draw the value and the interval of each prediction."""
    axes = _graph(figure)
    number, value = np.arange(len(predictions)), predictions.value
    for is_out, colour, label in ((False, BLUE, "prediction"), (True, ORANGE, "out of range")):
        rows = (predictions.out_of_range == is_out) & ~np.isnan(value)
        if rows.any():
            ends = np.stack([value - predictions.low, predictions.high - value])[:, rows]
            axes.errorbar(number[rows], value[rows], ends.clip(0), fmt="o", ms=3, lw=0.8,
                          color=colour, label=f"{label} and interval")  # fmt: skip
    axes.set_xlabel("pinch")
    axes.locator_params(axis="x", integer=True)
    quantity = QUANTITIES.get(predictions.target)
    axes.set_ylabel(quantity.axis if quantity else "predicted value")
    if quantity is SHORE_A:
        name_hardness(axes)
    elif quantity and quantity.is_logarithmic:
        axes.set_yscale("log")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(frameon=False, ncols=2, loc="lower left", bbox_to_anchor=(0, 1))
    return axes


def draw_evaluation(evaluation: Evaluation, figure: Figure) -> Axes:
    """Draw the error, or the accuracy, of each group of pinches over the time after the contact."""
    axes = _graph(figure)
    for group, colour in zip(evaluation.groups, (BLUE, ORANGE, GREY), strict=False):
        name = "rmse" if group.rmse else "accuracy"
        times = 1e3 * np.array(list(group.scores))
        values = np.array([getattr(scores, name) for scores in group.scores.values()])
        intervals = [scores.intervals for scores in group.scores.values()]
        ends = [i.get(name, (v, v)) for i, v in zip(intervals, values, strict=True)]
        low, high = np.array(ends, float).T
        axes.errorbar(times, values, [values - low, high - values], fmt="o-", ms=4, lw=1,
                      color=colour, label=f"{group.title}, {group.n} pinches")  # fmt: skip
        unit = evaluation.quantity.error_axis
        axes.set_ylabel(f"root mean square error ({unit})" if name == "rmse" else "accuracy")
    axes.set_xlabel("time since first contact (ms)")
    axes.set_ylim(bottom=0)
    axes.set_title(evaluation.predictor, loc="left")
    axes.legend(frameon=False)
    return axes


def _graph(figure: Figure) -> Axes:
    axes = new_axes(figure)
    axes.grid(axis="y", alpha=0.2, lw=0.6)
    return axes
