"""Errors of every estimator off its blocks."""

from __future__ import annotations

from firstcontact.core import BLUE, INK, RED
from firstcontact_lab.report._anytime_tables import title_of
from firstcontact_lab.report.figures.style import canvas, uri
from firstcontact_lab.report.findings import Figure
from firstcontact_lab.report.results.anytime import NETWORK_TITLES, Generalised

_PANELS = {
    "objects": "Unseen objects",
    "three_pinches": "Three pinches",
    "other_hand": "Another hand",
    "level_left_out": "Level left out",
}


def generalise_figure(found: Generalised) -> Figure:
    """RMSE with intervals over rigs; the floor and the ceilings as lines."""
    rows = list(found.estimators)
    rigs = "1 rig" if found.sets == 1 else f"{found.sets} rigs"
    size = (6.2, 1.4 + 0.46 * len(rows))
    with canvas(2, 2, size, sharex=True, sharey=True) as (figure, axes):
        for ax, (key, title) in zip(axes.flat, _PANELS.items(), strict=True):
            for at, name in enumerate(rows):
                score = found.estimators[name].bounded(key)
                if score is None:
                    continue
                colour = RED if name in NETWORK_TITLES else BLUE
                if score.ends is not None:
                    ax.plot(score.ends, (at, at), color=colour, lw=3, alpha=0.35)
                ax.plot(score.value, at, "o", color=colour, ms=5)
            floor = found.floor.bounded(key)
            if floor is not None:
                ax.axvline(floor.value, color=INK, ls="--", lw=1.0)
            for told in found.ceiling.values():
                ceiling = told.bounded(key)
                if ceiling is not None:
                    ax.axvline(ceiling.value, color=INK, ls=":", lw=1.0)
            ax.set(title=title)
        axes[0, 0].set_yticks(range(len(rows)), [title_of(name) for name in rows])
        axes[0, 0].set(xlim=(0, None), ylim=(len(rows) - 0.5, -0.5))
        for ax in axes[-1]:
            ax.set_xlabel("RMSE (Shore A)")
        image = uri(figure)
    return Figure(
        "generalise",
        "Errors off the blocks",
        f"{rigs} with hands and specimens of their own; bars are 95 % bootstrap intervals over "
        "rigs. In another colour: the in-context network. Dashed: who learned from these kinds of "
        "object on this rig. Dotted: who is told the modulus, or the contact's stiffness.",
        image,
    )
