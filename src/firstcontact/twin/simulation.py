"""Simulation of sets of pinches, which writes one recording per session."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from contextlib import closing, nullcontext
from dataclasses import dataclass, replace
from itertools import chain, islice
from operator import index
from pathlib import Path
from typing import Literal

from firstcontact.core import (
    ArgumentError,
    Dataset,
    FileError,
    InputError,
    Label,
    Pinch,
    Role,
    fingertip_layout,
)
from firstcontact.core.display import Progress, progress_steps
from firstcontact.core.files import AnyPath, given_path, resolved, temporary_path
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.jobs.runners import MOST_WORKERS, Runner, cores, parallel
from firstcontact.recording import Header, RecordingWriter
from firstcontact.recording.dataset import load
from firstcontact.twin.draw import Condition, condition, draw_pinch, draw_specimen, generator
from firstcontact.twin.drive import Positions
from firstcontact.twin.noise import RecordedNoise, read_noise
from firstcontact.twin.objects import BLOCKS, EVERYDAY_OBJECTS, TwinObject
from firstcontact.twin.pinch import DURATION, PinchJob, simulate_pinches

#: Number of sessions of block pinches.
BLOCK_SESSIONS = 10
#: Number of sessions of pinches of other objects.
OBJECT_SESSIONS = 2


@dataclass(frozen=True, slots=True)
class PlannedPinch:
    specimen: TwinObject
    label: Label
    number: int


@dataclass(frozen=True, slots=True)
class PlannedSession:
    name: str
    pinches: tuple[PlannedPinch, ...]


def plan_sessions(
    condition: Condition, pinches_per_block: int, pinches_per_object: int, seed: int
) -> tuple[PlannedSession, ...]:
    """Return the sessions to simulate: first those with flat blocks, then everyday objects."""
    blocks = _sessions(condition, "blocks", BLOCKS, pinches_per_block, BLOCK_SESSIONS, seed)
    objects = _sessions(
        condition, "objects", EVERYDAY_OBJECTS, pinches_per_object, OBJECT_SESSIONS, seed
    )
    return (*blocks, *objects)


def _sessions(
    condition: Condition,
    group: str,
    kinds: tuple[TwinObject, ...],
    each: int,
    sessions: int,
    seed: int,
) -> list[PlannedSession]:
    out = []
    for s in range(min(sessions, each)):
        name = f"{group}-{s + 1:02d}"
        pinches = []
        for kind in kinds:
            for k in range(s, each, sessions):
                pinches.append(planned_pinch(seed, condition, kind, name, k // sessions, k))
        order = generator(seed, condition.name, "order", name).permutation(len(pinches))
        out.append(PlannedSession(name, tuple(pinches[i] for i in order)))
    return out


def planned_pinch(
    seed: int, condition: Condition, kind: TwinObject, session: str, copy: int, number: int
) -> PlannedPinch:
    """Return the plan of pinch ``number`` of a session. ``copy`` chooses the specimen.

    If ``copy`` exceeds the number of specimens, it starts again at the first one.
    """
    copies = condition.specimens_per_block if kind.role is Role.TRAIN else 1
    copy %= copies
    one = draw_specimen(seed, condition, kind, copy)
    mark = f"{kind.name} #{copy + 1}" if copies > 1 else kind.name
    label = Label(kind.name, kind.shore_a, None, mark, session, kind.role, kind.shape)
    return PlannedPinch(one, label, number)


#: Number of samples, not recorded, between two pinches while the hand opens: 1 s.
BETWEEN = round(FINGERTIP_RATE)
#: Largest number of pinches of one specimen, as for recordings.
MOST_PINCHES = 1_000_000
#: Number of pinches that one job simulates.
_BATCH = 8


def simulate(
    out: AnyPath,
    *,
    condition: Literal["paper-rig", "everyday"] = "paper-rig",
    pinches_per_block: int = 500,
    pinches_per_object: int = 50,
    seed: int = 0,
    workers: int | None = None,
    noise: AnyPath | None = None,
    positions: bool = False,
    progress: Progress = None,
) -> Dataset:
    """Simulate labelled pinches of five flat blocks and eight other objects with a simulated hand.

    Parameters
    ----------
    out
        Folder for the recordings; it must be empty or new.
    condition
        Variation between pinches: "paper-rig" as in the published set-up, "everyday" as outside a
        lab.
    pinches_per_block, pinches_per_object
        Number of pinches with each of the five blocks, and with each of the eight other objects.
    seed
        Random seed. The same seed gives files with the same bytes.
    workers
        Number of threads; all cores by default. It does not change the result.
    noise
        Path of a recording of a real sensor at rest. Its noise replaces the simulated noise of the
        electronics and the simulated hum.
    positions
        True to simulate a hand that reports its positions, so that each pinch has a measured
        ``closing_speed``.
    progress
        True to show a bar, or a function that is called with the number of pinches just finished.

    Returns
    -------
    Dataset
        The simulated pinches.

    Raises
    ------
    InputError
        A parameter is out of range, or ``out`` is not empty.

    Examples
    --------
    >>> import firstcontact as fc
    >>> data = fc.simulate("few", pinches_per_block=2, pinches_per_object=0)
    >>> len(data), data.source
    (10, 'twin')
    """
    folder = given_path(out, "out")
    recorded = None if noise is None else read_noise(given_path(noise, "noise"))
    sizes = pinches_per_block, pinches_per_object
    simulate_recordings(folder, condition, *sizes, seed, workers, progress, recorded, positions)
    return load(folder)


def simulate_recordings(
    directory: Path,
    condition_name: str = "paper-rig",
    pinches_per_block: int = 500,
    pinches_per_object: int = 50,
    seed: int = 0,
    workers: int | None = None,
    progress: Progress = None,
    noise: RecordedNoise | None = None,
    positions: bool = False,
    runner: Runner | None = None,
) -> list[Path]:
    """Simulate pinches as :func:`simulate` does. Return the paths of the recordings.

    ``noise`` is recorded noise of a real sensor at rest. ``runner`` simulates the pinches; by
    default threads of this process do, or the backend of ``joblib.parallel_config``.
    """
    c = condition(condition_name)
    _check_set(directory, pinches_per_block, pinches_per_object, seed, workers)
    sessions = plan_sessions(c, pinches_per_block, pinches_per_object, seed)
    batches = [
        _Batch(session.name, start, session.pinches[start : start + _BATCH])
        for session in sessions
        for start in range(0, len(session.pinches), _BATCH)
    ]
    total = sum(len(session.pinches) for session in sessions)
    threads = parallel(workers or cores(), prefer="threads")
    try:
        with (
            temporary_path(resolved(directory)) as folder,
            threads if runner is None else nullcontext(runner) as pool,
            closing(pool.stream(_simulate_batch, batches, c, seed, noise, positions)) as made,
            progress_steps(progress, total, "pinch", c.name) as step,
        ):
            folder.mkdir()
            pinches = chain.from_iterable(made)
            for session in sessions:
                session_pinches = islice(pinches, len(session.pinches))
                _write(folder, session, c, seed, session_pinches, step, noise)
            folder.replace(resolved(directory))  # fails if the folder is no longer empty
    except (OSError, InputError) as error:
        # The writer's message names a temporary file. Name the folder instead.
        cause = error if isinstance(error, OSError) else error.__cause__
        if not isinstance(cause, OSError) or cause.errno is None:  # such as an error of a cluster
            raise
        raise FileError(
            f"{directory} cannot be written ({cause.strerror}): make room on the disk, or choose "
            "another folder"
        ) from error
    return [directory / f"{session.name}.mcap" for session in sessions]


def _check_set(
    directory: Path, pinches_per_block: int, pinches_per_object: int, seed: int, workers: int | None
) -> None:
    for name, value, least, most in (
        ("pinches_per_block", pinches_per_block, 0, MOST_PINCHES),
        ("pinches_per_object", pinches_per_object, 0, MOST_PINCHES),
        ("seed", seed, 0, math.inf),
        ("workers", 1 if workers is None else workers, 1, MOST_WORKERS),
    ):
        try:
            is_possible = least <= index(value) <= most
        except TypeError:
            is_possible = False
        if not is_possible:
            limit = "" if most == math.inf else f" to {most}"
            raise ArgumentError(
                f"{value!r} cannot be used: give a whole number from {least}{limit}",
                parameter=name,
            )
    if not pinches_per_block + pinches_per_object:
        raise ArgumentError(
            "pinches_per_block and pinches_per_object are both 0: give at least one above 0"
        )
    if directory.exists() and not (directory.is_dir() and not any(directory.iterdir())):
        raise FileError(f"{directory} is not an empty folder: choose another one")


@dataclass(frozen=True, slots=True)
class _Batch:
    session: str
    first: int
    pinches: Sequence[PlannedPinch]


def _simulate_batch(
    batch: _Batch,
    condition: Condition,
    seed: int,
    noise: RecordedNoise | None,
    positions: bool,
) -> list[Pinch]:
    """Return the simulated pinches of a batch, in order.

    A pinch is the same in any batch. With ``positions``, each pinch has a measured closing speed.
    ``noise`` replaces the simulated noise of the electronics, unless it is None.
    """
    step = round(DURATION * FINGERTIP_RATE) + BETWEEN
    jobs = []
    for place, planned in enumerate(batch.pinches, start=batch.first):
        key = planned.label.specimen + f" {planned.number}"
        draw = draw_pinch(seed, condition, batch.session, planned.specimen, key)
        draw = replace(draw, recorded=noise)
        sensor = None
        if positions:
            sensor = Positions(generator(seed, condition.name, "positions", batch.session, key))
        jobs.append(PinchJob(draw, planned.label, place * step, sensor))
    return list(simulate_pinches(jobs))


def _write(
    folder: Path,
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
        + ("" if noise is None else f"\n{noise.description}"),
    )
    with RecordingWriter(folder / f"{session.name}.mcap", header) as writer:
        for pinch in pinches:
            writer.pinch(pinch)
            progress(1)
