"""Error against window length."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from firstcontact.report.figures.style import BLUE, RED, canvas, uri
from firstcontact.report.findings import Figure


def lengths_figure(tree: Mapping[str, Any]) -> Figure:
    """RMSE with intervals against window length (ms), blocks and objects."""
    with canvas() as (figure, axes):
        ax = axes[0, 0]
        for side, colour, name in (
            ("blocks", BLUE, "blocks, by session"),
            ("objects", RED, "unseen objects"),
        ):
            points = [
                (float(ms), entry["svm"][side])
                for ms, entry in tree.items()
                if side in entry.get("svm", {})
            ]
            if not points:
                continue
            points.sort(key=lambda point: point[0])
            times = [ms for ms, _ in points]
            values = [scores["rmse"] for _, scores in points]
            ax.plot(times, values, "o-", color=colour, ms=5, label=name)
            if all("rmse" in scores["intervals"] for _, scores in points):
                ends = [scores["intervals"]["rmse"] for _, scores in points]
                ax.fill_between(
                    times,
                    [e[0] for e in ends],
                    [e[1] for e in ends],
                    color=colour,
                    alpha=0.15,
                    lw=0,
                )
        ax.set_xticks([float(ms) for ms in tree])
        ax.set(xlabel="Window after contact (ms)", ylabel="RMSE (Shore A), SVM", ylim=(0, None))
        ax.set_xlim(0, None)
        ax.legend(loc="best")
        image = uri(figure)
    return Figure(
        "lengths",
        "Error against window length",
        "SVM regression; bands are 95 % bootstrap intervals (sessions or objects drawn whole).",
        image,
    )
