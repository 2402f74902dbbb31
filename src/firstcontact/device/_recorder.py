"""Samples to a file, in a thread of its own, so that a slow disk disturbs nobody."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from firstcontact.core import Block, InputError, merge_blocks
from firstcontact.device._source import Arrival
from firstcontact.recording import Header, Marker, PinchMark, RecordingWriter

_log = logging.getLogger(__name__)

#: Blocks that follow each other are written together up to so many samples.
TOGETHER = 500


@dataclass(frozen=True, slots=True)
class RecorderStatus:
    """What a recorder is doing.

    Parameters
    ----------
    path
        File being written, None while nothing is.
    samples
        Written to it, or to the last one.
    waiting
        Samples that wait to be written.
    failed
        Why recording stopped by itself, or "".
    """

    path: Path | None = None
    samples: int = 0
    waiting: int = 0
    failed: str = ""


class Recorder:
    """Writes what it is given, in order; one recording at a time.

    Whoever gives it samples never waits: they queue up, as many as there are, and
    are counted. When the file cannot be written any further (a full disk) it
    stops by itself, says why in its status, and takes no more; what was
    complete in the file stays readable. All methods are safe to call from any
    thread. Leaving a ``with`` stops it.
    """

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._starting = threading.Lock()
        self._queue: deque[Block | Marker | PinchMark] = deque()
        self._thread: threading.Thread | None = None
        self._closing = False
        self._path: Path | None = None
        self._samples = 0
        self._waiting = 0
        self._failed = ""

    @property
    def status(self) -> RecorderStatus:
        """What it is doing now."""
        with self._changed:
            return RecorderStatus(self._path, self._samples, self._waiting, self._failed)

    def start(self, path: Path, header: Header) -> None:
        """Begin a recording.

        Raises
        ------
        InputError
            One is running, or the file exists or cannot be made.
        """
        with self._starting:
            running = self.status.path
            if running is not None:
                raise InputError(f"{running} is being recorded: stop it before the next")
            self.stop()
            writer = RecordingWriter(path, header)
            thread = threading.Thread(
                target=self._work, args=(writer,), name="recorder", daemon=True
            )
            with self._changed:
                self._queue.clear()
                self._closing = False
                self._path, self._samples, self._waiting, self._failed = path, 0, 0, ""
                self._thread = thread
            _log.info("recording into %s", path)
            thread.start()

    def put(self, arrivals: Iterable[Arrival]) -> None:
        """Write these samples and their markers; nothing happens when none is running."""
        with self._changed:
            if self._path is None or self._closing:
                return
            for arrival in arrivals:
                self._queue.append(arrival.block)
                self._queue.extend(arrival.markers)
                self._waiting += len(arrival.block.data)
            self._changed.notify()

    def mark(self, mark: PinchMark) -> None:
        """Write where a pinch lies in what was put so far."""
        with self._changed:
            if self._path is not None and not self._closing:
                self._queue.append(mark)
                self._changed.notify()

    def stop(self) -> None:
        """Write what waits and close the file; nothing happens when none is running."""
        with self._changed:
            thread = self._thread
            self._closing = True
            self._changed.notify()
        if thread is not None:
            thread.join()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.stop()

    def _work(self, writer: RecordingWriter) -> None:
        failed = ""
        try:
            while waiting := self._take():
                for piece in _joined(waiting):
                    self._write(writer, piece)
            writer.close()
        except Exception as error:  # whatever it is, it is no reason to disturb the source
            known = isinstance(error, InputError)
            failed = str(error) if known else f"{writer.path} cannot be written ({error!r})"
            with suppress(InputError, OSError):
                writer.close()
        _log.info("%s ended with %d samples %s", writer.path, self._samples, failed)
        with self._changed:
            self._path, self._failed = None, failed
            self._queue.clear()
            self._waiting = 0

    def _take(self) -> list[Block | Marker | PinchMark]:
        """All that waits; nothing only when the recording is to end."""
        with self._changed:
            self._changed.wait_for(lambda: self._queue or self._closing)
            waiting = list(self._queue)
            self._queue.clear()
            return waiting

    def _write(self, writer: RecordingWriter, piece: Block | Marker | PinchMark) -> None:
        if isinstance(piece, Marker):
            writer.marker(piece)
        elif isinstance(piece, PinchMark):
            writer.mark(piece)
            writer.flush()  # somebody is told of it: a kill does not cost it any more
        else:
            writer.write(piece)
            with self._changed:
                self._samples += len(piece.data)
                self._waiting -= len(piece.data)


def _joined(
    pieces: list[Block | Marker | PinchMark],
) -> Iterator[Block | Marker | PinchMark]:
    """The same, with short blocks that follow each other in one."""
    run: list[Block] = []
    for piece in pieces:
        if isinstance(piece, Block):
            run.append(piece)
        else:
            yield from merge_blocks(run, TOGETHER)
            run = []
            yield piece
    yield from merge_blocks(run, TOGETHER)
