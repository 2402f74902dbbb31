"""Figures of the grasp report. They import matplotlib only when they are drawn."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.core import GREY, INK
from firstcontact.grasp import POLICIES, Part, Task
from firstcontact_lab.grasping.results import CEILING, FrontPoints, Household
from firstcontact_lab.report.style import canvas, uri

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Size of the figure as a separate picture and in the report, inch.
SIZE = (7.4, 4.6)
#: Largest share of drops and of damage in the figure, %.
MOST_DAMAGE, MOST_DROPS = 40.0, 60.0
#: Distance below which two points are drawn side by side, %.
APART = 0.35


def fronts_figure(household: Household) -> str:
    """Draw the fronts of all policies. Return the figure as a data URI."""
    with canvas(size=SIZE) as (figure, axes):
        _draw(axes[0, 0], household)
        return uri(figure)


def fronts_picture(household: Household, image: Path) -> None:
    """Draw the fronts of all policies, and write them as a PNG."""
    with canvas(size=SIZE) as (figure, axes):
        _draw(axes[0, 0], household)
        figure.savefig(image, format="png", dpi=150, metadata={"Software": None})


def _draw(axis: Axes, household: Household) -> None:
    percent = 100 * household.damage
    axis.axvline(percent, color=GREY, linewidth=0.9, linestyle=":")
    axis.text(percent + 1.0, MOST_DROPS, "a tenth damaged", va="top", fontsize=8, color="#52606D")
    lines = {
        name: policy
        for name, policy in POLICIES.items()
        if policy.task is Task.HOUSEHOLD and name in household.fronts
    }
    for place, (name, policy) in enumerate(lines.items()):
        line = "--" if policy.has_reflex() else ":" if policy.part is Part.LIMIT else "-"
        title = policy.title
        _front(axis, household.fronts[name], policy.colour, line, title)
        between = household.drops_between[name]
        axis.errorbar(
            percent + APART * (place - (len(lines) - 1) / 2), 100 * between.value,
            yerr=[
                [100 * max(between.value - between.low, 0)],
                [100 * max(between.high - between.value, 0)],
            ],
            color=policy.colour, marker="o", markersize=5, capsize=3, linewidth=1.1, zorder=3,
        )  # fmt: skip
    if CEILING in household.fronts:
        _front(axis, household.fronts[CEILING], INK, "*-.", "ceiling: each specimen known")
    axis.set_xlim(0, MOST_DAMAGE)
    axis.set_ylim(0, MOST_DROPS)
    axis.set_xlabel("Damaged (% of closings)")
    axis.set_ylabel("Dropped (% of closings)")
    axis.text(0.6, 0.6, "better", va="bottom", fontsize=8, color="#52606D")
    axis.legend(loc="upper right")


def _front(axis: Axes, points: FrontPoints, colour: str, line: str, title: str) -> None:
    damaged = np.maximum.accumulate(100 * np.array(points.damaged))
    axis.plot(
        damaged, 100 * np.array(points.dropped), line, color=colour, label=title, linewidth=1.8
    )
