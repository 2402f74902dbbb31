"""Charts of values with intervals, and of predictions next to the truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import INK
from firstcontact.models import Bounded
from firstcontact_lab.report.findings import Figure
from firstcontact_lab.report.style import SIZE, boxes, canvas, uri


@dataclass(frozen=True, slots=True)
class Dot:
    """Value of one model, with its interval if there is one."""

    name: str
    value: float
    ends: tuple[float, ...]
    colour: str

    @classmethod
    def from_bounded(cls, name: str, bounded: Bounded, colour: str) -> Dot:
        """Return the dot for a value with or without an interval."""
        return cls(name, bounded.value, tuple(bounded.ends or ()), colour)


@dataclass(frozen=True, slots=True)
class Panel:
    """Panel of a chart: values of one subject, and reference lines by name."""

    title: str
    dots: tuple[Dot, ...]
    lines: tuple[tuple[str, float], ...] = ()


def dot_figures(
    key: str,
    title: str,
    caption: str,
    axis: str,
    panels: Sequence[Panel],
    most: float | None = None,
) -> list[Figure]:
    """Return a figure of values with intervals for each panel that is not empty."""
    present = [panel for panel in panels if panel.dots]
    names = tuple(dict.fromkeys(dot.name for panel in present for dot in panel.dots))
    ends = [
        value
        for panel in present
        for value in (
            *(end for dot in panel.dots for end in (dot.value, *dot.ends)),
            *(line for _, line in panel.lines),
        )
    ]
    limit = 1.05 * max(ends, default=0.0) if most is None else most
    return [
        Figure(key, f"{title}, {panel.title}", caption, _draw(axis, panel, names, limit))
        for panel in present
    ]


@lru_cache(maxsize=32)
def _draw(axis: str, panel: Panel, names: tuple[str, ...], most: float) -> str:
    """Return the image of a panel. It is cached, because reports often draw the same values."""
    with canvas(size=(SIZE[0], 1.2 + 0.34 * len(names))) as (figure, axes):
        ax = axes[0, 0]
        for dot in panel.dots:
            row = names.index(dot.name)
            if dot.ends:
                ax.plot(dot.ends, (row, row), color=dot.colour, lw=3, alpha=0.35)
            ax.plot(dot.value, row, "o", color=dot.colour, ms=6)
        for name, value in panel.lines:
            ax.axvline(value, color=INK, ls="--", lw=1)
            ax.text(value, -0.75, f" {name}", fontsize=8, va="center", color=INK)
        ax.set(xlabel=axis, ylim=(len(names) - 0.5, -1.1), xlim=(0, most))
        ax.set_yticks(range(len(names)), names)
        return uri(figure)


#: Truth, and predictions by the title of the model, of each group of pinches by its name.
Groups = Mapping[str, tuple[float, Mapping[str, NDArray[np.float64]]]]


def box_figure(
    key: str, title: str, caption: str, axis: str, groups: Groups, colours: Mapping[str, str]
) -> Figure:
    """Return a figure with a bar at the true value of each group, and a box plot of each model."""
    with canvas(size=(max(SIZE[0], 0.5 * len(groups)), 4.2)) as (figure, axes):
        ax = axes[0, 0]
        for number, (model, colour) in enumerate(colours.items()):
            shift = (number - (len(colours) - 1) / 2) * 0.8 / len(colours)
            drawn = {
                place + shift: predictions[model]
                for place, (_, predictions) in enumerate(groups.values())
                if model in predictions
            }
            boxes(ax, list(drawn.values()), list(drawn), 0.64 / len(colours), colour)
            ax.plot([], [], color=colour, lw=6, alpha=0.45, label=model)
        truths = [truth for truth, _ in groups.values()]
        places = np.arange(len(groups))
        ax.hlines(truths, places - 0.46, places + 0.46, color=INK, lw=2.5, label="true value")
        ax.set_xticks(places, list(groups), rotation=30, ha="right")
        ax.set(xlabel=axis, ylabel="Estimated Shore A")
        ax.grid(axis="x", visible=False)
        ax.legend(loc="upper left")
        return Figure(key, title, caption, uri(figure))
