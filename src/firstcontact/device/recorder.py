"""Recorder that writes samples to a file in its own thread, so that slow disks delay nothing.

If the disk is full, the recording ends, and the session goes on.
"""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from firstcontact.core import ArgumentError, Block, InputError, merge_blocks
from firstcontact.device.source import Arrival
from firstcontact.recording import Header, Marker, PinchMark, RecordingWriter

_log = logging.getLogger("firstcontact.device")

#: Largest number of samples for which consecutive blocks are joined before writing.
JOINED_SAMPLES = 500
#: Number of queued samples above which :meth:`Recorder.wait` waits: 8 s of a fingertip.
QUEUED = 40_000
#: Time between two checks of whether to wait any longer, s.
POLL = 0.05
_Piece = Block | Marker | PinchMark | tuple[str, Block]


@dataclass(frozen=True, slots=True)
class RecorderStatus:
    #: File that is being written; None if no recording runs.
    path: Path | None = None
    #: Number of samples written to this or the last file, and in the queue.
    samples: int = 0
    waiting: int = 0
    #: Reason why recording stopped by itself, or "".
    failed: str = ""


class Recorder:
    """Recorder of samples into one file at a time. Any thread can call its methods.

    Samples wait for the disk in a queue without a limit. If the file cannot be written, recording
    stops, :attr:`status` gives the reason, and what was written stays readable.
    """

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._starting = threading.Lock()
        self._queue: deque[_Piece] = deque()
        self._thread: threading.Thread | None = None
        self._closing = False
        self._is_over = False
        self._path: Path | None = None
        self._samples = 0
        self._waiting = 0
        self._failed = ""

    @property
    def status(self) -> RecorderStatus:
        with self._changed:
            return RecorderStatus(self._path, self._samples, self._waiting, self._failed)

    def start(self, path: Path, header: Header) -> None:
        """Start a recording into the new file ``path``.

        Raises ArgumentError if a recording is running or the recorder is closed.
        """
        with self._starting:
            if self._is_over:
                raise ArgumentError(
                    f"{path} cannot be recorded after the end of the session: start a new session"
                )
            running = self.status.path
            if running is not None:
                raise ArgumentError(
                    f"samples are already being recorded into {running}: stop that recording first"
                )
            self.stop()
            writer = RecordingWriter(path, header)
            self._thread = threading.Thread(
                target=self._work, args=(writer,), name="recorder", daemon=True
            )
            with self._changed:
                self._closing = False
                self._path, self._samples, self._failed = path, 0, ""
            _log.info("recording into %s", path)
            self._thread.start()

    def put(self, arrivals: Iterable[Arrival]) -> None:
        """Queue samples and their markers for writing. Without a recording, do nothing."""
        with self._changed:
            if self._path is None or self._closing:
                return
            for arrival in arrivals:
                self._queue.append(arrival.block)
                self._queue.extend(arrival.markers)
                self._waiting += len(arrival.block.data)
            self._changed.notify_all()

    def wait(self, stopped: Callable[[], bool]) -> None:
        """Wait until few samples are in the queue, or until ``stopped`` returns True."""
        with self._changed:
            while self._waiting > QUEUED and not stopped():
                self._changed.wait(POLL)

    def mark(self, mark: PinchMark) -> None:
        self._add(mark)

    def put_group(self, name: str, block: Block) -> None:
        """Queue samples of the group of channels ``name``, such as positions of the hand."""
        self._add((name, block))

    def _add(self, piece: _Piece) -> None:
        with self._changed:
            if self._path is not None and not self._closing:
                self._queue.append(piece)
                self._changed.notify_all()

    def stop(self) -> None:
        """Write all queued samples and close the file. Without a recording, do nothing."""
        with self._changed:
            self._closing = True
            self._changed.notify_all()
        if self._thread is not None:
            self._thread.join()

    def close(self) -> None:
        with self._starting:
            self._is_over = True
            self.stop()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _work(self, writer: RecordingWriter) -> None:
        failed = ""
        try:
            while waiting := self._wait_for_items():
                for piece in _merge_short_blocks(waiting):
                    self._write(writer, piece)
            writer.close()
        except Exception as error:  # no error here may disturb the source
            known = isinstance(error, InputError)
            failed = str(error) if known else f"{writer.path} cannot be written ({error!r})"
            with suppress(InputError, OSError):
                writer.close()
        _log.info("%s ended with %d samples %s", writer.path, self._samples, failed)
        with self._changed:
            self._path, self._failed = None, failed
            self._queue.clear()
            self._waiting = 0

    def _wait_for_items(self) -> list[_Piece]:
        """Wait until items are queued. Return all of them; [] at the end of a recording."""
        with self._changed:
            self._changed.wait_for(lambda: self._queue or self._closing)
            waiting = list(self._queue)
            self._queue.clear()
            return waiting

    def _write(self, writer: RecordingWriter, piece: _Piece) -> None:
        if isinstance(piece, Marker):
            writer.marker(piece)
        elif isinstance(piece, PinchMark):
            writer.mark(piece)
            writer.flush()  # the caller reports the pinch, so it must survive a kill
        elif isinstance(piece, tuple):
            name, block = piece
            writer.write(block, name)
        else:
            writer.write(piece)
            with self._changed:
                self._samples += len(piece.data)
                self._waiting -= len(piece.data)


def _merge_short_blocks(pieces: list[_Piece]) -> Iterator[_Piece]:
    """Yield the items of a queue in order. Blocks that follow each other are merged."""
    run: list[Block] = []
    for piece in pieces:
        if isinstance(piece, Block):
            run.append(piece)
        else:
            yield from merge_blocks(run, JOINED_SAMPLES)
            run = []
            yield piece
    yield from merge_blocks(run, JOINED_SAMPLES)
