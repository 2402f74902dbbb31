"""The two numbers that matter, at 20 ms: force on what is soft, and what breaks."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from firstcontact.grasp_study.words import colour, name
from firstcontact.study.figures.style import canvas, uri

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SIZE = (9.4, 3.6)


def headline_figure(policies: Mapping[str, Any], ms: str, image: Path | None = None) -> str:
    """Draw bars with intervals for every policy.

    Parameters
    ----------
    policies
        See :func:`firstcontact.grasp_study.numbers.policies_tree`.
    ms
        The latency.
    image
        Where to write it as PNG, too.

    Returns
    -------
    str
        Data URI.
    """
    with canvas(1, 3, size=SIZE, sharey=True) as (figure, axes):
        left, middle, right = axes[0]
        _bars(left, policies, ms, "soft", "peak_n", 1.0, "{:.1f}")
        left.set_title("Peak force, soft objects (N)")
        _bars(middle, policies, ms, "lasting", "time_ms", 1.0, "{:.0f}")
        middle.set_title("Time to grasp (ms)")
        _bars(right, policies, ms, "brittle", "broken", 100.0, "{:.0f}")
        right.set_title("Brittle objects broken (%)")
        left.set_yticks(range(len(policies)), [name(v) for v in policies])
        left.invert_yaxis()
        if image is not None:
            figure.savefig(image, format="png", dpi=150, metadata={"Software": None})
        return uri(figure)


def _bars(
    axis: Axes, policies: Mapping[str, Any], ms: str, group: str, number: str, factor: float,
    form: str,
) -> None:  # fmt: skip
    for place, (variant, at) in enumerate(policies.items()):
        tree = at[ms].get(group, {})
        if number not in tree:
            axis.text(0, place, " none", va="center", fontsize=8.5)
            continue
        value = factor * tree[number]
        low, high = (factor * e for e in tree["intervals"].get(number, [tree[number]] * 2))
        axis.barh(place, value, color=colour(variant), height=0.62)
        axis.plot([low, high], [place, place], color="#1F2933", linewidth=1.2)
        axis.text(max(high, value), place, "  " + form.format(value), va="center", fontsize=8.5)
    axis.set_xlim(left=0)
    axis.margins(x=0.16)
    axis.grid(axis="y", visible=False)
