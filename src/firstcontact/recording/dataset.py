"""Functions that load a dataset from recordings, and write one as recordings."""

from __future__ import annotations

import filecmp
import math
import os
import re
from bisect import bisect_right
from collections.abc import Hashable, Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, Dataset, FileError, Finger, InputError, Pinch
from firstcontact.core.files import AnyPath, files_below, given_path
from firstcontact.core.units import VOLT, VOLTS, Unit, fit_unit, parse_unit
from firstcontact.recording._reader import Recording, read_recording
from firstcontact.recording._writer import RecordingWriter
from firstcontact.recording.messages import Header, PinchMark


def load(path: AnyPath | Iterable[AnyPath]) -> Dataset:
    """Load the pinches (closings of the hand) in recordings, with their labels.

    Parameters
    ----------
    path
        A recording (.mcap file); a folder, which is searched with all folders in it; or a list of
        recordings and folders. A recording that is named twice is loaded once.

    Returns
    -------
    Dataset
        Pinches with their labels. Copies of recordings, and pinches with missing samples, are left
        out and named in ``losses``.

    Raises
    ------
    InputError
        No recording exists or can be read, or two recordings differ in channels, sampling rate or
        source (simulated or real).

    Examples
    --------
    >>> import firstcontact as fc
    >>> data = fc.load("recordings")
    >>> data
    Dataset(60 pinches, 5 objects, 10 sessions, 4936 Hz, source='twin')
    """
    paths = [given_path(p) for p in ([path] if isinstance(path, str | os.PathLike) else path)]
    named = [file for p in paths for file in find_recordings(p)]
    files = list({os.path.realpath(file): file for file in named}.values())
    alike: dict[Hashable, list[Path]] = {}  # files that may be copies of each other
    pinches: list[Pinch] = []
    notes: dict[str, None] = {}
    losses: list[str] = []
    assumed = False
    first: tuple[Path, Header] | None = None
    for file in files:
        try:
            recording = read_recording(file)
        except InputError as error:
            if len(files) == 1:
                raise
            losses.append(f"left out, since it cannot be read: {error}")
            continue
        header = recording.header
        first = first or (file, header)
        _check_same_kind(*first, file, header)
        earlier = alike.setdefault((header.session, recording.samples, recording.pinches[:1]), [])
        copied = next((f for f in earlier if filecmp.cmp(f, file, shallow=False)), None)
        if copied is not None:
            losses.append(f"{file}: left out, since it is a copy of {copied}")
            continue
        earlier.append(file)
        assumed |= header.session_assumed
        notes |= dict.fromkeys(header.notes.splitlines())
        losses += [f"{file.name}: {sentence}" for sentence in recording.skipped]
        for mark in recording.pinches:
            pinch = cut(recording, mark)
            if pinch is None:
                losses.append(
                    f"{file.name}: pinch {mark.number} has missing samples and is left out"
                )
            else:
                pinches.append(pinch)
    if first is None or not pinches:
        name = ", ".join(map(str, paths)) or "an empty list of recordings"
        reason = f" ({losses[0]})" if losses else ""
        raise FileError(
            f"{name} holds no whole pinch{reason}: record pinches, or make recordings with "
            "`firstcontact import` or `firstcontact simulate`"
        )
    return Dataset(
        _in_volts(pinches) if first[1].source == "real" else tuple(pinches),
        first[1].source,
        (*notes, *losses),
        losses=tuple(losses),
        sessions_assumed=assumed,
    )


#: Name of :func:`load` in this room.
load_dataset = load


def _in_volts(pinches: Sequence[Pinch]) -> tuple[Pinch, ...]:
    """Convert pinches whose vibrations are in ADC counts or mV, as in older recordings, to V.

    Calibrations are converted, too. Pinches in other units are returned unchanged.
    """
    layout = pinches[0].layout
    channels, units = list(layout.channels), dict[Finger | None, Unit]()
    if len(layout.vibration) < layout.width or len({c.unit for c in channels}) > 1:
        return tuple(pinches)
    for k, channel in enumerate(channels):
        unit = parse_unit(channel.unit)
        if (
            unit is None
            or unit == VOLT
            or unit.name != VOLTS
            or (channel.scale, channel.offset) != (1, 0)
        ):
            continue
        with suppress(InputError):  # counts of another converter stay what they are
            values = np.concatenate([p.data[:, k : k + 1] for p in pinches])
            unit = fit_unit(channel.name, unit, values[np.isfinite(values)][:, None])
            channels[k] = replace(channel, unit=VOLTS, scale=unit.scale, offset=unit.offset)
            units[channel.finger] = unit
    layout = replace(layout, channels=tuple(channels))

    def convert(pinch: Pinch) -> Pinch:
        known = pinch.calibration
        if known is not None:
            piezo = [(units.get(p.finger, VOLT), p) for p in known.piezo]
            scaled = [
                replace(p, noise=p.noise * u.scale, offset=(p.offset - u.offset) * u.scale)
                for u, p in piezo
            ]
            known = replace(known, piezo=tuple(scaled))
        return replace(pinch, layout=layout, calibration=known)

    return tuple(map(convert, pinches)) if units else tuple(pinches)


def cut(recording: Recording, mark: PinchMark) -> Pinch | None:
    """Cut the pinch at ``mark`` out of a recording; None if any of its samples is missing."""
    data = _samples_between(recording.stretches, mark.epoch, mark.first_sample, mark.end)
    if data is None:
        return None
    groups = {}
    for group in recording.header.layout.groups:
        pace = group.layout.rate / recording.header.layout.rate
        first, end = (math.ceil(sample * pace) for sample in (mark.first_sample, mark.end))
        samples = _samples_between(recording.groups[group.name], mark.epoch, first, end)
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


def _samples_between(
    stretches: Sequence[Block], epoch: int, first: int, end: int
) -> NDArray[Any] | None:
    """Return the samples ``first`` to ``end`` (exclusive) of an epoch; None if any is missing."""
    place = bisect_right(stretches, (epoch, first), key=lambda s: (s.epoch, s.first_sample))
    stretch = stretches[place - 1] if place else None
    if stretch is None or stretch.epoch != epoch or end > stretch.end:
        return None
    return stretch.part(first, end).data


def write_dataset(dataset: Dataset, directory: AnyPath, header: Header) -> tuple[Path, ...]:
    """Write a dataset to an existing folder, one recording for each session. Return the paths.

    Each file gets ``header``, with the name of the session. File names begin with a number, so that
    they sort in the order of the sessions' first pinches. Pinches of a session keep their order. If
    samples are missing between two pinches, the second pinch begins a new epoch.
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
    """Return lists of pinches by session, in the order of the sessions' first pinches."""
    by_session: dict[str, list[Pinch]] = {}
    for pinch in dataset.pinches:
        by_session.setdefault(pinch.label.session, []).append(pinch)
    return by_session


def pause_between(pinches: Sequence[Pinch]) -> tuple[Pinch, ...]:
    """Renumber the samples of pinches, so that one number is missing between two pinches."""
    numbered = []
    start = 0
    for pinch in pinches:
        numbered.append(shifted(pinch, start - pinch.first_sample))
        start += len(pinch.data) + 1
    return tuple(numbered)


def shifted(pinch: Pinch, by: int) -> Pinch:
    """Return a pinch with ``by`` added to all sample numbers, except those of its groups."""
    truth = tuple(replace(c, sample=c.sample + by, decided=c.decided + by) for c in pinch.truth)
    motor = None if pinch.motor_start is None else pinch.motor_start + by
    return replace(pinch, first_sample=pinch.first_sample + by, truth=truth, motor_start=motor)


def find_recordings(path: Path) -> list[Path]:
    """Return [path] for a file, and for a folder all recordings in it and below, sorted by name.

    Raises FileError if the folder holds no recording.
    """
    if not path.is_dir():
        return [path]
    files = files_below(path, ".mcap")
    if not files:
        raise FileError(
            f"{path} holds no recording (*.mcap): convert other files with `firstcontact import` "
            "(`import_recordings` in Python), or make recordings with `firstcontact simulate`"
        )
    return files


def _check_same_kind(first: Path, a: Header, path: Path, b: Header) -> None:
    for field, one, two in (
        ("rate", f"{a.layout.rate:g} Hz", f"{b.layout.rate:g} Hz"),
        ("layout", a.layout.channels, b.layout.channels),
        ("source", a.source, b.source),
    ):
        if one != two:
            detail = "" if field == "layout" else f" ({two}, not {one})"
            raise FileError(
                f"{path}: its {field} differs from that of {first}{detail}: load them separately"
            )
