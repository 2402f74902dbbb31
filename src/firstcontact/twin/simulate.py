"""A whole set of pinches as recordings, one file a session."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from itertools import chain, islice
from pathlib import Path

from firstcontact.core.errors import InputError
from firstcontact.core.files import replacing
from firstcontact.core.jobs import MOST_WORKERS, cores, parallel
from firstcontact.core.layout import FINGERTIP_RATE, fingertip_layout
from firstcontact.core.pinch import Pinch
from firstcontact.core.temporary import sweep
from firstcontact.recording import Header, RecordingWriter
from firstcontact.twin._plan import PlannedPinch, PlannedSession, plan_sessions
from firstcontact.twin.conditions import Condition, condition
from firstcontact.twin.draw import draw_pinch
from firstcontact.twin.pinch import DURATION, simulate_pinch
from firstcontact.twin.recorded_noise import RecordedNoise

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
        Where the recordings go; must be empty or not exist.
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
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{directory} cannot be made: {error.strerror}; choose another --out"
        ) from error
    sessions = plan_sessions(c, pinches_per_block, pinches_per_object, seed)
    batches = [
        _Batch(session.name, start, session.pinches[start : start + _BATCH])
        for session in sessions
        for start in range(0, len(session.pinches), _BATCH)
    ]
    paths = []
    with (
        parallel(workers or cores(), prefer="threads") as runner,
        closing(runner.stream(_made, batches, c, seed, noise)) as made,
    ):
        pinches = chain.from_iterable(made)
        for session in sessions:
            path = directory / _file(session)
            its = islice(pinches, len(session.pinches))
            try:
                with replacing(path) as temporary:
                    _write(temporary, session, c, seed, its, progress, noise)
            except InputError as error:
                # The writer speaks of its own file and of what stays in it; of this one nothing
                # stays.
                if isinstance(error.__cause__, OSError):
                    raise InputError(
                        f"{path} cannot be written ({error.__cause__.strerror}): make room on its "
                        "disk, and simulate into another --out"
                    ) from error
                raise
            paths.append(path)
    return paths


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
        Names what cannot be used; of a set that was not finished, how much of it is there.
    """
    c = condition(condition_name)
    if min(pinches_per_block, pinches_per_object) < 0 or pinches_per_block + pinches_per_object < 1:
        raise InputError("pinches per block and per object must not be negative nor both 0")
    if max(pinches_per_block, pinches_per_object) > MOST_PINCHES:
        raise InputError(f"pinches per block and per object must be {MOST_PINCHES} at most")
    if seed < 0:
        raise InputError(f"seed is {seed}: use a whole number from 0 on")
    if workers is not None and not 1 <= workers <= MOST_WORKERS:
        raise InputError(f"workers is {workers}: use 1 to {MOST_WORKERS}")
    sweep(directory)
    there = {path.name for path in directory.iterdir()} if directory.is_dir() else set()
    if there:
        sessions = plan_sessions(c, pinches_per_block, pinches_per_object, seed)
        whole = {_file(session) for session in sessions}
        if there < whole:
            raise InputError(
                f"{directory} holds {len(there)} of the {len(whole)} recordings of such a set, "
                "whose making was stopped: remove it, or choose another --out"
            )
    if there or (directory.exists() and not directory.is_dir()):
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
