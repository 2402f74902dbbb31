"""Recording of labelled pinches into files, with a display for the person who records."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from firstcontact.collect.calibration import rest_request
from firstcontact.collect.guide import Guide, Item, Judged, read_plan
from firstcontact.core import ArgumentError, Calibration, FileError, InputError, Label, Role
from firstcontact.core.calibration import given_calibration
from firstcontact.core.display import Progress, progress_steps
from firstcontact.core.files import AnyPath, given_path
from firstcontact.core.given import given_choice, given_name
from firstcontact.core.text import counted
from firstcontact.device import Descriptor, Source
from firstcontact.device.noise_floor import REST, measure_noise
from firstcontact.device.opening import source_kind
from firstcontact.device.recorder import Recorder
from firstcontact.device.source import drain, require_source
from firstcontact.device.twin_words import object_text
from firstcontact.recording import Header, read_recording
from firstcontact.recording.dataset import cut

#: Longest wait for samples, and so for a request to stop, s.
WAIT = 0.1


class Screen:
    """Display for the person who records. The methods do nothing: override them in a subclass."""

    def say(self, line: str) -> None:
        """Show a line of text."""

    def begin(self, guide: Guide) -> None:
        """Begin the display. ``guide`` names the objects and judges the closings."""

    def end(self) -> None:
        """Show the numbers of samples and closings at the end of the recording."""

    def next_object(self, label: Label, recorded: int, wanted: int) -> bool:
        """Show the next object. Return False if the person must put the object in place first.

        ``wanted`` valid pinches of it are planned, of which ``recorded`` are recorded.
        """
        return True

    def object_is_placed(self) -> bool:
        """Return True once the person has put the next object in place."""
        return True

    def judged(self, judged: Judged) -> None:
        """Show the result of a closing."""

    def going_on(self) -> None:
        """Refresh the display. It is called a few times a second."""


def run_session(
    source: Source,
    guide: Guide,
    path: Path,
    header: Header,
    screen: Screen,
    stopped: Callable[[], bool] = lambda: False,
) -> bool:
    """Record into the new file ``path`` until every object has enough valid pinches.

    Return True if all pinches were recorded, False if ``stopped`` returned True or the source ended
    first. Closes the source. Raises FileError if the file cannot be written.
    """
    with Recorder() as recorder:
        recorder.start(path, header)
        try:
            _follow(source, guide, recorder, screen, stopped)
        finally:
            recorder.put(drain(source))
    if recorder.status.failed:
        raise FileError(recorder.status.failed)
    return guide.current is None


def _follow(
    source: Source, guide: Guide, recorder: Recorder, screen: Screen, stopped: Callable[[], bool]
) -> None:
    """Pass samples from the source to recorder and guide, and results to the screen.

    Return once all pinches are recorded, the source ends, writing fails or ``stopped`` is True.
    """
    label = named = None
    while guide.current is not None and not stopped():
        if guide.current != label:
            label = guide.current
            guide.paused = not screen.next_object(label, *guide.progress(label))
        if label != named:
            # A device that is unplugged now gets the name when it is back.
            with suppress(InputError):
                source.order(object_text(label.object))  # for a hand that is simulated
                source.mark(object_text(label.object))
                named = label
        if guide.paused and screen.object_is_placed():
            guide.paused = False
        arrivals = source.read(WAIT)
        recorder.put(arrivals)
        has_ended = not arrivals and source.ended
        judgements = [j for arrival in arrivals for j in guide.update(arrival)]
        for judged in guide.finish() if has_ended else judgements:
            if judged.mark is not None:
                recorder.mark(judged.mark)
            screen.judged(judged)
        if has_ended or recorder.status.failed:
            return
        screen.going_on()


@dataclass(frozen=True, slots=True)
class SessionProgress:
    """Files and valid pinches of a session that a folder already holds.

    ``path`` is the file to write next, ``counts`` the number of pinches by label, and
    ``unreadable`` the errors of files that cannot be read.
    """

    path: Path
    counts: Counter[Label] = field(default_factory=Counter)
    files: tuple[Path, ...] = ()
    unreadable: tuple[str, ...] = ()


def session_progress(folder: Path, session: str, descriptor: Descriptor) -> SessionProgress:
    """Read the files of a session that a folder already holds. Return what they contain.

    Raises ArgumentError if one is of another session, or of a device other than ``descriptor``.
    """
    stem = "session-" + (re.sub(r"[^\w.+-]+", "-", session) or "-")
    counts: Counter[Label] = Counter()
    files, unreadable = list[Path](), list[str]()
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
            raise ArgumentError(
                f"{part} belongs to session {header.session!r}, not to {session!r}: choose "
                "another name or folder",
                parameter="session",
            )
        if (header.layout, header.source) != (descriptor.layout, descriptor.source):
            raise ArgumentError(
                f"{part} was recorded with another sensor or layout than this device has: choose "
                "another folder",
                parameter="out",
            )
        counts.update(m.label for m in recording.pinches if cut(recording, m) is not None)
        files.append(part)
    return SessionProgress(path, counts, tuple(files), tuple(unreadable))


def record(
    source: Source,
    out: AnyPath,
    *,
    object: str = "",
    pinches: int = 10,
    shore_a: float | None = None,
    specimen: str = "",
    role: Literal["train", "test"] = "train",
    plan: AnyPath | Sequence[Item] | None = None,
    session: str = "1",
    calibration: Calibration | AnyPath | None = None,
    hand: str = "",
    notes: str = "",
    screen: Screen | None = None,
    progress: Progress = None,
    stopped: Callable[[], bool] = lambda: False,
    modulus_mpa: float | None = None,
    stiffness_n_per_mm: float | None = None,
) -> Path:
    """Record a source into a file until each object has enough valid pinches.

    All samples are recorded. Close a real hand yourself: in another thread, or with its own
    control. The simulated hand closes by itself. If ``object`` names an object of the simulated
    hand, such as "block 29" or "apple", the hand pinches it, and you can leave out ``shore_a``.

    Parameters
    ----------
    source
        Open source of samples. It is closed at the end.
    out
        Folder for the recording. If it already holds this session, recording continues in another
        file.
    object, specimen, shore_a, pinches, role
        Object: its name, the name of this physical piece, its Shore A hardness, the number of valid
        pinches to record, and their role: training, or test of models on unseen objects.
    plan
        Several objects instead of one: a CSV file with the columns object, pinches, shore (or
        modulus_mpa, or stiffness_n_per_mm), specimen and role, or the rows of such a file.
    session
        Name of the session. Keep the set-up unchanged within a session.
    calibration
        Calibration with the noise floors, or its file. By default they are measured first.
    hand, notes
        Name of the hand, and remarks, for the header of the recording.
    screen
        Display that shows results and asks for the next object, such as a
        ``firstcontact.collect.session.Screen``.
    progress
        True to show a bar, or a function that is called with 1 for each valid pinch.
    stopped
        Function that is called several times a second. When it returns True, recording ends early.
    modulus_mpa, stiffness_n_per_mm
        Young's modulus of the object, MPa, or its stiffness, N/mm, instead of its Shore A.

    Returns
    -------
    Path
        Path of the recording.

    Raises
    ------
    InputError
        A parameter is not valid, the source fails or ends too early, or the recording cannot be
        written. Samples that are already in the file stay there.

    Examples
    --------
    >>> import firstcontact as fc
    >>> with fc.open("twin", speed=8.0) as source:
    ...     path = fc.record(source, "own", object="block 29", pinches=1)
    >>> data = fc.load(path)
    >>> len(data), float(data.shore_a[0])
    (1, 29.0)
    """
    session = given_name(session, "session")
    require_source(source)
    item = None
    if object:
        use = given_choice(Role, role, "role")
        item = Item(object, pinches, shore_a, specimen, use, modulus_mpa, stiffness_n_per_mm)
    items = _planned_items(source, item, plan)
    floors = given_calibration(calibration)
    folder = given_path(out, "out")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ArgumentError(
            f"the folder cannot be created ({error.strerror}): choose another one", parameter="out"
        ) from error
    wanted = sum(item.pinches for item in items)
    with progress_steps(progress, wanted, "pinch") as step:
        descriptor = source.descriptor
        header = descriptor.header(
            session=session, calibration=floors, hand=hand or descriptor.hand, notes=notes
        )
        return _record(source, folder, items, header, screen or _CountingScreen(step), stopped)


def _record(
    source: Source,
    folder: Path,
    items: tuple[Item, ...],
    header: Header,
    screen: Screen,
    stopped: Callable[[], bool],
) -> Path:
    session, calibration = header.session, header.calibration
    foreign = [p for p in folder.glob("[!.]*.mcap") if not p.name.startswith("session-")]
    if foreign:
        screen.say(
            f"note: {folder} holds {counted(len(foreign), 'recording')} that `record` did not "
            "make, and `train` learns from all of a folder: choose another folder to keep them "
            "apart"
        )
    earlier = session_progress(folder, session, source.descriptor)
    for sentence in earlier.unreadable:
        screen.say(f"warning: skipped: {sentence}")
    layout = source.descriptor.layout
    if all(earlier.counts[item.label(session)] >= item.pinches for item in items):
        screen.say(f"session {session} is complete: {earlier.files[-1]}")
        return earlier.files[-1]
    if calibration is None or len(calibration.piezo) < len(layout.vibration_fingers):
        screen.say(f"measuring the noise floor at rest for {REST:g} s: {rest_request(layout)}")
        measured = measure_noise(source)
        calibration = calibration or Calibration(created=measured.created)
        missing = (p for p in measured.piezo if calibration.noise(p.finger) is None)
        calibration = replace(calibration, piezo=(*calibration.piezo, *missing))
    guide = Guide(layout, items, session, calibration, earlier.counts)
    header = replace(header, calibration=calibration)
    screen.say(f"session {session}: {earlier.path}")
    screen.begin(guide)
    try:
        complete = run_session(source, guide, earlier.path, header, screen, stopped)
    finally:
        screen.end()
    if not complete and not stopped():
        raise ArgumentError(
            "the source ended before all pinches were recorded: run the command again with the "
            f"same session and folder, to continue {earlier.path}",
            parameter="source",
        )
    return earlier.path


def _planned_items(
    source: Source, item: Item | None, plan: AnyPath | Sequence[Item] | None
) -> tuple[Item, ...]:
    """Return the objects to record: ``item`` alone, or those of ``plan``.

    If the source is a simulated hand, an object without a label gets the Shore A of the simulated
    object. Raises ArgumentError if both ``item`` and ``plan`` are given, or neither.
    """
    if (plan is None) == (item is None):
        raise ArgumentError(
            "give either one object or a plan for several, not both"
            if item
            else "no object is given: name one, or give a plan for several",
            parameter="object",
        )
    if plan is None:
        items: tuple[Item, ...] = () if item is None else (item,)
    elif isinstance(plan, str | os.PathLike):
        items = read_plan(Path(plan))
    else:
        items = tuple(plan)
    shore_a_of = source_kind(source.name).shore_a
    if shore_a_of is None:
        return items
    return tuple(
        replace(i, shore=shore_a_of(i.object)) if i.label("").value is None else i for i in items
    )


class _CountingScreen(Screen):
    """Screen that shows nothing, and calls ``step(1)`` for each valid pinch."""

    def __init__(self, step: Callable[[int], object]) -> None:
        self._step = step

    def judged(self, judged: Judged) -> None:
        if not judged.faults:
            self._step(1)
