"""Plots of predictions and evaluations, and small pictures of all objects for notebooks."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.core import ArgumentError, Dataset, Pinch
from firstcontact.core.display import BLUE, GREY, ORANGE
from firstcontact.core.installation import missing_modules, require_modules
from firstcontact.core.quantity import QUANTITIES, SHORE_A
from firstcontact.models import Evaluation, Predictions
from firstcontact.plots.recordings import draw_dataset, draw_pinch
from firstcontact.plots.style import PLAIN, name_hardness, new_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_predictions(predictions: Predictions, figure: Figure) -> Axes:
    """Draw the value and the interval of each prediction into a figure. Return the axes."""
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
    """Draw the error, or the accuracy, over the time after the contact. Return the axes.

    Each group of pinches in the evaluation is a line.
    """
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


#: Function that draws an object of each type into a figure, and returns the axes.
DRAWINGS: dict[type, Callable[[Any, Any], Any]] = {
    Pinch: draw_pinch,
    Dataset: draw_dataset,
    Predictions: draw_predictions,
    Evaluation: draw_evaluation,
}


def plot(subject: Pinch | Dataset | Predictions | Evaluation) -> Any:
    """Draw a pinch, a dataset, predictions or an evaluation with Matplotlib.

    Parameters
    ----------
    subject
        A pinch is drawn as all channels over time. A dataset is drawn as the vibration after the
        first contacts, coloured by hardness. Predictions are drawn as values with intervals, and an
        evaluation as the error over the time after the contact.

    Returns
    -------
    matplotlib.axes.Axes
        Axes of a new figure; for a pinch an array of axes, one for each kind of channel.

    Raises
    ------
    InputError
        Matplotlib is not installed, or objects of this type cannot be drawn.

    Examples
    --------
    >>> import matplotlib
    >>> matplotlib.use("agg")
    >>> import firstcontact as fc
    >>> axes = fc.plot(fc.load("recordings"))
    >>> axes.get_xlabel()
    'time since first contact (ms)'
    """
    if type(subject) not in DRAWINGS:
        raise ArgumentError(
            f"an object of type {type(subject).__name__} cannot be drawn: give a Pinch, a Dataset, "
            "Predictions or one Evaluation",
            parameter="subject",
        )
    require_modules("plot", "matplotlib")
    from matplotlib import pyplot, rc_context

    with rc_context(PLAIN):
        return DRAWINGS[type(subject)](subject, pyplot.figure(layout="constrained"))


def notebook_html(subject: object) -> str:
    """Return a small picture as HTML; "" without Matplotlib or for an empty dataset."""
    if missing_modules(["matplotlib"]) or (isinstance(subject, Dataset) and not len(subject)):
        return ""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(PLAIN), io.BytesIO() as file:
        figure = Figure(layout="constrained")
        DRAWINGS[type(subject)](subject, figure)
        figure.savefig(file, dpi=60, format="png")
        image = base64.b64encode(file.getvalue()).decode()
    return f'<img alt="" src="data:image/png;base64,{image}">'
