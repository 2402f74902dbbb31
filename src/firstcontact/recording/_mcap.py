"""Writer of MCAP files (https://mcap.dev) for recordings, and a reader of their records.

The files equal those that the library ``mcap`` writes. That library would install 30 MB of
compressors.
"""

from __future__ import annotations

import struct
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from enum import IntEnum
from typing import IO

MAGIC = b"\x89MCAP0\r\n"
#: Opcode and length of a record.
FRAME = struct.Struct("<BQ")
#: Channel, number, time and time of publication before the content of a message.
_MESSAGE = struct.Struct("<HIQQ")


class Opcode(IntEnum):
    HEADER = 1
    FOOTER = 2
    SCHEMA = 3
    CHANNEL = 4
    MESSAGE = 5
    CHUNK = 6
    MESSAGE_INDEX = 7
    CHUNK_INDEX = 8
    ATTACHMENT_INDEX = 10
    STATISTICS = 11
    METADATA_INDEX = 13
    SUMMARY_OFFSET = 14
    DATA_END = 15


def read_records(data: bytes) -> Iterator[tuple[int, str | bytes]]:
    """Yield (channel's number, topic) for each channel, (channel's number, data) for each message.

    A topic is a str, data are bytes. Raises ValueError or struct.error for an incomplete record.
    """
    position = 0
    while position < len(data):
        opcode, length = FRAME.unpack_from(data, position)
        position += FRAME.size
        if length > len(data) - position:
            raise ValueError("a record is cut")
        content = data[position : position + length]
        position += length
        if opcode == Opcode.CHANNEL:
            number, letters = struct.unpack_from("<HxxI", content)
            yield number, content[8 : 8 + letters].decode()
        elif opcode == Opcode.MESSAGE:
            yield _MESSAGE.unpack_from(content)[0], content[_MESSAGE.size :]


def _record(opcode: Opcode, *parts: bytes) -> bytes:
    return FRAME.pack(opcode, sum(map(len, parts))) + b"".join(parts)


def _text(text: str) -> bytes:
    data = text.encode()
    return struct.pack("<I", len(data)) + data


def _encode_mapping(numbers: Mapping[int, int]) -> bytes:
    pairs = b"".join(struct.pack("<HQ", *pair) for pair in numbers.items())
    return struct.pack("<I", len(pairs)) + pairs


class McapWriter:
    """Writer of messages to an MCAP file, in uncompressed chunks.

    A chunk is written to ``stream`` by :meth:`flush`, or if it has more than ``chunk_size`` bytes.
    """

    def __init__(self, stream: IO[bytes], chunk_size: int) -> None:
        self._stream, self._chunk_size = stream, chunk_size
        self._schemas: list[bytes] = []
        self._channels: list[bytes] = []
        self._counts: Counter[int] = Counter()
        self._span: tuple[int, int] | None = None
        self._chunks: list[bytes] = []  # their records for the index
        self._position = 0
        self._begin_chunk()
        self._write(MAGIC + _record(Opcode.HEADER, _text("ros2"), _text("firstcontact")))

    def _begin_chunk(self) -> None:
        self._chunk = bytearray()
        self._times: dict[int, list[tuple[int, int]]] = {}

    def _write(self, data: bytes) -> None:
        self._stream.write(data)
        self._position += len(data)

    def add_schema(self, name: str, encoding: str, text: bytes) -> int:
        number = len(self._schemas) + 1
        head = struct.pack("<H", number) + _text(name) + _text(encoding)
        self._schemas.append(_record(Opcode.SCHEMA, head, struct.pack("<I", len(text)), text))
        self._append(self._schemas[-1])
        return number

    def add_channel(self, topic: str, encoding: str, schema: int) -> int:
        number = len(self._channels) + 1
        head = struct.pack("<HH", number, schema)
        self._channels.append(
            _record(Opcode.CHANNEL, head, _text(topic), _text(encoding), bytes(4))
        )
        self._append(self._channels[-1])
        return number

    def add_message(self, channel: int, time: int, data: bytes, number: int) -> None:
        first, last = self._span or (time, time)
        self._span = min(first, time), max(last, time)
        self._counts[channel] += 1
        self._times.setdefault(channel, []).append((time, len(self._chunk)))
        self._append(_record(Opcode.MESSAGE, _MESSAGE.pack(channel, number, time, time), data))

    def _append(self, record: bytes) -> None:
        self._chunk += record
        if len(self._chunk) > self._chunk_size:
            self._end_chunk()

    def _end_chunk(self) -> None:
        if not self._times:
            return
        data = bytes(self._chunk)
        times = [time for entries in self._times.values() for time, _ in entries]
        span = struct.pack("<QQ", min(times), max(times))
        size, start = struct.pack("<Q", len(data)), self._position
        crc = struct.pack("<I", zlib.crc32(data))
        self._write(_record(Opcode.CHUNK, span, size, crc, _text(""), size, data))
        end, places = self._position, {}
        for channel, entries in self._times.items():
            places[channel] = self._position
            index = b"".join(struct.pack("<QQ", *entry) for entry in entries)
            head = struct.pack("<HI", channel, len(index))
            self._write(_record(Opcode.MESSAGE_INDEX, head, index))
        lengths = struct.pack("<QQ", start, end - start)
        indexed = _encode_mapping(places) + struct.pack("<Q", self._position - end)
        self._chunks.append(
            _record(Opcode.CHUNK_INDEX, span, lengths, indexed, _text(""), size, size)
        )
        self._begin_chunk()

    def flush(self) -> None:
        """End the current chunk, and pass all data to the operating system."""
        self._end_chunk()
        self._stream.flush()

    def finish(self) -> None:
        """Write the last chunk, the summary and the footer."""
        self._end_chunk()
        self._write(_record(Opcode.DATA_END, bytes(4)))
        counts = (len(self._schemas), len(self._channels), 0, 0, len(self._chunks))
        statistics = struct.pack("<QHIIII", self._counts.total(), *counts)
        statistics += struct.pack("<QQ", *(self._span or (0, 0))) + _encode_mapping(self._counts)
        groups: dict[Opcode, Sequence[bytes]] = {
            Opcode.SCHEMA: self._schemas,
            Opcode.CHANNEL: self._channels,
            Opcode.STATISTICS: [_record(Opcode.STATISTICS, statistics)],
            Opcode.CHUNK_INDEX: self._chunks,
            Opcode.ATTACHMENT_INDEX: [],
            Opcode.METADATA_INDEX: [],
        }
        start, summary, offsets = self._position, b"", b""
        for opcode, records in groups.items():
            data = b"".join(records)
            place = struct.pack("<BQQ", opcode, start + len(summary), len(data))
            offsets += _record(Opcode.SUMMARY_OFFSET, place)
            summary += data
        footer = FRAME.pack(Opcode.FOOTER, 20) + struct.pack("<QQ", start, start + len(summary))
        crc = zlib.crc32(summary + offsets + footer)
        self._write(summary + offsets + footer + struct.pack("<I", crc) + MAGIC)
