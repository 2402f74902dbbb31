"""Labelling of recordings by a person on a web page: state of a session, and server."""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from msgspec import Meta

from firstcontact.collect._label_marks import (
    MOST,
    Action,
    Journal,
    Mark,
    Marks,
    Opened,
    Whole,
    measured,
)
from firstcontact.collect.label_result import Labeller, is_inside, write_labelled
from firstcontact.contact.finder import find_onsets
from firstcontact.core import ArgumentError, ChannelKind, FileError, InputError, Label, finger_name
from firstcontact.core.records import read_record
from firstcontact.core.text import counted
from firstcontact.recording import Recording, read_recording
from firstcontact.recording.dataset import find_recordings

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection


#: Largest number of points of a channel in a piece. Longer pieces are reduced to minima and maxima.
POINTS = 2000
#: Greatest length of a piece on either side of its middle, s.
WIDEST = 2.0


def open_recordings(paths: Sequence[Path]) -> list[Recording]:
    """Read all recordings in files and folders.

    Raises InputError for a recording without samples, and for two with the same file name.
    """
    files = [file for path in paths for file in find_recordings(path)]
    names = [file.name for file in files]
    doubled = next((name for name in names if names.count(name) > 1), None)
    if doubled is not None:
        raise ArgumentError(f"two recordings are called {doubled}: label them in separate commands")
    recordings = [read_recording(file) for file in files]
    empty = next((r for r in recordings if not r.samples), None)
    if empty is not None:
        raise FileError(f"{empty.path} holds no samples: leave this recording out")
    return recordings


def find_marks(recordings: Sequence[Recording]) -> list[Mark]:
    """Detect all contacts in recordings. A contact inside a marked pinch gets the pinch's label.

    Raises InputError if there are no contacts, or too many for one session.
    """
    out: list[Mark] = []
    for number, recording in enumerate(recordings):
        layout = recording.header.layout
        columns = layout.columns(ChannelKind.VIBRATION)
        for place, block in enumerate(recording.stretches):
            for onset in find_onsets(layout.physical(block.data, columns), layout.rate):
                sample = onset.sample
                mark = Mark(len(out), number, place, onset.column, sample, sample)
                pinch = next((p for p in recording.pinches if is_inside(p, block, sample)), None)
                label = Label() if pinch is None else pinch.label
                out.append(replace(mark, object=label.object, **measured(label)))
    if not out:
        names = ", ".join(r.path.name for r in recordings[:3])
        raise FileError(
            f"no contact is found in {names}{' and others' if len(recordings) > 3 else ''}: give "
            "recordings with contacts that are louder than the noise"
        )
    if len(out) > MOST:
        raise ArgumentError(
            f"{recordings[0].path} and the other recordings have {len(out)} onsets, more than "
            f"{MOST}: label them in several commands"
        )
    return out


def piece(recording: Recording, stretch: int, middle: int, half: float) -> dict[str, Any]:
    """Return the vibration signals around the sample ``middle``, for a plot on the page.

    ``stretch`` is the index of the block, and ``half`` the time to show on each side, s. The dict
    has "first" (the first sample), "step" (the number of samples per point), and the minima
    ("least") and maxima ("most") per point of each channel.
    """
    layout = recording.header.layout
    block = recording.stretches[stretch]
    reach = max(1, round(min(half, WIDEST) * layout.rate))
    first, end = max(0, middle - reach), min(len(block.data), middle + reach + 1)
    values = layout.physical(block.data[first:end], layout.columns(ChannelKind.VIBRATION))
    step = max(1, -(-len(values) // POINTS))
    edges = np.arange(0, len(values), step)
    least, most = np.minimum.reduceat(values, edges), np.maximum.reduceat(values, edges)
    extremes = {
        name: [[float(f"{v:.6g}") for v in column] for column in values.T.tolist()]
        for name, values in (("least", least), ("most", most))
    }
    return {"first": first, "step": step, **extremes}


#: Longest message from the page, bytes.
LONGEST = 4096
HOST = "127.0.0.1"
#: Interval between polls for a request to stop, s.
POLL = 0.1
#: Actions that change one mark only, so that the page keeps the others.
_OF_ONE = ("accept", "reject", "move")
#: Field that only requests have. The colon excludes an object with the name "ask".
_QUESTION = re.compile(rb'"ask"\s*:')


@dataclass(frozen=True, slots=True)
class _Request:
    """Message from the page: a request for the signal around a sample, or to end the labelling."""

    ask: Literal["signal", "finish"]
    number: Whole = 0
    recording: Whole = 0
    stretch: Whole = 0
    sample: Whole = 0
    half: Annotated[float, Meta(gt=0.0, le=WIDEST)] = 0.02


class Session:
    """State of the labelling of some recordings, stored in a journal in the folder ``out``.

    :meth:`finish` writes the labelled recordings to ``out``. ``by`` is the origin of the
    labels. Raises FileError if ``out`` already holds labelled recordings, or a journal about other
    recordings.
    """

    def __init__(
        self, recordings: Sequence[Recording], out: Path, by: Labeller, is_new_allowed: bool = True
    ) -> None:
        self._recordings = list(recordings)
        self._by = by
        self._paths = [out / r.path.name for r in recordings]
        existing = next((p for p in self._paths if p.exists()), None)
        if existing is not None:
            raise FileError(
                f"{existing} exists and recordings are never overwritten: choose another folder"
            )
        onsets = find_marks(recordings)
        self.marks = Marks(onsets, [[len(s.data) for s in r.stretches] for r in recordings])
        try:
            if is_new_allowed:
                out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(
                f"{out} cannot be created ({error.strerror}): choose another folder"
            ) from error
        self._journal = Journal(
            out / "labels.jsonl",
            Opened(tuple(r.path.name for r in recordings), len(onsets)),
            is_new_allowed,
        )
        try:
            for action in self._journal.actions:
                self.marks.act(action)
        except InputError as error:
            self._journal.close()
            raise FileError(
                f"{self._journal.path} labels onsets that these recordings do not have: move it "
                "away to start again, or choose another folder"
            ) from error
        #: New recordings, once they are written.
        self.written: list[Path] = []

    @property
    def earlier(self) -> str:
        """Text about the number of actions that were read from the journal at the start."""
        lost = self._journal.lost_bytes
        damage = f" ({self._journal.path} ends in {lost} bytes that cannot be read)" if lost else ""
        steps = counted(len(self._journal.actions), "labelling step")
        return f"{steps} restored from earlier sessions{damage}"

    def state(self) -> dict[str, Any]:
        """Return all contacts with labels ("marks") and the number of actions ("done")."""
        return {
            "marks": [asdict(mark) for mark in self.marks.ordered()],
            "done": len(self.marks.done),
        }

    def hello(self) -> dict[str, Any]:
        """Return the first message to the page: "recordings" and the contents of :meth:`state`."""
        recordings = [
            {
                "name": r.path.name,
                "rate": r.header.layout.rate,
                "channels": [
                    {"name": c.name, "finger": finger_name(c.finger), "unit": c.unit}
                    for c in r.header.layout.vibration
                ],
            }
            for r in self._recordings
        ]
        return {"recordings": recordings, **self.state()}

    def obey(self, message: str | bytes) -> dict[str, Any]:
        """Carry out a message of the page. Return the reply.

        Raises InputError for an impossible request, which then changes nothing.
        """
        data = message.encode() if isinstance(message, str) else message
        if _QUESTION.search(data):
            return self._ask(read_record(data, _Request, "the page", "load it again", LONGEST))
        action = read_record(data, Action, "the page", "load it again", LONGEST)
        actions = list(self.marks.done)
        number = self.marks.act(action)
        try:
            self._journal.add(action)
        except InputError:
            self.marks.replay(actions)
            raise
        if action.do not in _OF_ONE:
            return {**self.state(), "at": number}
        (mark,) = (m for m in self.marks.ordered() if m.number == action.number)
        return {"mark": asdict(mark), "done": len(self.marks.done)}

    def finish(self) -> list[str]:
        """Write all labelled recordings; after an error, write none. Return a line about each."""
        if not self.marks.done:
            raise ArgumentError("no onset is labelled yet: accept or reject an onset first")
        lines = []
        written: list[Path] = []
        ordered = self.marks.ordered()
        try:
            for number, recording in enumerate(self._recordings):
                path = self._paths[number]
                marks = [m for m in ordered if m.recording == number]
                pinches, left = write_labelled(recording, marks, path, self._by)
                written.append(path)
                remark = f"; {left} onsets were not looked at" if left else ""
                lines.append(f"{path}: {pinches} pinches{remark}")
        except BaseException:
            for path in written:
                path.unlink(missing_ok=True)
            raise
        self.written = written
        return lines

    def close(self) -> None:
        """Close the journal. A second call does nothing."""
        self._journal.close()

    def _ask(self, request: _Request) -> dict[str, Any]:
        if request.ask == "finish":
            return {"finished": self.finish()}
        if request.recording >= len(self._recordings) or request.stretch >= len(
            self._recordings[request.recording].stretches
        ):
            raise ArgumentError("there is no such recording: load the page again")
        recording = self._recordings[request.recording]
        signal = piece(recording, request.stretch, request.sample, request.half)
        about = {"number": request.number, "asked": request.sample, "half": request.half}
        return {"signal": {**signal, **about}}


class LabelServer:
    """Web server for the page of one labelling session. Only this computer can open the page."""

    def __init__(self, session: Session, port: int) -> None:
        from firstcontact.streaming.page.serving import (  # needs the extra `live`
            Guard,
            listen,
            load,
        )

        self._session = session
        self._files = load("firstcontact.collect", "label_page")
        self._socket = listen(HOST, port)
        self._guard = Guard(HOST, self._socket.getsockname()[1], None)
        self._done = asyncio.Event()

    @property
    def url(self) -> str:
        """Address to open in a browser."""
        return self._guard.url(None)

    def run(
        self,
        ready: Callable[[], object] = lambda: None,
        is_stopped: Callable[[], bool] = lambda: False,
    ) -> None:
        """Serve until the new recordings are written or ``is_stopped`` returns True."""
        try:
            asyncio.run(self._run(ready, is_stopped))
        finally:
            self._socket.close()

    async def _run(self, ready: Callable[[], object], is_stopped: Callable[[], bool]) -> None:
        from firstcontact.streaming.page.serving import answer, serve_page

        def reply(connection: ServerConnection, request: Any) -> Any:
            return answer(request, self._guard, self._files)

        async with serve_page(self._view, self._socket, reply, LONGEST):
            ready()
            while not (self._done.is_set() or is_stopped()):
                with suppress(TimeoutError):
                    await asyncio.wait_for(self._done.wait(), POLL)

    async def _view(self, connection: ServerConnection) -> None:
        from websockets.exceptions import ConnectionClosed

        with suppress(ConnectionClosed):
            await connection.send(json.dumps(self._session.hello()))
            async for message in connection:
                try:
                    reply = self._session.obey(message)
                except InputError as error:
                    # The page has already shown the refused change. The state reverts it.
                    reply = {"refused": str(error), **self._session.state()}
                await connection.send(json.dumps(reply))
                if self._session.written:
                    self._done.set()
