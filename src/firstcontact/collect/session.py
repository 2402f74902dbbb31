"""Session of a guided recording: source, recorder, guide and files."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from firstcontact.collect.guide import Guide, Judged
from firstcontact.core import InputError, Label
from firstcontact.device import Descriptor, Source
from firstcontact.device.recorder import Recorder
from firstcontact.device.source import drain
from firstcontact.device.twin_words import object_text
from firstcontact.recording import Header, read_recording
from firstcontact.recording.dataset import cut

#: Longest wait for samples, and so for a request to stop, s.
WAIT = 0.1


class Screen:
    """Display for the person who records. Subclasses show results and ask for the next object."""

    def say(self, line: str) -> None:
        """Show a line."""

    def begin(self, guide: Guide) -> None:
        """Start to show a recording, whose guide names the objects and judges the closings."""

    def end(self) -> None:
        """Show the numbers of samples and closings. The recording has ended."""

    def next_object(self, label: Label, recorded: int, wanted: int) -> bool:
        """Show the next object. Return False if the person has to put it in place first."""
        return True

    def in_place(self) -> bool:
        """Return True if the person has put the object in place."""
        return True

    def judged(self, judged: Judged) -> None:
        """Show the result of a closing."""

    def going_on(self) -> None:
        """Refresh the display. Called a few times a second."""


def run_session(
    source: Source,
    guide: Guide,
    path: Path,
    header: Header,
    screen: Screen,
    stopped: Callable[[], bool] = lambda: False,
) -> bool:
    """Record until every object has its pinches. Return True if all were recorded."""
    with Recorder() as recorder:
        recorder.start(path, header)
        try:
            _follow(source, guide, recorder, screen, stopped)
        finally:
            recorder.put(drain(source))
    if recorder.status.failed:
        raise InputError(recorder.status.failed)
    return guide.current is None


def _follow(
    source: Source, guide: Guide, recorder: Recorder, screen: Screen, stopped: Callable[[], bool]
) -> None:
    """Record until the pinches are complete, the source ends, writing fails or the person stops."""
    label: Label | None = None
    named = True
    while guide.current is not None and not stopped():
        if guide.current != label:
            label = guide.current
            named = False
            guide.paused = not screen.next_object(label, *guide.progress(label))
        if not named and label is not None:
            # A device that is unplugged now gets the name when it is back.
            with suppress(InputError):
                source.order(object_text(label.object))  # for a hand that is simulated
                source.mark(object_text(label.object))
                named = True
        if guide.paused and screen.in_place():
            guide.paused = False
        arrivals = source.read(WAIT)
        recorder.put(arrivals)
        judged = [j for arrival in arrivals for j in guide.update(arrival)]
        if not arrivals and source.ended:
            _tell(guide.finish(), recorder, screen)
            return
        _tell(judged, recorder, screen)
        if recorder.status.failed:
            return
        screen.going_on()


def _tell(judgements: list[Judged], recorder: Recorder, screen: Screen) -> None:
    for judged in judgements:
        if judged.mark is not None:
            recorder.mark(judged.mark)
        screen.judged(judged)


@dataclass(frozen=True, slots=True)
class SoFar:
    """Files and pinches of a session that are already in a folder."""

    path: Path
    counts: Counter[Label] = field(default_factory=Counter)
    files: tuple[Path, ...] = ()
    unreadable: tuple[str, ...] = ()


def so_far(folder: Path, session: str, descriptor: Descriptor) -> SoFar:
    """Return the files and pinches of a session that a folder holds."""
    stem = "session-" + (re.sub(r"[^\w.+-]+", "-", session) or "-")
    pinches_by_label: Counter[Label] = Counter()
    files: list[Path] = []
    unreadable: list[str] = []
    path = folder / f"{stem}.mcap"
    while os.path.lexists(path):
        parts = len(files) + len(unreadable) + 1
        part, path = path, folder / f"{stem}.part{parts + 1}.mcap"
        try:
            recording = read_recording(part)
        except InputError as error:
            unreadable.append(str(error))
            continue
        header = recording.header
        if header.session != session:
            raise InputError(
                f"{part} belongs to session {header.session!r}, not to {session!r}: choose "
                "another name or folder",
                parameter="session",
            )
        if (header.layout, header.source) != (descriptor.layout, descriptor.source):
            raise InputError(
                f"{part} was recorded with another sensor or layout than this device has: choose "
                "another folder",
                parameter="out",
            )
        pinches_by_label.update(
            mark.label for mark in recording.pinches if cut(recording, mark) is not None
        )
        files.append(part)
    return SoFar(path, pinches_by_label, tuple(files), tuple(unreadable))
