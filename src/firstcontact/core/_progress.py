"""Progress of a long call: a bar, or a function that counts finished steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

#: True for a bar on standard error; or a function that is called with the number of steps just
#: finished; None or False for neither.
Progress = bool | Callable[[int], object] | None


@contextmanager
def progress_steps(
    progress: Progress, total: int | None, unit: str, title: str | None = None
) -> Iterator[Callable[[int], object]]:
    """Yield a function to call with the number of steps just finished. Show a bar if requested.

    Parameters
    ----------
    progress
        True for a bar; a function that is called with the number of steps just finished; or None
        for neither.
    total
        Number of steps; None if unknown.
    unit
        Noun for one step.
    title
        Title of the bar.
    """
    if callable(progress):
        yield progress
    elif progress:
        from tqdm import tqdm

        with tqdm(total=total, unit=unit, desc=title) as bar:
            yield bar.update
    else:
        yield lambda finished: None
