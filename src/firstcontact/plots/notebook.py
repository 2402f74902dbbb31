"""Small drawings of objects in notebooks."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable
from typing import Any

from firstcontact.core import Dataset, Pinch
from firstcontact.core.installation import missing_modules
from firstcontact.models import Evaluation, Predictions
from firstcontact.plots.predictions import draw_evaluation, draw_predictions
from firstcontact.plots.recordings import draw_dataset, draw_pinch
from firstcontact.plots.style import PLAIN

#: Function that draws an object of each type into a figure, and returns the axes.
DRAWINGS: dict[type, Callable[[Any, Any], Any]] = {
    Pinch: draw_pinch,
    Dataset: draw_dataset,
    Predictions: draw_predictions,
    Evaluation: draw_evaluation,
}


def notebook_html(subject: object) -> str:
    """Return a small drawing as HTML; "" without Matplotlib, or of an empty dataset."""
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
