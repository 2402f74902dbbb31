"""With and without the second contact inside the window."""

from __future__ import annotations

from collections.abc import Mapping

from firstcontact.core import GREY, INK
from firstcontact_lab.report import names
from firstcontact_lab.report.figures.style import canvas, uri
from firstcontact_lab.report.findings import Figure
from firstcontact_lab.report.results.stiffness import SecondContact, by_side


def second_figure(found: Mapping[str, SecondContact]) -> Figure:
    """RMSE of pinches with and without the second contact in the window."""
    bars = by_side(found)
    with canvas(size=(6.2, 0.9 + 0.42 * max(len(bars), 4))) as (figure, axes):
        ax = axes[0, 0]
        for row, (model, _, where, scores) in enumerate(bars):
            ax.barh(
                row,
                scores.rmse,
                color=names.estimator(model).colour,
                alpha={"with": 0.85, "without": 0.4}.get(where, 0.12),
                height=0.7,
            )
            ends = scores.intervals.get("rmse")
            if ends:
                ax.plot(ends, [row, row], color=INK, lw=1)
            right = max(scores.rmse, ends[1] if ends else 0.0)
            ax.text(
                right,
                row,
                f"  {scores.rmse:.2f}  (n = {scores.n:,})",
                va="center",
                fontsize=8,
                color=INK,
            )
        ax.set_yticks(
            range(len(bars)),
            [f"{side}, {names.estimator(model).title}, {where}" for model, side, where, _ in bars],
            fontsize=8.5,
        )
        ax.invert_yaxis()
        ax.set(xlabel="RMSE (Shore A)")
        ax.margins(x=0.35)
        ax.set_xlim(0, None)
        ax.grid(axis="y", visible=False)
        ax.spines["left"].set_color(GREY)
        image = uri(figure)
    return Figure(
        "second",
        "With and without the second contact in the window",
        "The same predictions, divided by whether the other finger touched within the 15 ms; "
        "misplaced windows do not begin at the first contact and stand by themselves. Lines are "
        "95 % intervals. Blocks are split by session, objects are unseen."
        if any(where == "misplaced" for _, _, where, _ in bars)
        else "The same predictions, divided by whether the other finger touched within the 15 ms. "
        "Lines are 95 % intervals. Blocks are split by session, objects are unseen.",
        image,
    )
