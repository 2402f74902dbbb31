"""Search for intact chunks (groups of records with a checksum) in a damaged MCAP file.

Usual readers stop at the first wrong length. This search accepts a chunk if its lengths are
consistent and its CRC is right. After damage it continues at the next byte.
"""

from __future__ import annotations

import os
import re
import struct
import weakref
import zlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from firstcontact.core import FileError, InputError
from firstcontact.core.files import open_regular
from firstcontact.core.installation import require_modules
from firstcontact.recording._mcap import FRAME, MAGIC, Opcode, read_records

# Record: opcode, length; chunk: start and end time, size, CRC, compression.
_CHUNK_START = re.compile(
    rb"\x06(.{8}).{28}(?:\x00{4}|\x03\x00{3}lz4|\x04\x00{3}zstd)(.{8})", re.DOTALL
)
_LENGTH = struct.Struct("<Q")
_FOOTER_BYTES = FRAME.size + 20
#: Number of intact bytes of the magic that a damaged MCAP file must have.
_MAGIC_LEFT = 6
#: Limit on the unpacked size of all compressed chunks, bytes, and per byte of the file.
_UNPACKED, _UNPACKED_TIMES = 64 << 20, 100
#: Limit on the search: false chunks may add up to this many times the size of the file.
_PATIENCE = 16
#: Largest window of a compressor, bytes.
_WINDOW = 1 << 27
#: Number of bytes that are searched at a time, and length of the longest beginning of a chunk.
_PIECE, _BEGINNING = 1 << 20, 56
#: Number and topic of a channel, or channel and data of a message.
Record = tuple[int, str | bytes]


class FileBytes:
    """Bytes of a file, read from disk only when a slice of them is used."""

    def __init__(self, path: Path) -> None:
        if path.is_dir():
            raise FileError(f"{path} is a folder: name one recording in it (*.mcap)")
        self._path = path
        try:
            with open_regular(path) as stream:
                self._number = os.dup(stream.fileno())
        except OSError as error:
            raise self._failed(error) from error
        weakref.finalize(self, os.close, self._number)
        self._size = os.fstat(self._number).st_size

    def __len__(self) -> int:
        return self._size

    def __getitem__(self, place: slice) -> bytes:
        start, stop, _ = place.indices(self._size)
        parts = []
        try:
            while start < stop and (part := os.pread(self._number, stop - start, start)):
                parts.append(part)  # a system call returns 2 GiB at most
                start += len(part)
        except OSError as error:
            raise self._failed(error) from error
        return b"".join(parts)

    def _failed(self, error: OSError) -> InputError:
        return FileError(f"{self._path} cannot be read ({error.strerror}): check the path")


def read_chunks(
    path: Path, data: FileBytes, damage: list[str]
) -> Iterator[tuple[slice, list[Record]]]:
    """Yield (slice of the file's bytes, records) of each intact chunk.

    Append a sentence about each damaged place to ``damage``. Raise FileError if the file is not an
    MCAP file.
    """
    start = data[: len(MAGIC)]
    intact = sum(a == b for a, b in zip(start, MAGIC, strict=False))
    if not start:
        raise FileError(f"{path} is empty: nothing was recorded in it")
    has_records = False
    for place, records in search(path, data if intact >= _MAGIC_LEFT else b"", damage):
        has_records = has_records or bool(records)
        yield place, records
    if intact < len(MAGIC):
        if not has_records:
            raise FileError(
                f"{path} is not an MCAP file of version 0: give a recording, or convert files of "
                "other programs with `firstcontact import` (`import_recordings` in Python)"
            )
        damage.insert(0, f"the first {len(MAGIC)} bytes are damaged")


def search(
    path: Path, data: FileBytes | bytes, damage: list[str], end: int = len(MAGIC)
) -> Iterator[tuple[slice, list[Record]]]:
    """Yield (slice of the file's bytes, records) of each intact chunk from byte ``end`` on.

    Append a sentence about each damaged place in ``data`` to ``damage``.
    """
    chunks = 0
    left = _UNPACKED + _UNPACKED_TIMES * len(data)  # bytes for all compressed chunks together
    patience = _PATIENCE * len(data)
    for start, stop in find_chunks(data, end):
        if start < end:
            continue
        try:
            content, crc, unpacked = _unpack_chunk(data[start + FRAME.size : stop], left)
            left -= unpacked  # also if the chunk is damaged: each attempt takes time
            if zlib.crc32(content) != crc:
                raise ValueError("the checksum is wrong")
            inside = list(read_records(content))
        except InputError:  # a library for compressed chunks is missing
            raise
        except (ValueError, RuntimeError, OverflowError, struct.error) as error:
            patience -= stop - start
            if patience < 0:
                raise FileError(
                    f"{path} contains many false beginnings of chunks, so reading it would take "
                    "too long: choose another recording"
                ) from error
            continue
        if not _is_framed(data, end, start):
            damage.append(_describe(end, start))
        yield slice(start, stop), inside
        chunks += 1
        end = stop
    if not chunks:  # other programs also write messages outside of chunks
        records: list[Record] = []
        with suppress(ValueError, struct.error):
            for record in read_records(data[end:]):
                records.append(record)
        yield slice(end, len(data)), records
    damage += _tail_damage(data, end, chunks)


def _unpack_chunk(body: bytes, most: int) -> tuple[bytes, int, int]:
    """Return a chunk's records as bytes, the stated CRC, and the number of decompressed bytes.

    The number is 0 for a chunk without compression. Raises ValueError if the chunk would unpack to
    more than ``most`` bytes.
    """
    size, crc, letters = struct.unpack_from("<16xQII", body)
    kind, data = body[32 : 32 + letters], body[40 + letters :]
    if not kind:
        return data, crc, 0
    if size > most:
        raise ValueError("it would unpack to far more than the file could hold")
    require_modules("files", "lz4", "zstandard")
    data = _decompress(kind, data, size)
    return data, crc, len(data)


def _decompress(kind: bytes, packed: bytes, size: int) -> bytes:
    """Decompress bytes by zstd if ``kind`` is b"zstd", otherwise by LZ4.

    Raises ValueError unless the result has ``size`` bytes. No more than ``size + 1`` bytes are
    decompressed, so that a false size cannot fill the memory.
    """
    data: bytes
    if kind == b"zstd":
        from zstandard import ZstdDecompressor, ZstdError

        try:
            with ZstdDecompressor(max_window_size=_WINDOW).stream_reader(packed) as reader:
                data = reader.read(size + 1)
        except ZstdError as error:
            raise ValueError(str(error)) from error
    else:
        from lz4.frame import LZ4FrameDecompressor

        data = LZ4FrameDecompressor().decompress(packed, max_length=size + 1)
    if len(data) != size:
        raise ValueError("a chunk decompresses to another size than its header states")
    return data


def find_chunks(data: FileBytes | bytes, start: int = len(MAGIC)) -> Iterator[tuple[int, int]]:
    """Yield (start, end) of each part of the bytes that looks like a chunk.

    Such parts may lie inside other ones. ``start`` is the first byte to search.
    """
    for base in range(start, len(data), _PIECE):
        piece = data[base : base + _PIECE + _BEGINNING]
        position = 0
        while (match := _CHUNK_START.search(piece, position)) and match.start() < _PIECE:
            length, size = (_LENGTH.unpack(match[i])[0] for i in (1, 2))
            stop = base + match.start() + FRAME.size + length
            if base + match.end() + size == stop <= len(data):
                yield base + match.start(), stop
            position = match.start() + 1


def _is_framed(data: FileBytes | bytes, position: int, stop: int) -> bool:
    """Return True if the bytes ``position`` to ``stop`` are whole records, none of them a chunk."""
    while position < stop:
        if stop - position < FRAME.size:
            return False
        opcode, length = FRAME.unpack(data[position : position + FRAME.size])
        if opcode == Opcode.CHUNK or not 0 < opcode <= Opcode.DATA_END:
            return False
        position += FRAME.size + length
    return position == stop


def _tail_damage(data: FileBytes | bytes, end: int, read: int) -> list[str]:
    """Return sentences about damaged bytes after the last intact chunk.

    ``end`` is the position after that chunk, and ``read`` the number of intact chunks in the file.
    """
    footer = len(data) - len(MAGIC) - _FOOTER_BYTES
    is_footer = footer >= end and data[footer : footer + 1] == bytes([Opcode.FOOTER])
    if data[-len(MAGIC) :] != MAGIC or not is_footer:
        return [
            "the file was not closed (no footer): its writer was killed or the file was cut; all "
            f"that is complete was read, the last {len(data) - end} bytes are not a complete chunk"
        ]
    damaged = [] if _is_framed(data, end, footer) else [_describe(end, footer)]
    counted = _chunk_count(data, footer)
    if counted is None:
        return [*damaged, "the index at the end is damaged: some chunks may not have been read"]
    if counted > read:
        return [*damaged, f"{counted - read} of {counted} chunks are damaged and were skipped"]
    return damaged


def _chunk_count(data: FileBytes | bytes, footer: int) -> int | None:
    """Return the number of chunks that the file's summary states; None if the summary is damaged.

    ``footer`` is the position of the footer record, which says where the summary is.
    """
    position, _, crc = struct.unpack("<QQI", data[footer + FRAME.size : -len(MAGIC)])
    if not 0 < position <= footer:
        return None
    end, sum_so_far = footer + FRAME.size + 16, 0
    for start in range(position, end, _PIECE):
        sum_so_far = zlib.crc32(data[start : min(start + _PIECE, end)], sum_so_far)
    if sum_so_far != crc:
        return None
    while position < footer:
        opcode, length = FRAME.unpack(data[position : position + FRAME.size])
        position += FRAME.size
        if opcode == Opcode.STATISTICS:
            body = data[position : position + length]
            return struct.unpack_from("<22xI", body)[0] if length >= 26 else None
        position += length
    return None


def _describe(start: int, stop: int) -> str:
    return f"{stop - start} bytes from byte {start} on are damaged and were skipped"
