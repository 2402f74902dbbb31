"""Scanner for the chunks of a damaged MCAP file, which trusts only their checksums.

The readers of the library mcap stop at the first wrong length. This scanner accepts a chunk if its
lengths are consistent and its CRC is right. After damage the search continues at the next byte.

"""

from __future__ import annotations

import mmap
import re
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import McapRecord, Statistics

from firstcontact.core import InputError, open_regular
from firstcontact.recording._unpack import Unpacker

MAGIC = b"\x89MCAP0\r\n"
# Record: opcode, length; chunk: start and end time, size, CRC, compression.
_CHUNK_START = re.compile(
    rb"\x06(.{8}).{28}(?:\x00{4}|\x03\x00{3}lz4|\x04\x00{3}zstd)(.{8})", re.DOTALL
)
_FRAME = struct.Struct("<BQ")
_LENGTH = struct.Struct("<Q")
_FOOTER_BYTES = _FRAME.size + 20
#: Number of intact bytes of the magic that a damaged MCAP file must have.
_MAGIC_LEFT = 6
#: Limit on the search: false chunks may add up to this many times the size of the file.
_PATIENCE = 16


@dataclass(frozen=True, slots=True)
class Scan:
    """Records of all intact chunks in file order, and descriptions of the damage."""

    records: tuple[McapRecord, ...]
    skipped: tuple[str, ...]


def scan(path: Path) -> Scan:
    """Read all intact chunks of an MCAP file.

    Raises
    ------
    InputError
        The file cannot be opened, is empty, or is not MCAP of a known version.
    """
    if path.is_dir():
        raise InputError(f"{path} is a folder: name one recording in it (*.mcap)")
    try:
        with open_regular(path) as stream:
            start = stream.read(len(MAGIC))
            if not start:
                raise InputError(f"{path} is empty: nothing was recorded in it")
            if sum(a == b for a, b in zip(start, MAGIC, strict=False)) < _MAGIC_LEFT:
                raise _not_ours(path, start)
            with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as view:
                chunks = _scan(path, view)
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror}): check the path") from error
    if start == MAGIC:
        return chunks
    if not chunks.records:
        raise _not_ours(path, start)
    return Scan(chunks.records, (f"the first {len(MAGIC)} bytes are damaged", *chunks.skipped))


def _not_ours(path: Path, start: bytes) -> InputError:
    if start[:5] == MAGIC[:5] and start[6:] == MAGIC[6:]:
        return InputError(
            f"{path} is MCAP of version {chr(start[5])!r}, but this reader knows '0': convert the "
            "file with the program `mcap`"
        )
    return InputError(
        f"{path} is not an MCAP file: give a recording, or bring other data in with "
        "`firstcontact import`"
    )


def _scan(path: Path, view: mmap.mmap) -> Scan:
    records: list[McapRecord] = []
    chunks = 0
    skipped: list[str] = []
    end = len(MAGIC)  # end of the bytes processed
    unpacker = Unpacker(len(view))
    patience = _PATIENCE * len(view)
    for start, stop in _candidates(view):
        if start < end:
            continue
        inside = unpacker.records(view[start + _FRAME.size : stop])
        if inside is None:
            patience -= stop - start
            if patience < 0:
                raise InputError(
                    f"{path} contains many false beginnings of chunks, so reading it would take "
                    "too long: choose another recording"
                )
            continue
        if not _framed(view, end, start):
            skipped.append(_bytes(end, start))
        records += inside
        chunks += 1
        end = stop
    skipped += _tail(view, end, chunks)
    if unpacker.refused:
        skipped.append(
            f"{unpacker.refused} chunks would unpack to far more than the file could hold and were "
            "skipped"
        )
    return Scan(tuple(records), tuple(skipped))


def _candidates(view: mmap.mmap) -> Iterator[tuple[int, int]]:
    """Yield start and end of all bytes that look like a chunk, also inside damaged chunks."""
    position = len(MAGIC)
    # mypy does not know that a bytes pattern searches any buffer.
    while match := _CHUNK_START.search(view, position):
        length, data = (_LENGTH.unpack(match[i])[0] for i in (1, 2))
        stop = match.start() + _FRAME.size + length
        if match.end() + data == stop <= len(view):
            yield match.start(), stop
        position = match.start() + 1


def _framed(view: mmap.mmap, position: int, stop: int) -> bool:
    """Return True if ``position`` to ``stop`` holds complete records, and no chunk among them."""
    while position < stop:
        if stop - position < _FRAME.size:
            return False
        opcode, length = _FRAME.unpack_from(view, position)
        if opcode == Opcode.CHUNK or not 0 < opcode <= Opcode.DATA_END:
            return False
        position += _FRAME.size + length
    return position == stop


def _tail(view: mmap.mmap, end: int, read: int) -> list[str]:
    """Return notes on damage after the last intact chunk, and on chunks known only by the index."""
    footer = len(view) - len(MAGIC) - _FOOTER_BYTES
    if view[-len(MAGIC) :] != MAGIC or footer < end or view[footer] != Opcode.FOOTER:
        return [
            "the file was not closed (no footer): its writer was killed or the file was cut; all "
            f"that is complete was read, the last {len(view) - end} bytes are not a complete chunk"
        ]
    damaged = [] if _framed(view, end, footer) else [_bytes(end, footer)]
    counted = _chunk_count(view, footer)
    if counted is None:
        return [*damaged, "the index at the end is damaged: some chunks may not have been read"]
    if counted > read:
        return [*damaged, f"{counted - read} of {counted} chunks are damaged and were skipped"]
    return damaged


def _chunk_count(view: mmap.mmap, footer: int) -> int | None:
    """Return the number of chunks stated by the summary; None if the summary is damaged."""
    position, _, crc = struct.unpack_from("<QQI", view, footer + _FRAME.size)
    if not 0 < position <= footer or zlib.crc32(view[position : footer + _FRAME.size + 16]) != crc:
        return None
    while position < footer:
        opcode, length = _FRAME.unpack_from(view, position)
        position += _FRAME.size
        if opcode == Opcode.STATISTICS:
            body = BytesIO(view[position : position + length])
            try:
                return int(Statistics.read(ReadDataStream(body)).chunk_count)
            except (McapError, struct.error):
                return None
        position += length
    return None


def _bytes(start: int, stop: int) -> str:
    return f"{stop - start} bytes from byte {start} on are damaged and were skipped"
