"""Damaged recordings: damaged bytes, or damaged content with correct checksums."""

import io
import json
import struct
import zlib
from functools import cache
from random import Random
from typing import Any, NamedTuple

import fuzz_mutate as mutate
import lz4.frame
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, DataEnd, Footer, Header, Message, Schema
from mcap.writer import CompressionType, Writer

MAGIC = b"\x89MCAP0\r\n"
TOPICS = ("/header", "/samples", "/pinch", "/marker")
_PREFIX = struct.Struct("<4sQIHxxI")


class RawMessage(NamedTuple):
    """Message of a recording."""

    topic: str
    data: bytes
    time: int


def messages(recording: bytes) -> list[RawMessage]:
    """Return the messages of a valid recording, in the order of the file."""
    reader = make_reader(io.BytesIO(recording))
    return [
        RawMessage(channel.topic, message.data, message.log_time)
        for _, channel, message in reader.iter_messages(log_time_order=False)
    ]


def rewritten(rng: Random, messages: list[RawMessage]) -> bytes:
    """Write changed messages by one of three writers, with valid checksums."""
    messages = list(messages)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        _change(rng, messages)
    writer = rng.choice((_by_library, _by_hand, _by_hand, _by_hand))
    return writer(rng, messages)


def _change(rng: Random, messages: list[RawMessage]) -> None:
    if not messages:
        return
    others = [i for i, t in enumerate(messages) if t.topic != "/samples"]
    i = rng.choice(others) if others and rng.random() < 0.7 else rng.randrange(len(messages))
    kind = rng.randrange(12)
    if kind <= 6:
        messages[i] = _changed(rng, messages[i])
    elif kind == 7:
        del messages[i]
    elif kind == 8:
        messages[i:i] = [messages[i]] * rng.choice((1, 2, 30))
    elif kind == 9:
        j = rng.randrange(len(messages))
        messages[i], messages[j] = messages[j], messages[i]
    elif kind == 10:
        messages[i] = messages[i]._replace(topic=rng.choice((*TOPICS, "/other", "")))
    else:
        time = rng.choice((0, 2**63, 2**64 - 1, messages[i].time // 2))
        messages[i] = messages[i]._replace(time=time)


def _changed(rng: Random, message: RawMessage) -> RawMessage:
    data = _samples(rng, message.data) if message.topic == "/samples" else None
    if data is None:
        try:
            data = mutate.tree(rng, json.loads(message.data))
        except (ValueError, RecursionError):  # it was changed before
            data = mutate.raw(rng, message.data)
    return message._replace(data=data)


def _samples(rng: Random, data: bytes) -> bytes | None:
    """Return a samples message with damaged header fields or values."""
    if len(data) < _PREFIX.size:
        return None
    kind, first, epoch, channels, count = _PREFIX.unpack_from(data)
    values = data[_PREFIX.size :]
    edge = rng.choice((0, 1, 2**15, 2**31, 2**32 - 1, first + 1, count + 1, count * 2))
    damage = rng.randrange(8)
    if damage <= 1:
        first = rng.choice((0, edge, first + 10**6, 2**62, 2**63 - 1, 2**63, 2**64 - 1))
    elif damage == 2:
        epoch = edge & 0xFFFFFFFF
    elif damage == 3:
        channels = edge & 0xFFFF
    elif damage == 4:
        count = edge & 0xFFFFFFFF
    elif damage == 5:
        values = values[: rng.randrange(len(values) + 1)]
    elif damage == 6:  # as floats: NaN, infinity
        values = rng.choice((b"\xff", b"\0\0\x80\x7f", b"\0\x80", b"\xff\x7f")) * (len(values) // 4)
        count = len(values) // rng.choice((2, 4))
    else:
        return mutate.raw(rng, data)
    return _PREFIX.pack(kind, first, epoch, channels, count) + values


def _by_library(rng: Random, messages: list[RawMessage]) -> bytes:
    """Write messages as another program would: compressed, or without chunks."""
    out = io.BytesIO()
    writer = Writer(
        out,
        chunk_size=rng.choice((200, 10_000, 1 << 20)),
        compression=rng.choice((CompressionType.NONE, CompressionType.LZ4, CompressionType.ZSTD)),
        use_chunking=rng.random() < 0.9,
    )
    writer.start("ros2", "fuzz")
    schema = writer.register_schema("any", "jsonschema", b"{}")
    topics: dict[str, int] = {}
    for number, message in enumerate(messages):
        if message.topic not in topics:
            topics[message.topic] = writer.register_channel(message.topic, "json", schema)
        time = message.time
        writer.add_message(topics[message.topic], time, message.data, time, number)
    writer.finish()
    return out.getvalue()


def _by_hand(rng: Random, messages: list[RawMessage]) -> bytes:
    """Write chunks with correct checksums and false sizes, compression or records."""
    out = MAGIC + _packed(Header("ros2", "fuzz"))
    numbers = {topic: i for i, topic in enumerate(TOPICS, 1)}
    records: list[Any] = []
    if rng.random() < 0.8:
        records.append(Schema(data=b"{}", encoding="jsonschema", id=1, name="any"))
        for topic, number in numbers.items():
            if rng.random() < 0.03:
                topic = rng.choice((*TOPICS, mutate.text(rng)[:999]))
            name = topic.encode(errors="replace").decode()
            records.append(Channel(number, name, "json", {}, 1))
    for k, message in enumerate(messages):
        number = numbers.get(message.topic, 77)
        time = message.time % 2**64
        records.append(Message(number, time, message.data, time, k))
    at = 0
    while at < len(records):
        step = rng.choice((1, 3, 10, 1000))
        out += _chunk(rng, b"".join(_packed(r) for r in records[at : at + step]))
        at += step
    if rng.random() < 0.02:
        out += _bomb(rng)
    if rng.random() < 0.7:
        out += _packed(DataEnd(0)) + _packed(Footer(0, 0, 0)) + MAGIC
    return out


def _chunk(rng: Random, data: bytes) -> bytes:
    kind = rng.choice(("", "", "", "lz4", "zstd"))
    size = len(data)
    if rng.random() < 0.04:
        size = rng.choice((0, size - 1, size + 1, 2**31, 2**63, 2**64 - 1)) % 2**64
    if rng.random() < 0.05 and len(data) > 20:  # of a record inside
        at = rng.randrange(len(data) - 8)
        number = rng.choice((0, 2**31, 2**63, 2**64 - 1))
        data = data[:at] + struct.pack("<Q", number) + data[at + 8 :]
    packed = {"": data, "lz4": lz4.frame.compress(data), "zstd": zstandard.compress(data)}[kind]
    if rng.random() < 0.02:
        kind = rng.choice(("lz4", "zstd", "", "brotli"))
    crc = zlib.crc32(data) if rng.random() < 0.97 else 0
    return _packed(Chunk(kind, packed, 0, rng.choice((0, 2**64 - 1)), crc, size))


@cache
def bomb() -> bytes:
    """Return a compressed gigabyte of zeros."""
    block = zstandard.ZstdCompressor().compressobj()
    return b"".join(block.compress(bytes(1 << 22)) for _ in range(256)) + block.flush()


def _bomb(rng: Random) -> bytes:
    """Return a small chunk that unpacks to a gigabyte and states a random size."""
    size = rng.choice((1000, 1 << 26, 1 << 30, 2**62))
    return _packed(Chunk("zstd", bomb(), 0, 0, 0, size))


def _packed(record: Any) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    out: bytes = builder.end()  # type: ignore[no-untyped-call]
    return out
