"""A whole set of pinches as recordings, one file a session."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from itertools import chain, islice
from pathlib import Path

from firstcontact.core import (
    FINGERTIP_RATE,
    MOST_WORKERS,
    InputError,
    Pinch,
    cores,
    fingertip_layout,
    parallel,
    resolve_path,
    temporary_path,
)
from firstcontact.recording import Header, RecordingWriter
from firstcontact.twin._conditions import Condition, condition
from firstcontact.twin._draw import draw_pinch
from firstcontact.twin._pinch import DURATION, simulate_pinch
from firstcontact.twin._plan import PlannedPinch, PlannedSession, plan_sessions
from firstcontact.twin._recorded_noise import RecordedNoise

#: Sample numbers that pass between two pinches while the hand opens: 1 s.
BETWEEN = round(FINGERTIP_RATE)
#: Most pinches of one specimen: as many as may be recorded of one.
MOST_PINCHES = 1_000_000
#: Pinches of a job.
_BATCH = 8


def simulate(
    directory: Path,
    condition_name: str = "paper-rig",
    pinches_per_block: int = 500,
    pinches_per_object: int = 50,
    seed: int = 0,
    workers: int | None = None,
    progress: Callable[[int], object] = lambda done: None,
    noise: RecordedNoise | None = None,
) -> list[Path]:
    """Simulate a set of pinches.

    Parameters
    ----------
    directory
        Folder for the recordings; must be empty or not exist. It appears when all are written.
    condition_name
        "paper-rig" or "everyday".
    pinches_per_block, pinches_per_object
        Of each of the five blocks and of each of the eight objects.
    seed
        Same seed, same bytes, whatever the workers.
    workers
        Threads of this machine; all cores by default. The mechanics runs outside the GIL. Inside a
        ``joblib.parallel_config`` that names a backend, pinches are made there.
    progress
        Called with the number of pinches just finished.
    noise
        Of a real sensor at rest, in place of the modelled electronics.

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
    check_set(directory, condition_name, pinches_per_block, pinches_per_object, seed, workers)
    c = condition(condition_name)
    sessions = plan_sessions(c, pinches_per_block, pinches_per_object, seed)
    batches = [
        _Batch(session.name, start, session.pinches[start : start + _BATCH])
        for session in sessions
        for start in range(0, len(session.pinches), _BATCH)
    ]
    try:
        with (
            temporary_path(resolve_path(directory)) as folder,
            parallel(workers or cores(), prefer="threads") as runner,
            closing(runner.stream(_made, batches, c, seed, noise)) as made,
        ):
            folder.mkdir()
            pinches = chain.from_iterable(made)
            for session in sessions:
                its = islice(pinches, len(session.pinches))
                _write(folder / _file(session), session, c, seed, its, progress, noise)
            folder.replace(resolve_path(directory))  # refused where it is not empty any more
    except (OSError, InputError) as error:
        # The writer speaks of its own file and of what stays in it; here nothing stays.
        cause = error if isinstance(error, OSError) else error.__cause__
        if not isinstance(cause, OSError) or cause.errno is None:  # a cluster's has none
            raise
        raise InputError(
            f"{directory} cannot be written ({cause.strerror}): make room on its disk, or choose "
            "another folder"
        ) from error
    return [directory / _file(session) for session in sessions]


def check_set(
    directory: Path,
    condition_name: str = "paper-rig",
    pinches_per_block: int = 500,
    pinches_per_object: int = 50,
    seed: int = 0,
    workers: int | None = None,
) -> None:
    """Refuse what :func:`simulate` would refuse before it begins.

    Parameters
    ----------
    directory, condition_name, pinches_per_block, pinches_per_object, seed, workers
        As there.

    Raises
    ------
    InputError
        Names what cannot be used.
    """
    condition(condition_name)
    if min(pinches_per_block, pinches_per_object) < 0 or pinches_per_block + pinches_per_object < 1:
        raise InputError("pinches per block and per object must not be negative nor both 0")
    if max(pinches_per_block, pinches_per_object) > MOST_PINCHES:
        raise InputError(f"pinches per block and per object must be {MOST_PINCHES} at most")
    if seed < 0:
        raise InputError(f"seed is {seed}: use a whole number from 0 on")
    if workers is not None and not 1 <= workers <= MOST_WORKERS:
        raise InputError(f"workers is {workers}: use 1 to {MOST_WORKERS}")
    if directory.exists() and not (directory.is_dir() and not any(directory.iterdir())):
        raise InputError(f"{directory} is not an empty folder: choose another --out")


def _file(session: PlannedSession) -> str:
    return f"{session.name}.mcap"


@dataclass(frozen=True, slots=True)
class _Batch:
    """Pinches of one session that lie side by side: a job.

    Parameters
    ----------
    session
        Its name.
    first
        Place of the first pinch in it.
    pinches
        What is pinched.
    """

    session: str
    first: int
    pinches: Sequence[PlannedPinch]


def _made(
    batch: _Batch, condition: Condition, seed: int, noise: RecordedNoise | None
) -> list[Pinch]:
    """The pinches of a batch: each depends on the seed and its names alone."""
    step = round(DURATION * FINGERTIP_RATE) + BETWEEN
    out = []
    for place, planned in enumerate(batch.pinches, start=batch.first):
        key = planned.label.specimen + f" {planned.number}"
        draw = draw_pinch(seed, condition, batch.session, planned.specimen, key)
        draw = replace(draw, recorded=noise)
        out.append(simulate_pinch(draw, planned.label, place * step))
    return out


def _write(
    path: Path,
    session: PlannedSession,
    condition: Condition,
    seed: int,
    pinches: Iterable[Pinch],
    progress: Callable[[int], object],
    noise: RecordedNoise | None,
) -> None:
    header = Header(
        layout=fingertip_layout(),
        source="twin",
        sensor="simulated fingertip",
        hand="simulated hand",
        firmware="",
        session=session.name,
        notes=f"pinch twin, condition {condition.name}, seed {seed}"
        + ("" if noise is None else f"\n{noise.said}"),
    )
    with RecordingWriter(path, header) as writer:
        for pinch in pinches:
            writer.pinch(pinch)
            progress(1)
