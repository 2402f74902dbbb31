"""Chart of values with intervals, with one panel for each subject (dataset under study)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from firstcontact.core import INK
from firstcontact.models import Bounded
from firstcontact_lab.report.findings import Figure
from firstcontact_lab.report.style import SIZE, canvas, uri


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


def dot_figure(
    key: str,
    title: str,
    caption: str,
    axis: str,
    panels: Sequence[Panel],
    most: float | None = None,
) -> Figure | None:
    """Return a figure of values with intervals; None if the panels are empty.

    Parameters
    ----------
    key, title, caption
        As in :class:`Figure`.
    axis
        Label of the values.
    panels
        Panels of the subjects, side by side. A model is in the same row in every panel.
    most
        Upper end of the axis; None to fit the axis to the values.
    """
    present = tuple(panel for panel in panels if panel.dots)
    if not present:
        return None
    return Figure(key, title, caption, _draw(axis, present, most), wide=len(present) > 1)


@lru_cache(maxsize=32)
def _draw(axis: str, panels: tuple[Panel, ...], most: float | None) -> str:
    """Return the image of the panels. It is cached, because reports often draw the same values."""
    names = list(dict.fromkeys(dot.name for panel in panels for dot in panel.dots))
    height = 1.5 + 0.34 * len(names)
    size = (SIZE[0] * len(panels), height)
    with canvas(1, len(panels), size, sharex=True, sharey=True) as (figure, axes):
        for ax, panel in zip(axes[0], panels, strict=True):
            for dot in panel.dots:
                row = names.index(dot.name)
                if dot.ends:
                    ax.plot(dot.ends, (row, row), color=dot.colour, lw=3, alpha=0.35)
                ax.plot(dot.value, row, "o", color=dot.colour, ms=6)
            for name, value in panel.lines:
                ax.axvline(value, color=INK, ls="--", lw=1)
                ax.text(value, -0.75, f" {name}", fontsize=8, va="center", color=INK)
            ax.set(title=panel.title, xlabel=axis, ylim=(len(names) - 0.5, -1.1))
        axes[0, 0].set_yticks(range(len(names)), names)
        axes[0, 0].set_xlim(0, most)  # shared: after all panels are drawn
        return uri(figure)
