"""Error and width of the interval against the time after the contact."""

from __future__ import annotations

from typing import Any

from firstcontact.core import BLUE, RED
from firstcontact.models import AnytimeScores
from firstcontact_lab.report import names
from firstcontact_lab.report.figures.style import canvas, uri
from firstcontact_lab.report.findings import Figure
from firstcontact_lab.report.results.anytime import TITLES, AnytimeResults

_SIDES = {"objects": (RED, "unseen objects"), "blocks": (BLUE, "blocks of other sessions")}


def anytime_figure(found: AnytimeResults) -> Figure:
    """RMSE beside the default estimator's with its whole window, and mean width."""
    sides: dict[str, AnytimeScores] = {found.asked: found}
    if found.blocks is not None:
        sides["blocks"] = found.blocks
    with canvas(1, 2) as (figure, axes):
        error, width = axes[0]
        for side, scores in sides.items():
            colour, name = _SIDES[side]
            _line(error, scores, "rmse", colour, name)
            _line(width, scores, "width", colour, name)
        fixed = found.fixed
        if fixed is not None:
            title = names.estimator(fixed.estimator).title
            error.axhline(fixed.rmse, color=RED, ls="--", lw=1.2, label=f"{title}, 15 ms, objects")
        error.set(ylabel="RMSE (Shore A)")
        width.set(ylabel=f"Width of the {100 * found.level:g} % interval (Shore A)")
        for ax in (error, width):
            ax.set(xlabel="After contact (ms)", ylim=(0, None), xlim=(0, None))
            ax.set_xticks([float(ms) for ms in found.rmse])
        error.legend(loc="lower left")
        image = uri(figure)
    return Figure(
        "anytime",
        f"Error and interval by the time after contact, {TITLES['in_context']}",
        "Signal after that time, or after the second contact, is not looked at. Bands are 95 % "
        "bootstrap intervals (specimens or sessions drawn whole).",
        image,
    )


def _line(ax: Any, scores: AnytimeScores, key: str, colour: str, name: str) -> None:
    values: dict[str, float] = getattr(scores, key)
    times = [float(ms) for ms in values]
    ax.plot(times, list(values.values()), "o-", color=colour, ms=5, label=name)
    ends = scores.intervals.get(key, {})
    if len(ends) == len(values):
        low, high = zip(*(ends[ms] for ms in values), strict=True)
        ax.fill_between(times, low, high, color=colour, alpha=0.15, lw=0)
