"""Colours, familiar objects on the Shore A scale, progress bars, and drawings in notebooks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from html import escape
from importlib.metadata import entry_points

# Distinct for colour-blind readers (Okabe and Ito 2008): https://jfly.uni-koeln.de/color/
BLUE, ORANGE, GREEN, RED = "#0072B2", "#E69F00", "#009E73", "#D55E00"
PURPLE, SKY, GREY, INK = "#CC79A7", "#56B4E9", "#8A94A0", "#1F2933"

#: Approximate Shore A of objects that a person knows, the softest first, and its source.
FAMILIAR = (
    ("rubber band", 25.0, "chart 1"),
    ("orange", 36.0, "readings of At First Contact"),
    ("eraser", 40.0, "our estimate"),
    ("tennis ball", 45.0, "readings of At First Contact"),
    ("door seal", 55.0, "charts 1 and 2"),
    ("car tyre", 70.0, "chart 1"),
    ("tap washer", 85.0, "chart 2"),
)

#: True for a bar on standard error; or a function that is called with the number of steps just
#: finished; None or False for neither.
Progress = bool | Callable[[int], object] | None


@contextmanager
def progress_steps(
    progress: Progress, total: int | None, unit: str, title: str | None = None
) -> Iterator[Callable[[int], object]]:
    """Show a progress bar if requested. Yield the function that advances it.

    Call the yielded function with the number of steps finished since the last call. ``progress`` is
    True for a bar on standard error, a function to yield instead, or None or False for neither.
    """
    if callable(progress):
        yield progress
    elif progress:
        from tqdm import tqdm

        with tqdm(total=total, unit=unit, desc=title, disable=None) as bar:  # no bar in a pipe
            yield bar.update
    else:
        yield lambda finished: None


class Drawable:
    """Base class of objects that a Jupyter notebook shows as a drawing.

    The function that draws is the entry point of the group ``firstcontact.drawings`` with the name
    of the class, because this package must not import ``firstcontact.plots``.
    """

    __slots__ = ()

    def _repr_html_(self) -> str:
        text = f"<code>{escape(repr(self))}</code><br>"
        for entry in entry_points(group="firstcontact.drawings", name=type(self).__name__):
            text += entry.load()(self)
        return text
