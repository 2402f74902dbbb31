"""What comes over a wire or from a page, damaged; no process and no port is needed for it."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from random import Random

import fuzz_mutate as mutate
import numpy as np
from fuzz_seeds import piezo_layout

from firstcontact.contact.registry import DETECTORS
from firstcontact.core import Block, InputError
from firstcontact.core.layout import fingertip_layout
from firstcontact.device import protocol
from firstcontact.device._responder import Responder
from firstcontact.device.assembler import Assembler
from firstcontact.device.decoder import Decoder
from firstcontact.device.protocol import FrameType
from firstcontact.device.source import Descriptor
from firstcontact.live.hand_requests import Ask
from firstcontact.live.page._allowance import Allowance
from firstcontact.live.page._commands import Commands
from firstcontact.live.pipeline import Pipeline
from firstcontact.recording import Header, RecordingWriter, read_recording

DESCRIPTOR = Descriptor(piezo_layout(), "firmware", "sensor", "hand", "real")
CHANNELS = len(DESCRIPTOR.layout.channels)


def descriptor(rng: Random, folder: Path) -> None:
    """A descriptor that is taken must be one that all that follows can work with."""
    of = DESCRIPTOR if rng.random() < 0.6 else Descriptor(fingertip_layout())
    text = mutate.tree(rng, json.loads(of.to_text())).decode(errors="replace")
    taken = Descriptor.from_text(text)
    layout = taken.layout
    pipeline = Pipeline(layout, DETECTORS["three_sigma"]())
    rest = np.zeros((400, len(layout.channels)), np.int16)
    rest[::2] = 1
    list(pipeline.update(Block(rest, 0, 0), 0.0))
    pipeline.finish()
    path = folder / "made.mcap"
    header = Header(layout, taken.source, firmware=taken.firmware, sensor=taken.sensor)
    with RecordingWriter(path, header) as writer:
        writer.write(Block(rest, 0, 0))
    read = read_recording(path)
    assert (read.header.layout, read.samples) == (layout, 400), "what was recorded is read again"


def frames(rng: Random, _: Path) -> None:
    """A device's bytes with flips, or frames of other payloads with their CRC right."""
    honest = rng.random() < 0.4
    sent = [(FrameType.DESCRIPTOR, protocol.descriptor_payload(7, DESCRIPTOR.to_text()))]
    for i in range(30):
        data = np.arange(i * 5 * CHANNELS, (i + 1) * 5 * CHANNELS, dtype=np.int16)
        block = data.reshape(5, CHANNELS)
        sent.append((FrameType.SAMPLES, protocol.samples_payload(i * 5, 0, block)))
        if i % 9 == 3:
            sent.append((FrameType.MARKER, protocol.marker_payload(i * 5, "word")))
    sent.append((FrameType.STOPPED, protocol.stopped_payload(150, 0)))
    stream = b""
    counter = 0
    for kind, payload in sent:
        if not honest and rng.random() < 0.1:
            kind, payload = _other(rng, kind, payload)
        counter += 1 if honest or rng.random() < 0.97 else rng.choice((-3, 0, 2**31, 2**32 - 1))
        stream += protocol.encode(int(kind) % 256, counter, payload)
    if honest or rng.random() < 0.2:
        stream = mutate.raw(rng, stream)
    decoder, assembler = Decoder(), Assembler()
    assembler.asked()
    at = 0
    while at < len(stream):
        step = rng.choice((1, 7, 64, 1000, 10**6))
        made = assembler.take(decoder.feed(stream[at : at + step]))
        at += step
        for block in made.blocks if honest else ():
            number = np.arange(block.first_sample * CHANNELS, block.end * CHANNELS)
            assert (block.data.reshape(-1) == number).all(), "a sample is another one"


def _other(rng: Random, kind: int, payload: bytes) -> tuple[int, bytes]:
    what = rng.randrange(5)
    if what == 0:
        return rng.choice((*FrameType, 0, 7, 255)), payload
    if what == 1:
        return kind, mutate.raw(rng, payload)
    if what == 2:
        return kind, payload[: rng.randrange(len(payload) + 1)]
    if what == 3:
        text = mutate.tree(rng, json.loads(DESCRIPTOR.to_text())).decode(errors="replace")
        return FrameType.DESCRIPTOR, protocol.descriptor_payload(rng.randrange(9), text[:9000])
    edges = (0, 2**31, 2**32 - 1, 75)
    many = np.zeros((rng.choice((1, 5, 60)), CHANNELS), np.int16)
    return FrameType.SAMPLES, protocol.samples_payload(rng.choice(edges), rng.choice(edges), many)


def requests(rng: Random, _: Path) -> None:
    """A host's bytes, as the device hears them."""
    device = Responder(DESCRIPTOR, 1, 100, on_order=lambda text: text)
    stream = b""
    for _ in range(rng.randrange(1, 12)):
        kind = rng.choice((*FrameType, 0, 255))
        payload = rng.choice((b"", b"\x01", b"\x09", b"word", rng.randbytes(rng.choice((3, 300)))))
        stream += protocol.encode(int(kind), rng.randrange(2**32), payload)
    device.hear(mutate.raw(rng, stream) if rng.random() < 0.7 else stream)
    device.sample(np.zeros((rng.choice((1, 5, 250)), CHANNELS), np.int16))
    for _ in range(200):
        frame = device.frame()
        if not frame:
            return
        protocol.decode(frame[:-1])


class _Controls:
    """A session that does what viewers ask, and nothing."""

    recording_path: Path | None = None

    def start_recording(self) -> Path:
        return Path("recording.mcap")

    def stop_recording(self) -> None:
        return

    def mark(self, text: str) -> None:
        assert len(text.encode()) <= protocol.MARKER_BYTES
        text.encode()

    def ask_hand(self, ask: Ask, by: str) -> None:
        assert ask in Ask

    def hand_gone(self, by: str) -> None:
        return


def page(rng: Random, _: Path) -> None:
    """Messages of a viewer: each has an answer that can be sent."""
    commands = Commands(_Controls())  # type: ignore[arg-type]
    for _ in range(rng.randrange(1, 4)):
        wish = {"do": rng.choice(("record", "stop", "mark", "close", "open")), "text": "word"}
        message: str | bytes = mutate.tree(rng, wish)
        if rng.random() < 0.7:
            message = message.decode(errors=rng.choice(("replace", "surrogateescape")))  # type: ignore[union-attr]
        answer, wait = asyncio.run(commands.obey(message, Allowance(10, 5.0), "viewer"))
        json.dumps(answer, allow_nan=False).encode()
        assert wait >= 0


#: What may be raised: a sentence for the user.
REFUSALS = (InputError,)
