"""One number of every policy over the brake latency."""

from __future__ import annotations

from firstcontact.grasp_study.results import Policies
from firstcontact.grasp_study.variants import variants
from firstcontact.learning.scores import bounded
from firstcontact.report.figures.style import canvas, uri


def over_latency(
    policies: Policies, group: str, number: str, label: str, factor: float = 1.0,
    least: float = 0.0,
) -> str:  # fmt: skip
    """Draw a number with its intervals.

    Parameters
    ----------
    policies
            See :func:`firstcontact.grasp_study._numbers.by_policy`.
    group
        Of objects.
    number
        Its name; ``factor`` times it is drawn.
    label
        Of the axis, which reaches up to ``least`` at least.

    Returns
    -------
    str
        Data URI.
    """
    with canvas(size=(6.2, 3.9)) as (figure, axes):
        axis = axes[0, 0]
        width, drawn = 0.8, variants()
        for place, (variant, at) in enumerate(policies.items()):
            # Side by side, or the intervals would hide each other.
            shift = (place - (len(policies) - 1) / 2) * width
            its = [(float(ms), bounded(groups.get(group), number)) for ms, groups in at.items()]
            points = [(ms, found) for ms, found in its if found is not None]
            if not points:
                continue
            x = [ms + shift for ms, _ in points]
            y = [factor * found.value for _, found in points]
            ends = [found.ends or [found.value] * 2 for _, found in points]
            low = [max(v - factor * e[0], 0.0) for v, e in zip(y, ends, strict=True)]
            high = [max(factor * e[1] - v, 0.0) for v, e in zip(y, ends, strict=True)]
            axis.errorbar(
                x, y, yerr=[low, high], label=drawn[variant].title, color=drawn[variant].colour,
                marker="o", markersize=4, linewidth=1.3, elinewidth=1, capsize=2,
            )  # fmt: skip
        axis.set_xlabel("Brake latency (ms)")
        axis.set_ylabel(label)
        axis.set_ylim(0, max(axis.get_ylim()[1], least))
        axis.set_xticks(sorted({float(ms) for at in policies.values() for ms in at}))
        figure.legend(loc="outside upper center", ncols=3)
        return uri(figure)
