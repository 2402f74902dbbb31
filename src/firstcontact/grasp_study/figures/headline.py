"""The two numbers that matter, at 20 ms: force on what is soft, and what breaks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.grasp_study.results import Policies
from firstcontact.grasp_study.variants import variants
from firstcontact.learning.scores import bounded
from firstcontact.report.figures.style import canvas, uri

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Side by side as a picture of its own, and one above the other beside the report's other figures.
BESIDE, BELOW = (9.4, 3.6), (6.2, 7.4)
#: Group of objects, number, factor, form and title of each panel.
PANELS = (
    ("soft", "peak_n", 1.0, "{:.1f}", "Peak force, soft objects (N)"),
    ("lasting", "time_ms", 1.0, "{:.0f}", "Time to grasp (ms)"),
    ("brittle", "broken", 100.0, "{:.0f}", "Brittle objects broken (%)"),
)


def headline_figure(policies: Policies, ms: str) -> str:
    """Draw bars with intervals for every policy.

    Parameters
    ----------
    policies
            See :func:`firstcontact.grasp_study._numbers.by_policy`.
    ms
        The latency.

    Returns
    -------
    str
        Data URI.
    """
    with canvas(3, 1, size=BELOW) as (figure, axes):
        for axis, (group, number, factor, form, title) in zip(axes[:, 0], PANELS, strict=True):
            _bars(axis, policies, ms, group, number, factor, form)
            axis.set_title(title)
            _names(axis, policies)
        return uri(figure)


def headline_picture(policies: Policies, ms: str, image: Path) -> None:
    """Write the same as a PNG, side by side."""
    with canvas(1, 3, size=BESIDE, sharey=True) as (figure, axes):
        for axis, (group, number, factor, form, title) in zip(axes[0], PANELS, strict=True):
            _bars(axis, policies, ms, group, number, factor, form)
            axis.set_title(title)
        _names(axes[0, 0], policies)
        figure.savefig(image, format="png", dpi=150, metadata={"Software": None})


def _names(axis: Axes, policies: Policies) -> None:
    axis.set_yticks(range(len(policies)), [variants()[v].title for v in policies])
    axis.invert_yaxis()


def _bars(
    axis: Axes, policies: Policies, ms: str, group: str, number: str, factor: float,
    form: str,
) -> None:  # fmt: skip
    for place, (variant, at) in enumerate(policies.items()):
        found = bounded(at[ms].get(group), number)
        if found is None:
            axis.text(0, place, " none", va="center", fontsize=8.5)
            continue
        value = factor * found.value
        low, high = (factor * end for end in found.ends or [found.value] * 2)
        axis.barh(place, value, color=variants()[variant].colour, height=0.62)
        axis.plot([low, high], [place, place], color="#1F2933", linewidth=1.2)
        axis.text(max(high, value), place, "  " + form.format(value), va="center", fontsize=8.5)
    axis.set_xlim(left=0)
    axis.margins(x=0.16)
    axis.grid(axis="y", visible=False)
