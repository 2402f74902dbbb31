"""Conversion between recordings and datasets."""

from __future__ import annotations

import filecmp
import math
import mmap
import os
import re
import tempfile
from bisect import bisect_right
from collections.abc import Hashable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import AnyPath, Block, Dataset, InputError, Pinch, files_below, given_path
from firstcontact.recording._header import Header, PinchMark
from firstcontact.recording._reader import Recording, read_recording
from firstcontact.recording._writer import RecordingWriter

#: Largest sum of the lengths of all marked pinches, as a multiple of the recording's length. A
#: hand's closings do not overlap so much.
_OVERLAP = 8
#: Size of the recordings up to which a dataset has all samples in memory, bytes.
_IN_MEMORY = 1 << 30


def load_dataset(path: AnyPath | Sequence[AnyPath]) -> Dataset:
    """Load all pinches of one recording, of several recordings, or of a folder and its subfolders.

    The samples keep their type, and can be read-only. The dataset's notes include those of
    the headers, and list damage and omissions. If there are several files, unreadable files are
    skipped and named in the notes, and so are copies of a file. A file that is named twice is read
    once.

    Recordings beyond the first GiB of samples go into a temporary file (in ``TMPDIR``) that is
    mapped into memory, so the system can take this memory back. The file vanishes with the dataset.
    If the disk is full, these samples stay in memory. Worker processes get copies.

    Raises
    ------
    InputError
        No recording or no whole pinch was found, the only file cannot be read, or two recordings
        differ in layout, rate or source.
    """
    paths = [given_path(p) for p in ([path] if isinstance(path, str | os.PathLike) else path)]
    named = [file for p in paths for file in find_recordings(p)]
    files = list({os.path.realpath(file): file for file in named}.values())
    alike: dict[Hashable, list[Path]] = {}  # files that may be copies of each other
    pinches: list[Pinch] = []
    notes: list[str] = []
    losses: list[str] = []
    assumed = False
    first: Recording | None = None
    with ExitStack() as stack:
        store = _Store(stack)
        for file in files:
            try:
                recording = read_recording(file)
            except InputError as error:
                if len(files) == 1:
                    raise
                losses.append(f"left out, since it cannot be read: {error}")
                continue
            if first is None:
                first = recording
            _same_kind(first, recording)
            samples = recording.samples
            key = (recording.header.session, samples, recording.pinches[:1])
            earlier = alike.setdefault(key, [])
            copied = next((f for f in earlier if filecmp.cmp(f, file, shallow=False)), None)
            if copied is not None:
                losses.append(f"{file}: left out, since it is a copy of {copied}")
                continue
            earlier.append(file)
            assumed |= recording.header.session_assumed
            lines = recording.header.notes.splitlines()
            notes += [line for line in lines if line not in notes]
            losses += [f"{file.name}: {sentence}" for sentence in recording.skipped]
            lengths = (mark.end - mark.first_sample for mark in recording.pinches)
            # A pinch that is longer than the recording spans missing samples, and overlaps no
            # others.
            marked = sum(length for length in lengths if length <= samples)
            if marked > _OVERLAP * samples:
                losses.append(f"{file.name}: its pinches overlap too much and are left out")
                continue
            store.begin(recording)
            for mark in recording.pinches:
                pinch = cut(recording, mark)
                if pinch is None:
                    losses.append(
                        f"{file.name}: pinch {mark.number} has missing samples and is left out"
                    )
                else:
                    pinches.append(store.put(pinch))
        pinches = store.restored(pinches)
    if first is None or not pinches:
        raise InputError(
            f"{_name(paths)} holds no whole pinch{_first_loss(losses)}: record some with their "
            "marks, or use `firstcontact import` or `firstcontact simulate`"
        )
    source = first.header.source
    return Dataset(
        tuple(pinches),
        source,
        (*notes, *losses),
        losses=tuple(losses),
        sessions_assumed=assumed,
    )


class _Store:
    """Temporary file for the samples of recordings beyond ``_IN_MEMORY``."""

    def __init__(self, stack: ExitStack) -> None:
        self._stack = stack
        self._file: IO[bytes] | None = None
        self._places: list[tuple[int, int]] = []  # first byte and length of the pinches in the file
        self._end = 0
        self._size = 0
        self._is_full = False

    def begin(self, recording: Recording) -> None:
        """Count all samples of a recording: its pinches are views that keep all of it in memory."""
        self._size += sum(stretch.data.nbytes for stretch in recording.stretches)

    def put(self, pinch: Pinch) -> Pinch:
        """Return a pinch of the newest recording, without its samples if they are in the file."""
        if self._size <= _IN_MEMORY or self._is_full:
            return pinch
        try:
            if self._file is None:
                file = tempfile.TemporaryFile(buffering=0)  # noqa: SIM115
                self._file = self._stack.enter_context(file)
            # Recordings can have samples of 2 and of 4 bytes.
            start = self._file.seek(-(-self._end // 4) * 4)
            left = np.ascontiguousarray(pinch.data).data.cast("B")
            while left:
                left = left[self._file.write(left) :]
        except OSError:
            self._is_full = True
            return pinch
        self._places.append((start, len(pinch.data)))
        self._end = start + pinch.data.nbytes
        return replace(pinch, data=pinch.data[:0].copy())

    def restored(self, pinches: list[Pinch]) -> list[Pinch]:
        """Return the pinches with all their samples."""
        if self._file is None or not self._places:
            return pinches
        # Not numpy.memmap: joblib would tell its workers the name of the file, which has none.
        # Read-only: the system reserves memory for all of a mapping that can be written.
        view = mmap.mmap(self._file.fileno(), self._end, access=mmap.ACCESS_READ)
        places = iter(self._places)

        def mapped(empty: NDArray[Any]) -> NDArray[Any]:
            start, length = next(places)
            shape = (length, empty.shape[1])
            return np.frombuffer(view, empty.dtype, math.prod(shape), start).reshape(shape)

        return [p if len(p.data) else replace(p, data=mapped(p.data)) for p in pinches]


def cut(recording: Recording, mark: PinchMark) -> Pinch | None:
    """Return the samples of a pinch, or None if any of them is missing."""
    data = _within(recording.stretches, mark.epoch, mark.first_sample, mark.end)
    if data is None:
        return None
    groups = {}
    for group in recording.header.layout.groups:
        pace = group.layout.rate / recording.header.layout.rate
        first, end = (math.ceil(sample * pace) for sample in (mark.first_sample, mark.end))
        samples = _within(recording.groups[group.name], mark.epoch, first, end)
        if samples is not None:
            groups[group.name] = Block(samples, first, mark.epoch)
    label = mark.label
    if not label.session:
        label = replace(label, session=recording.header.session)
    header = recording.header
    return Pinch(
        data,
        header.layout,
        label,
        mark.first_sample,
        mark.truth,
        mark.motor_start,
        header.calibration,
        groups,
        mark.closing_speed,
    )


def _within(stretches: Sequence[Block], epoch: int, first: int, end: int) -> NDArray[Any] | None:
    """Return the samples ``first`` to ``end`` of an epoch, or None if any of them is missing."""
    place = bisect_right(stretches, (epoch, first), key=lambda s: (s.epoch, s.first_sample))
    stretch = stretches[place - 1] if place else None
    if stretch is None or stretch.epoch != epoch or end > stretch.end:
        return None
    return stretch.data[first - stretch.first_sample : end - stretch.first_sample]


def write_dataset(dataset: Dataset, directory: AnyPath, header: Header) -> tuple[Path, ...]:
    """Write one recording per session into an existing folder.

    Parameters
    ----------
    dataset
        Pinches. Those of a session keep their order. A pinch whose samples do not follow the
        samples before it begins a new epoch.
    directory
        Folder for the files. A file's name consists of a number and the session, so names sort in
        the order of the sessions.
    header
        Header of every file, to which the session is added.

    Returns
    -------
    tuple of Path
        Paths of the files, in the order of the sessions' first pinches.
    """
    by_session = pinches_by_session(dataset)
    digits = max(3, len(str(len(by_session) - 1)))
    files = []
    for number, (session, pinches) in enumerate(by_session.items()):
        readable = re.sub(r"[^\w.-]+", "-", session)[:40] or "session"
        file = Path(directory) / f"{number:0{digits}d}_{readable}.mcap"
        with RecordingWriter(file, replace(header, session=session)) as writer:
            for pinch in pinches:
                writer.pinch(pinch)
        files.append(file)
    return tuple(files)


def pinches_by_session(dataset: Dataset) -> dict[str, list[Pinch]]:
    """Return the pinches of each session, in the order of the sessions' first pinches."""
    by_session: dict[str, list[Pinch]] = {}
    for pinch in dataset.pinches:
        by_session.setdefault(pinch.label.session, []).append(pinch)
    return by_session


def pause_between(pinches: Sequence[Pinch]) -> tuple[Pinch, ...]:
    """Renumber the pinches one after the other, with a gap of one sample between them."""
    numbered = []
    start = 0
    for pinch in pinches:
        numbered.append(shifted(pinch, start - pinch.first_sample))
        start += len(pinch.data) + 1
    return tuple(numbered)


def shifted(pinch: Pinch, by: int) -> Pinch:
    """Return a pinch with ``by`` added to its sample numbers. Its groups keep their numbers."""
    truth = tuple(replace(c, sample=c.sample + by, decided=c.decided + by) for c in pinch.truth)
    motor = None if pinch.motor_start is None else pinch.motor_start + by
    return replace(pinch, first_sample=pinch.first_sample + by, truth=truth, motor_start=motor)


def find_recordings(path: Path) -> list[Path]:
    """Return the file itself, or all recordings in a folder and below, sorted by name.

    Temporary files of running or killed commands are skipped.

    Raises
    ------
    InputError
        The folder holds no recording.
    """
    if not path.is_dir():
        return [path]
    files = files_below(path, ".mcap")
    if not files:
        raise InputError(
            f"{path} holds no recording (*.mcap): make some with `firstcontact simulate` or "
            "`firstcontact import`"
        )
    return files


def _first_loss(losses: list[str]) -> str:
    return f" ({losses[0]})" if losses else ""


def _name(paths: Sequence[Path]) -> str:
    return ", ".join(map(str, paths)) or "an empty list of recordings"


def _same_kind(first: Recording, other: Recording) -> None:
    a, b = first.header, other.header
    for field, one, two in (
        ("rate", f"{a.layout.rate:g} Hz", f"{b.layout.rate:g} Hz"),
        ("layout", a.layout, b.layout),
        ("source", a.source, b.source),
    ):
        if one != two:
            detail = "" if field == "layout" else f" ({two}, not {one})"
            raise InputError(
                f"{other.path}: its {field} differs from that of {first.path}{detail}: "
                "study them separately"
            )
