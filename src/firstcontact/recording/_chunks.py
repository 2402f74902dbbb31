"""Search for the chunks of a damaged MCAP file, which trusts only their checksums.

Usual readers stop at the first wrong length. This search accepts a chunk if its lengths are
consistent and its CRC is right. After damage it continues at the next byte.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from firstcontact.core import InputError
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
#: Number and topic of a channel, or channel and data of a message.
Record = tuple[int, str | bytes]


def read_chunks(path: Path) -> tuple[list[Record], list[str]]:
    """Return the records of all intact chunks in file order, and descriptions of the damage."""
    if path.is_dir():
        raise InputError(f"{path} is a folder: name one recording in it (*.mcap)")
    try:
        with open_regular(path) as stream:
            start = stream.read(len(MAGIC))
            intact = sum(a == b for a, b in zip(start, MAGIC, strict=False))
            stream.seek(0)
            data = stream.read() if intact >= _MAGIC_LEFT else b""
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror}): check the path") from error
    if not start:
        raise InputError(f"{path} is empty: nothing was recorded in it")
    records, damage = _search(path, data)
    if intact < len(MAGIC):
        if not records:
            raise InputError(
                f"{path} is not an MCAP file of version 0: give a recording, or convert files of "
                "other programs with `firstcontact import` (`import_recordings` in Python)"
            )
        damage.insert(0, f"the first {len(MAGIC)} bytes are damaged")
    return records, damage


def _search(path: Path, data: bytes) -> tuple[list[Record], list[str]]:
    records: list[Record] = []
    damage: list[str] = []
    chunks = 0
    end = len(MAGIC)  # end of the bytes processed
    left = _UNPACKED + _UNPACKED_TIMES * len(data)  # bytes for all compressed chunks together
    patience = _PATIENCE * len(data)
    for start, stop in find_chunks(data):
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
                raise InputError(
                    f"{path} contains many false beginnings of chunks, so reading it would take "
                    "too long: choose another recording"
                ) from error
            continue
        if not _is_framed(data, end, start):
            damage.append(_describe(end, start))
        records += inside
        chunks += 1
        end = stop
    if not chunks:  # other programs also write messages outside of chunks
        with suppress(ValueError, struct.error):
            for record in read_records(data[end:]):
                records.append(record)
    damage += _tail(data, end, chunks)
    return records, damage


def _unpack_chunk(body: bytes, most: int) -> tuple[bytes, int, int]:
    """Return a chunk's records and stated CRC, and the number of bytes that were decompressed."""
    size, crc, letters = struct.unpack_from("<16xQII", body)
    kind, data = body[32 : 32 + letters], body[40 + letters :]
    if not kind:
        return data, crc, 0
    if size > most:
        raise ValueError("it would unpack to far more than the file could hold")
    require_modules("files", "lz4", "zstandard")
    data = _decompressed(kind, data, size)
    return data, crc, len(data)


def _decompressed(kind: bytes, packed: bytes, size: int) -> bytes:
    """Decompress up to one byte beyond the stated size."""
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
        raise ValueError("the compressed data have another size")
    return data


def find_chunks(data: bytes) -> Iterator[tuple[int, int]]:
    """Yield start and end of all bytes that look like a chunk, also inside damaged chunks."""
    position = len(MAGIC)
    while match := _CHUNK_START.search(data, position):
        length, size = (_LENGTH.unpack(match[i])[0] for i in (1, 2))
        stop = match.start() + FRAME.size + length
        if match.end() + size == stop <= len(data):
            yield match.start(), stop
        position = match.start() + 1


def _is_framed(data: bytes, position: int, stop: int) -> bool:
    """Return True if ``position`` to ``stop`` holds complete records, and no chunk among them."""
    while position < stop:
        if stop - position < FRAME.size:
            return False
        opcode, length = FRAME.unpack_from(data, position)
        if opcode == Opcode.CHUNK or not 0 < opcode <= Opcode.DATA_END:
            return False
        position += FRAME.size + length
    return position == stop


def _tail(data: bytes, end: int, read: int) -> list[str]:
    """Return notes on damage after the last intact chunk, and on chunks known only by the index."""
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


def _chunk_count(data: bytes, footer: int) -> int | None:
    """Return the number of chunks stated by the summary; None if the summary is damaged."""
    position, _, crc = struct.unpack("<QQI", data[footer + FRAME.size : -len(MAGIC)])
    if not 0 < position <= footer or zlib.crc32(data[position : footer + FRAME.size + 16]) != crc:
        return None
    while position < footer:
        opcode, length = FRAME.unpack_from(data, position)
        position += FRAME.size
        if opcode == Opcode.STATISTICS:
            body = data[position : position + length]
            return struct.unpack_from("<22xI", body)[0] if length >= 26 else None
        position += length
    return None


def _describe(start: int, stop: int) -> str:
    return f"{stop - start} bytes from byte {start} on are damaged and were skipped"
