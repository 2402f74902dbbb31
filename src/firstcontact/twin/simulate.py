"""A whole set of pinches as recordings, one file a session."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from firstcontact.core.errors import InputError
from firstcontact.core.files import replacing
from firstcontact.core.layout import FINGERTIP_RATE, fingertip_layout
from firstcontact.core.pinch import Pinch
from firstcontact.core.temporary import sweep
from firstcontact.recording import Header, RecordingWriter
from firstcontact.twin.conditions import Condition, condition
from firstcontact.twin.draw import draw_pinch
from firstcontact.twin.pinch import DURATION, simulate_pinch
from firstcontact.twin.plan import PlannedPinch, PlannedSession, plan_sessions

#: Sample numbers that pass between two pinches while the hand opens: 1 s.
BETWEEN = round(FINGERTIP_RATE)
#: Most pinches of one specimen: as many as may be recorded of one.
MOST_PINCHES = 1_000_000
#: Pinches per task handed to a worker.
_BATCH = 8


def simulate(
    directory: Path,
    condition_name: str = "paper-rig",
    pinches_per_block: int = 500,
    pinches_per_object: int = 50,
    seed: int = 0,
    workers: int | None = None,
    progress: Callable[[int], object] = lambda done: None,
) -> list[Path]:
    """Simulate a set of pinches.

    Parameters
    ----------
    directory
        Where the recordings go; must be empty or not exist.
    condition_name
        "paper-rig" or "everyday".
    pinches_per_block, pinches_per_object
        Of each of the five blocks and of each of the eight objects.
    seed
        Same seed, same bytes, whatever the workers.
    workers
        Threads; all cores by default. The mechanics runs outside the GIL.
    progress
        Called with the number of pinches just finished.

    Returns
    -------
    list
        The recordings, one a session.

    Raises
    ------
    InputError
        Unknown condition, a negative size, nothing to simulate, no workers, or
        ``directory`` holds something already or cannot be made or written.
    """
    c = condition(condition_name)
    if min(pinches_per_block, pinches_per_object) < 0 or pinches_per_block + pinches_per_object < 1:
        raise InputError("pinches per block and per object must not be negative nor both 0")
    if max(pinches_per_block, pinches_per_object) > MOST_PINCHES:
        raise InputError(f"pinches per block and per object must be {MOST_PINCHES} at most")
    if seed < 0:
        raise InputError(f"seed is {seed}: use a whole number from 0 on")
    if workers is not None and workers < 1:
        raise InputError(f"workers is {workers}: use 1 or more")
    sweep(directory)
    if directory.exists() and (not directory.is_dir() or any(directory.iterdir())):
        raise InputError(f"{directory} is not an empty folder: choose another --out")
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{directory} cannot be made: {error.strerror}; choose another --out"
        ) from error
    paths = []
    with ThreadPoolExecutor(workers or os.cpu_count() or 1) as pool:
        try:
            for session in plan_sessions(c, pinches_per_block, pinches_per_object, seed):
                path = directory / f"{session.name}.mcap"
                with replacing(path) as temporary:
                    _write(temporary, session, c, seed, pool, progress)
                paths.append(path)
        except BaseException as error:
            pool.shutdown(wait=False, cancel_futures=True)
            # The writer speaks of its own file and of what stays in it; of this one nothing stays.
            if isinstance(error, InputError) and isinstance(error.__cause__, OSError):
                raise InputError(
                    f"{path} cannot be written ({error.__cause__.strerror}): make room on its "
                    "disk, and simulate into another --out"
                ) from error
            raise
    return paths


def pinches_of(
    session: PlannedSession, condition: Condition, seed: int, pool: ThreadPoolExecutor
) -> Iterator[Pinch]:
    """The pinches of a session in their order, made by ``pool``."""
    step = round(DURATION * FINGERTIP_RATE) + BETWEEN

    def one(place: int, planned: PlannedPinch) -> Pinch:
        kind = planned.specimen
        key = planned.label.specimen + f" {planned.number}"
        draw = draw_pinch(seed, condition, session.name, kind, key)
        return simulate_pinch(draw, planned.label, place * step)

    def batch(start: int) -> list[Pinch]:
        stop = min(start + _BATCH, len(session.pinches))
        return [one(i, session.pinches[i]) for i in range(start, stop)]

    for pinches in pool.map(batch, range(0, len(session.pinches), _BATCH)):
        yield from pinches


def _write(
    path: Path,
    session: PlannedSession,
    condition: Condition,
    seed: int,
    pool: ThreadPoolExecutor,
    progress: Callable[[int], object],
) -> None:
    header = Header(
        layout=fingertip_layout(),
        source="twin",
        sensor="simulated fingertip",
        hand="simulated hand",
        firmware="",
        session=session.name,
        notes=f"pinch twin, condition {condition.name}, seed {seed}",
    )
    with RecordingWriter(path, header) as writer:
        for pinch in pinches_of(session, condition, seed, pool):
            writer.pinch(pinch)
            progress(1)
