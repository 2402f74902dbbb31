"""Style of all figures in reports, and the charts that several reports share."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Layout
from firstcontact.core.display import INK
from firstcontact.models.scores import Ends
from firstcontact.plots.style import PLAIN, figure_label, name_hardness
from firstcontact_lab.report.findings import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

STYLE: Any = {
    **PLAIN,
    "font.size": 9.5,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9.5,
    "axes.labelcolor": INK,
    "axes.edgecolor": "#B8C0C8",
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E6EAEE",
    "grid.linewidth": 0.8,
    "xtick.color": "#52606D",
    "ytick.color": "#52606D",
    "xtick.major.size": 0,
    "ytick.major.size": 0,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.4,
    "text.color": INK,
    "svg.fonttype": "path",
    # The same figure gives the same bytes.
    "svg.hashsalt": "firstcontact",
}
SIZE = (6.2, 3.7)


@contextmanager
def canvas(
    rows: int = 1, columns: int = 1, size: tuple[float, float] = SIZE, **options: Any
) -> Iterator[tuple[Canvas, NDArray[Any]]]:
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasAgg(figure)
        yield figure, np.asarray(figure.subplots(rows, columns, squeeze=False, **options))


def uri(figure: Canvas) -> str:
    """Return a figure as a data URI in SVG. Bitmaps in it have twice the resolution of a screen."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", dpi=192, metadata={"Date": None, "Creator": None})
    svg = re.sub(r"^.*?(?=<svg)", "", buffer.getvalue(), flags=re.DOTALL)
    return "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()


def boxes(
    ax: Any,
    values: Sequence[NDArray[np.float64]],
    positions: Sequence[float],
    width: float,
    colour: str,
) -> None:
    """Draw a box plot of each array in ``values`` at its position, with outliers as points."""
    groups = list(zip(positions, values, strict=True))
    several = {place: group for place, group in groups if len(group) > 1}
    line = {"color": colour, "lw": 0.9}
    if several:
        ax.boxplot(
            list(several.values()),
            positions=list(several),
            widths=width,
            patch_artist=True,
            manage_ticks=False,
            boxprops={"facecolor": colour, "alpha": 0.45, "lw": 0.8},
            medianprops={"color": colour, "lw": 1.8},
            whiskerprops=line,
            capprops=line,
            flierprops={"marker": ".", "ms": 3, "mec": colour, "alpha": 0.5, "rasterized": True},
        )
    for place, group in groups:
        if len(group) == 1:
            ax.plot(place, group[0], "o", ms=5, color=colour)


def banded_line(
    ax: Any,
    times: Sequence[float],
    values: Sequence[float],
    ends: Sequence[Ends | None],
    style: str,
    colour: str,
    label: str,
) -> None:
    ax.plot(times, values, style, color=colour, ms=5, label=label)
    known = [each for each in ends if each is not None]
    if len(known) == len(values):
        ax.fill_between(times, *zip(*known, strict=True), color=colour, alpha=0.15, lw=0)


def vibration_unit(layout: Layout) -> str:
    return figure_label(layout.vibration[0].unit, 12)


def shades(n: int) -> list[Any]:
    """Return ``n`` colours from light (soft) to dark (stiff) that suit colour-blind readers."""
    import matplotlib as mpl

    return list(mpl.colormaps["viridis_r"](np.linspace(0.12, 0.95, n)))


#: Truth, and predictions by the title of the model, of each group of pinches by its name.
Groups = Mapping[str, tuple[float, Mapping[str, NDArray[np.float64]]]]


def box_figure(
    key: str, title: str, caption: str, axis: str, groups: Groups, colours: Mapping[str, str]
) -> Figure:
    """Return a figure with a bar at the true value of each group, and one box plot per model."""
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
        name_hardness(ax)
        ax.grid(axis="x", visible=False)
        ax.legend(loc="upper left")
        return Figure(key, title, caption, uri(figure))
