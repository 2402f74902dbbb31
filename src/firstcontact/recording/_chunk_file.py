"""Writer of MCAP chunks that needs constant memory.

The writer of the library mcap keeps an index entry for every chunk until the end: some tens of MB
per hour. This writer reads the index back from the file when it closes. Otherwise both write the
same bytes.
"""

from __future__ import annotations

import struct
import zlib
from collections import Counter
from collections.abc import Iterable, Iterator
from io import BufferedRandom
from os import pread

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Message,
    MessageIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

MAGIC = b"\x89MCAP0\r\n"
_FRAME = struct.Struct("<BQ")
#: Header of an uncompressed chunk: start and end time, size, CRC, empty name, size.
_CHUNK = struct.Struct("<QQQIIQ")
_FOOTER = struct.Struct("<BQQQ")
_CHANNEL = struct.Struct("<H")


class ChunkFile:
    """MCAP file of uncompressed chunks."""

    def __init__(self, stream: BufferedRandom, chunk_size: int, profile: str, library: str) -> None:
        self._stream = stream
        self._chunk_size = chunk_size
        self._schemas: dict[str, Schema] = {}
        self._channels: list[Channel] = []
        self._counts: Counter[int] = Counter()
        self._chunks = 0
        self._times: tuple[int, int] | None = None  # first and last time of all messages
        self._span: tuple[int, int] | None = None  # first and last time in this chunk
        self._begin_chunk()
        stream.write(MAGIC + _packed(Header(profile, library)))
        self._start = stream.tell()

    def register(self, topic: str, encoding: str, schema: tuple[str, str, bytes]) -> int:
        """Declare a channel with a schema (name, encoding, text). Return its number, from 1."""
        name, kind, text = schema
        if name not in self._schemas:
            number = len(self._schemas) + 1
            self._schemas[name] = Schema(data=text, encoding=kind, id=number, name=name)
            self._schemas[name].write(self._chunk)
        channel = Channel(
            id=len(self._channels) + 1,
            topic=topic,
            message_encoding=encoding,
            metadata={},
            schema_id=self._schemas[name].id,
        )
        self._channels.append(channel)
        channel.write(self._chunk)
        return int(channel.id)

    def add(self, channel: int, time: int, data: bytes, sequence: int) -> None:
        """Append a message. ``time`` is in ns."""
        self._entries.setdefault(channel, []).append((time, self._chunk.count))
        message = Message(
            channel_id=channel, log_time=time, data=data, publish_time=time, sequence=sequence
        )
        message.write(self._chunk)
        self._span = _around(self._span, time)
        self._times = _around(self._times, time)
        self._counts[channel] += 1
        if self._chunk.count > self._chunk_size:
            self.end_chunk()

    def end_chunk(self) -> None:
        """Write the current chunk even if it is not full."""
        if not self._entries:
            return
        data = _contents(self._chunk)
        start, end = self._span or (0, 0)
        chunk = Chunk(
            compression="",
            data=data,
            message_end_time=end,
            message_start_time=start,
            uncompressed_crc=zlib.crc32(data),
            uncompressed_size=len(data),
        )
        index = [MessageIndex(channel, entries) for channel, entries in self._entries.items()]
        self._begin_chunk()
        self._chunks += 1
        self._stream.write(_packed(chunk, *index))

    def finish(self) -> None:
        """Write the last chunk, the index and the footer."""
        self.end_chunk()
        stop = self._stream.tell()
        self._stream.write(_packed(DataEnd(0)))
        place = start = self._stream.tell()
        crc = 0
        offsets: list[SummaryOffset] = []
        groups: list[tuple[Opcode, Iterable[McapRecord]]] = [
            (Opcode.SCHEMA, self._schemas.values()),
            (Opcode.CHANNEL, self._channels),
            (Opcode.STATISTICS, [self._statistics()]),
            (Opcode.CHUNK_INDEX, self._index(stop)),
            (Opcode.ATTACHMENT_INDEX, ()),
            (Opcode.METADATA_INDEX, ()),
        ]
        for kind, records in groups:
            first = place
            for record in records:
                data = _packed(record)
                crc = zlib.crc32(data, crc)
                place += self._stream.write(data)
            offsets.append(
                SummaryOffset(group_length=place - first, group_opcode=kind, group_start=first)
            )
        data = _packed(*offsets)
        crc = zlib.crc32(_FOOTER.pack(Opcode.FOOTER, 20, start, place), zlib.crc32(data, crc))
        footer = Footer(summary_crc=crc, summary_offset_start=place, summary_start=start)
        self._stream.write(data + _packed(footer) + MAGIC)

    def _begin_chunk(self) -> None:
        self._chunk = RecordBuilder()
        self._entries: dict[int, list[tuple[int, int]]] = {}
        self._span = None

    def _statistics(self) -> Statistics:
        start, end = self._times or (0, 0)
        return Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=self._chunks,
            message_count=self._counts.total(),
            message_end_time=end,
            message_start_time=start,
            metadata_count=0,
            schema_count=len(self._schemas),
        )

    def _index(self, stop: int) -> Iterator[ChunkIndex]:
        """Yield an index entry for each chunk before ``stop``, read back from the file."""
        self._stream.flush()
        file = self._stream.fileno()
        place = self._start
        while place < stop:
            start = place
            _, length = _FRAME.unpack(pread(file, _FRAME.size, place))
            head = pread(file, _CHUNK.size, place + _FRAME.size)
            first, last, size, _, _, packed = _CHUNK.unpack(head)
            place = behind = start + _FRAME.size + length
            offsets: dict[int, int] = {}
            while place < stop:
                head = pread(file, _FRAME.size + _CHANNEL.size, place)
                kind, length = _FRAME.unpack_from(head)
                if kind != Opcode.MESSAGE_INDEX:
                    break
                offsets[_CHANNEL.unpack_from(head, _FRAME.size)[0]] = place
                place += _FRAME.size + length
            yield ChunkIndex(
                chunk_length=behind - start,
                chunk_start_offset=start,
                compression="",
                compressed_size=packed,
                message_end_time=last,
                message_index_length=place - behind,
                message_index_offsets=offsets,
                message_start_time=first,
                uncompressed_size=size,
            )


def _packed(*records: McapRecord) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return _contents(builder)


def _contents(builder: RecordBuilder) -> bytes:
    contents: bytes = builder.end()  # type: ignore[no-untyped-call]
    return contents


def _around(span: tuple[int, int] | None, time: int) -> tuple[int, int]:
    return (time, time) if span is None else (min(span[0], time), max(span[1], time))
