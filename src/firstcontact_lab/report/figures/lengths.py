"""Error against window length."""

from __future__ import annotations

from collections.abc import Mapping

from firstcontact.core import BLUE, RED
from firstcontact_lab.report import names
from firstcontact_lab.report.figures.style import canvas, uri
from firstcontact_lab.report.findings import Figure
from firstcontact_lab.report.results.stiffness import WindowErrors


def lengths_figure(model: str, found: Mapping[str, Mapping[str, WindowErrors]]) -> Figure:
    """RMSE of a model with intervals against window length (ms), blocks and objects."""
    title = names.estimator(model).title
    with canvas() as (figure, axes):
        ax = axes[0, 0]
        for side, colour, name in (
            ("blocks", BLUE, "blocks, by session"),
            ("objects", RED, "unseen objects"),
        ):
            points = [
                (float(ms), scores)
                for ms, its in found.items()
                if model in its and (scores := getattr(its[model], side)) is not None
            ]
            if not points:
                continue
            points.sort(key=lambda point: point[0])
            times = [ms for ms, _ in points]
            values = [scores.rmse for _, scores in points]
            ax.plot(times, values, "o-", color=colour, ms=5, label=name)
            if all("rmse" in scores.intervals for _, scores in points):
                ends = [scores.intervals["rmse"] for _, scores in points]
                ax.fill_between(
                    times,
                    [e[0] for e in ends],
                    [e[1] for e in ends],
                    color=colour,
                    alpha=0.15,
                    lw=0,
                )
        ax.set_xticks([float(ms) for ms in found])
        ax.set(
            xlabel="Window after contact (ms)", ylabel=f"RMSE (Shore A), {title}", ylim=(0, None)
        )
        ax.set_xlim(0, None)
        ax.legend(loc="best")
        image = uri(figure)
    return Figure(
        f"lengths-{model}",
        f"Error against window length, {title}",
        f"{title} regression; bands are 95 % bootstrap intervals (sessions or objects drawn "
        "whole).",
        image,
    )
