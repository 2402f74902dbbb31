"""Writer of recordings. If the process is killed, at most the last tenth of a second is lost."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any, Self

import numpy as np

from firstcontact.core import Block, FileError, InputError, Pinch
from firstcontact.core.files import AnyPath
from firstcontact.recording._mcap import McapWriter
from firstcontact.recording.messages import (
    LAST_SAMPLE,
    LONGEST_TEXT,
    Header,
    Marker,
    PinchMark,
    block_message,
    block_schema,
    read_header,
    read_mark,
    read_marker,
)

#: Duration of the samples in a full chunk, s. Only a further message pushes a full chunk to the
#: operating system. So a killed writer loses up to twice this time, the promised tenth of a second.
HANDED_OVER_EVERY = 0.05
#: Longest message, s. Damage to one chunk loses about this much.
LONGEST_MESSAGE = 0.1
#: Interval between repeated headers, s. A killed writer leaves two of them.
HEADER_AGAIN = 0.5
_NANO = 1_000_000_000
_LATEST = (1 << 64) - 1  # latest time in MCAP, ns
_JSON_SCHEMA = b'{"type": "object"}'


class RecordingWriter:
    """Writer of one recording file (.mcap), block by block. Use it in a ``with`` statement.

    The same samples give the same bytes: times come from sample numbers and rate, not from a clock.

    Parameters
    ----------
    path
        Path of a new file in an existing folder.
    header
        Layout, source and type of the samples. All blocks must have this layout and ``dtype``.

    Raises
    ------
    InputError
        The file exists or cannot be created, or the header is invalid. All methods also raise this
        error if the disk is full or a block does not fit the header.
    """

    def __init__(self, path: AnyPath, header: Header) -> None:
        self.path = path = Path(path)
        self.header = header
        self._head = self._checked_json(header.to_json(), read_header, "the header")
        try:
            self._stream = path.open("xb")
        except FileExistsError as error:
            raise FileError(
                f"{path} exists, and recordings are never overwritten: choose another name"
            ) from error
        except OSError as error:
            raise FileError(
                f"{path} cannot be created ({error.strerror}): check its folder"
            ) from error
        self._open = True
        self._epoch = 0
        self._end: int | None = None
        self._layouts = {"": header.layout, **{g.name: g.layout for g in header.layout.groups}}
        self._origin = 0  # added to sample numbers, so that time never goes back at a new epoch
        self._latest = 0  # highest sample number so far, including the origin
        self._number = 0
        self._sequence = 0
        self._until_header = round(header.layout.rate * HEADER_AGAIN)
        bytes_a_second = header.layout.rate * header.layout.width * np.dtype(header.dtype).itemsize
        self._chunk_size = int(bytes_a_second * HANDED_OVER_EVERY)
        try:
            self._file = McapWriter(self._stream, self._chunk_size)
            self._start()
        except (OSError, InputError) as error:
            failed = self._close_after_error(error) if isinstance(error, OSError) else error
            # A file without a header is unreadable, so it is removed.
            path.unlink(missing_ok=True)
            raise failed from error

    def write(self, block: Block, group: str = "") -> None:
        """Append a block of samples.

        ``group`` is the name of a group of channels with a lower rate, "" for the main channels.
        """
        layout = self._layouts.get(group)
        if layout is None:
            raise FileError(f"{self.path}: the layout has no group {group!r}: add it to the header")
        pace = self.header.layout.rate / layout.rate
        columns = layout.width
        if block.data.ndim != 2 or block.data.shape[1] != columns:
            raise FileError(
                f"{self.path}: a block has the shape {block.data.shape}: give samples with the "
                f"{columns} columns of the header's layout"
            )
        if block.data.dtype != np.dtype(self.header.dtype):
            raise FileError(
                f"{self.path}: a block is {block.data.dtype}, but the header's dtype is "
                f"{self.header.dtype}: convert the block, or correct the header"
            )
        if not 0 <= block.first_sample <= block.end <= LAST_SAMPLE:
            raise FileError(
                f"{self.path}: the sample number {block.end} is too large: start the device again"
            )
        if block.epoch != self._epoch:
            self._origin = max(self._origin, self._latest - round(block.first_sample * pace))
            self._epoch = block.epoch
        longest = max(1, int(layout.rate * LONGEST_MESSAGE))
        for start in range(0, len(block.data), longest):
            first = block.first_sample + start
            piece = Block(block.data[start : start + longest], first, block.epoch)
            data = block_message(piece, self.header.dtype)
            self._add(self._samples[group], data, round(first * pace))
            if group:
                continue
            self._until_header -= len(piece.data)
            if self._until_header <= 0 < self._until_header + len(piece.data):
                self._add(self._headers, self._head, first)
        if not group:
            self._end = block.end
        self._latest = max(self._latest, self._origin + round(block.end * pace))

    def mark(self, mark: PinchMark) -> None:
        """Append the mark of a pinch: its position, label and contacts."""
        data = self._checked_json(mark.to_json(), read_mark, f"the mark of pinch {mark.number}")
        self._add(self._pinches, data, mark.end)
        self._number = mark.number + 1

    def marker(self, marker: Marker) -> None:
        """Append a marker, a text at a sample. Characters that UTF-8 cannot encode become "?"."""
        text = marker.text.encode("utf-8", "replace").decode()
        if len(text) > LONGEST_TEXT:
            text = text[: LONGEST_TEXT - 1] + "…"
        tree = {**asdict(marker), "text": text}
        self._add(self._markers, self._checked_json(tree, read_marker, "a marker"), marker.sample)

    def pinch(self, pinch: Pinch) -> None:
        """Append the samples of a pinch, its label and its contacts.

        If its sample numbers do not follow those of the last samples, the pinch begins a new epoch.
        Readers then report no loss between the two, because nothing was recorded there.
        """
        new = self._end is not None and pinch.first_sample != self._end
        epoch = self._epoch + new
        block = Block(pinch.data, pinch.first_sample, epoch)
        self.write(block)
        for name, blocks in pinch.groups.items():
            self.write(Block(blocks.data, blocks.first_sample, epoch), name)
        self.mark(
            PinchMark(
                self._number,
                block.first_sample,
                block.end,
                epoch,
                pinch.label,
                pinch.truth,
                pinch.motor_start,
                closing_speed=pinch.closing_speed,
            )
        )

    def flush(self) -> None:
        """Write all buffered data to the file, so that they survive if the process is killed."""
        if not self._open:
            return
        try:
            self._file.flush()
        except OSError as error:
            raise self._close_after_error(error) from error

    def close(self) -> None:
        """Write buffered data, index and footer, and close the file. A second call does nothing."""
        if not self._open:
            return
        try:
            # A second header, so that one damaged chunk never loses it.
            self._add(self._headers, self._head, self._end or 0)
            self._file.finish()
            self._stream.flush()
        except OSError as error:
            raise self._close_after_error(error) from error
        self._open = False
        self._stream.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _start(self) -> None:
        file = self._file

        def json_channel(topic: str, name: str) -> int:
            schema = file.add_schema(name, "jsonschema", _JSON_SCHEMA)
            return file.add_channel(topic, "json", schema)

        self._headers = json_channel("/header", "firstcontact.Header")
        samples = file.add_schema(
            "firstcontact_msgs/msg/Samples", "ros2msg", block_schema(self.header.dtype)
        )
        self._samples = {"": file.add_channel("/samples", "cdr", samples)}
        self._pinches = json_channel("/pinch", "firstcontact.PinchMark")
        self._markers = json_channel("/marker", "firstcontact.Marker")
        for group in self.header.layout.groups:
            topic = f"/samples/{group.name}"
            self._samples[group.name] = file.add_channel(topic, "cdr", samples)
        # Spaces fill a whole chunk, so that the header does not wait for samples.
        self._add(self._headers, self._head.ljust(self._chunk_size), 0)

    def _checked_json(
        self, tree: dict[str, Any], read: Callable[[bytes, str], object], of: str
    ) -> bytes:
        """Return ``tree`` as JSON bytes, after a check that a reader accepts them.

        ``read`` is the reader's function, which raises an error for unusable bytes. ``of`` is the
        name of the message in errors.
        """
        try:
            text = json.dumps(tree, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
            data = text.encode()
        except ValueError as error:  # NaN, or characters that UTF-8 cannot encode
            raise FileError(
                f"{self.path}: {of} cannot be written as JSON in UTF-8 ({error}): correct it"
            ) from error
        read(data, f"{self.path}: {of}")
        return data

    def _add(self, channel: int, data: bytes, sample: int) -> None:
        if not self._open:
            raise FileError(f"{self.path} is closed: begin a new recording")
        time = round((self._origin + sample) * _NANO / self.header.layout.rate)
        time = min(max(0, time), _LATEST)
        try:
            self._file.add_message(channel, time, data, self._sequence)
            self._stream.flush()
        except OSError as error:
            raise self._close_after_error(error) from error
        self._sequence += 1

    def _close_after_error(self, error: OSError) -> InputError:
        """Close the file after an ``error`` of the disk. Return the FileError to raise."""
        self._open = False
        with suppress(OSError):
            self._stream.close()
        return FileError(
            f"{self.path} cannot be written any further ({error.strerror}): all samples until "
            "0.1 s before this error stay readable; make room on the disk and begin a new recording"
        )
