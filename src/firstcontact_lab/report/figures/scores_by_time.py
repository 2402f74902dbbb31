"""Several estimators against the time after the contact."""

from __future__ import annotations

from collections.abc import Mapping

from firstcontact.core import BLUE, GREEN, ORANGE, PURPLE, RED, SKY
from firstcontact.models import AnytimeScores
from firstcontact_lab.report._anytime_tables import title_of
from firstcontact_lab.report.figures.style import canvas, uri
from firstcontact_lab.report.findings import Figure

_COLOURS = (RED, BLUE, GREEN, ORANGE, PURPLE, SKY)
_PANELS = {
    "rmse": "RMSE (Shore A)",
    "coverage": "Truth in the interval",
    "width": "Mean width of the interval (Shore A)",
}


def scores_by_time_figure(
    found: Mapping[str, AnytimeScores],
    title: str = "Unseen objects by the time after the contact",
) -> Figure:
    """Plot error, coverage and width of all competitors against the time."""
    with canvas(1, len(_PANELS), (9.0, 3.4)) as (figure, axes):
        for ax, (key, label) in zip(axes[0], _PANELS.items(), strict=True):
            for number, (name, scores) in enumerate(found.items()):
                values: dict[str, float] = getattr(scores, key)
                colour = _COLOURS[number % len(_COLOURS)]
                times = [float(ms) for ms in values]
                ax.plot(times, list(values.values()), "o-", ms=4, color=colour,
                        label=title_of(name))  # fmt: skip
            ax.set(xlabel="After contact (ms)", ylabel=label, xlim=(0, None), ylim=(0, None))
        axes[0, 0].legend(loc="best")
        image = uri(figure)
    return Figure(
        "scores-by-time",
        title,
        "Signal after that time, or after the second contact, is left out.",
        image,
    )
