"""Damaged data over a wire or from a page, without processes and ports."""

import asyncio
import io
import json
import math
from dataclasses import replace
from pathlib import Path
from random import Random

import fuzz_mutate as mutate
import numpy as np
from fuzz_seeds import piezo_layout

from firstcontact.contact import DETECTORS
from firstcontact.core import Block, Finger, fingertip_layout
from firstcontact.device import Descriptor, Health, protocol
from firstcontact.device.assembler import Assembler
from firstcontact.device.descriptor import DeviceContact, DeviceEstimate, DevicePredictor
from firstcontact.device.lines import MOST, LineReader
from firstcontact.device.protocol import FrameType
from firstcontact.device.responder import Responder
from firstcontact.device.stamped_samples import StampedSamples
from firstcontact.recording import Header, RecordingWriter, read_recording
from firstcontact.streaming import Pipeline, Update
from firstcontact.streaming._hand_predictions import HandPredictions
from firstcontact.streaming.events import Ask
from firstcontact.streaming.json_lines import JsonLinesSink
from firstcontact.streaming.page.server import Commands
from firstcontact.streaming.page.state import State
from firstcontact.streaming.text import TextSink
from prediction_payloads import contact_payload, estimate_payload

DESCRIPTOR = Descriptor(piezo_layout(), "firmware", "sensor", "hand", "real")
CHANNELS = len(DESCRIPTOR.layout.channels)
MODEL = "0123456789abcdef"
ANSWERING = replace(DESCRIPTOR, predictor=DevicePredictor(MODEL))


def descriptor(rng: Random, folder: Path) -> None:
    """Check that all later code can use an accepted descriptor."""
    of = DESCRIPTOR if rng.random() < 0.6 else Descriptor(fingertip_layout())
    text = mutate.tree(rng, json.loads(of.to_text())).decode(errors="replace")
    taken = Descriptor.from_text(text)
    layout = taken.layout
    pipeline = Pipeline(layout, DETECTORS["three_sigma"]())
    quiet = np.zeros((400, len(layout.channels)), np.int16)
    quiet[::2] = 1
    list(pipeline.update(Block(quiet, 0, 0), 0.0))
    pipeline.finish()
    path = folder / "made.mcap"
    header = Header(layout, taken.source, firmware=taken.firmware, sensor=taken.sensor)
    with RecordingWriter(path, header) as writer:
        writer.write(Block(quiet, 0, 0))
    read = read_recording(path)
    assert (read.header.layout, read.samples) == (layout, 400), "what was recorded is read again"


def frames(rng: Random, _: Path) -> None:
    """Decode a device's bytes with bit flips, or frames with other payloads and a correct CRC."""
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
    assembler = Assembler()
    assembler.expect_descriptor()
    at = 0
    while at < len(stream):
        step = rng.choice((1, 7, 64, 1000, 10**6))
        made = assembler.feed(stream[at : at + step])
        at += step
        for block in made.blocks if honest else ():
            number = np.arange(block.first_sample * CHANNELS, block.end * CHANNELS)
            assert (block.data.reshape(-1) == number).all(), "a sample is another one"


def _other(rng: Random, kind: int, payload: bytes) -> tuple[int, bytes]:
    damage = rng.randrange(5)
    if damage == 0:
        return rng.choice((*FrameType, 0, 7, 255)), payload
    if damage == 1:
        return kind, mutate.raw(rng, payload)
    if damage == 2:
        return kind, payload[: rng.randrange(len(payload) + 1)]
    if damage == 3:
        text = mutate.tree(rng, json.loads(DESCRIPTOR.to_text())).decode(errors="replace")
        return FrameType.DESCRIPTOR, protocol.descriptor_payload(rng.randrange(9), text[:9000])
    edges = (0, 2**31, 2**32 - 1, 75)
    many = np.zeros((rng.choice((1, 5, 60)), CHANNELS), np.int16)
    return FrameType.SAMPLES, protocol.samples_payload(rng.choice(edges), rng.choice(edges), many)


def requests(rng: Random, _: Path) -> None:
    """Pass a host's damaged bytes to the device."""
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


def _estimate(rng: Random, contact: int, decided: int) -> bytes:
    numbers = [rng.choice((0.0, 30.5, 100.0, rng.uniform(0, 100)))] * 3
    numbers = [max(numbers[0] - 9, 0.0), *numbers[1:2], min(numbers[0] + 9, 100.0)]
    low, value, high = numbers
    wild = (1e38, -500.0, math.nan, math.inf, -0.0, 100.5, value)
    if rng.random() < 0.4:
        low, value, high = rng.choice(((high, value, low), (low, rng.choice(wild), high)))
    finger, samples = rng.choice(list(Finger)), rng.choice((0, 59, decided - contact, 65535))
    refused, strange = rng.random() < 0.2, rng.random() < 0.2
    estimate = DeviceEstimate(
        finger, contact, max(samples, 0) % 65536, decided, value, low, high, refused, strange,
        4e-4, 0,
    )  # fmt: skip
    return estimate_payload(estimate)


def answers(rng: Random, _: Path) -> None:
    """Check that accepted contacts and estimates of a device are valid and can be shown."""
    out = io.StringIO()
    text, lines, state = TextSink(out), JsonLinesSink(out), State(ANSWERING, {}, None)
    for sink in (text, lines):
        sink.open(ANSWERING)
    gathered = HandPredictions(MODEL, ANSWERING.layout.rate, checked=True)
    assembler = Assembler()
    assembler.expect_descriptor()
    sent = [(FrameType.DESCRIPTOR, protocol.descriptor_payload(7, ANSWERING.to_text()))]
    at = rng.choice((0, 5000, 2**31, 2**32 - 3000))
    for _ in range(rng.randrange(1, 40)):
        far = rng.choice((0, 0, 0, 1, -1, 5000, -5000, 10**6, 2**31))
        contact, decided = at - rng.randrange(3, 60) + far, at + rng.choice((0, 0, 0, far))
        payload = _estimate(rng, contact, decided)
        if rng.random() < 0.4:
            finger, is_first = rng.choice(list(Finger)), rng.random() < 0.7
            payload = contact_payload(finger, contact, decided, is_first)
        kind = FrameType.ESTIMATE
        if len(payload) == 10:
            kind = rng.choice((FrameType.CONTACT, FrameType.CONTACT, FrameType.WITHDRAWN))
        sent.append((kind, mutate.raw(rng, payload) if rng.random() < 0.1 else payload))
        many = np.zeros((5, CHANNELS), np.int16)
        for _ in range(rng.choice((0, 1, 30))):
            sent.append((FrameType.SAMPLES, protocol.samples_payload(at, 0, many)))
            at += 5
    wire = [protocol.encode(int(kind), k, payload) for k, (kind, payload) in enumerate(sent)]
    for k in range(0, len(wire), 20):
        made = assembler.feed(b"".join(wire[k : k + 20]))
        for event in made.predictions:
            contact = event.sample if isinstance(event, DeviceContact) else event.contact
            assert 0 <= contact <= event.decided, "a contact that is not in the samples"
            if isinstance(event, DeviceEstimate):
                assert 0 <= event.low <= event.value <= event.high <= 100, "no Shore A"
        blocks = made.blocks or [Block(np.zeros((1, CHANNELS), np.int16), at, assembler.epoch)]
        events = gathered.update(made.predictions, blocks[-1], 0.0)
        update = Update(events=tuple(events), health=Health(connected=True))
        for sink in (text, lines, state):
            sink.take(update)
        for part in state.changed({}).values():
            json.loads(part)
    assert gathered.ended() is not None


class _Controls:
    """Session controls that do nothing."""

    recording_path: Path | None = None

    def start_recording(self) -> Path:
        return Path("recording.mcap")

    def stop_recording(self) -> Path | None:
        return self.recording_path

    def mark(self, text: str) -> None:
        assert len(text.encode()) <= protocol.MARKER_BYTES
        text.encode()

    def ask_hand(self, ask: Ask, by: str) -> None:
        assert ask in Ask

    def hand_gone(self, by: str) -> None:
        return


def page(rng: Random, _: Path) -> None:
    """Send messages of a viewer. Each must get a valid reply."""
    commands = Commands(_Controls())  # type: ignore[arg-type]
    for _ in range(rng.randrange(1, 4)):
        request = {"do": rng.choice(("record", "stop", "mark", "close", "open")), "text": "word"}
        message: str | bytes = mutate.tree(rng, request)
        if rng.random() < 0.7:
            message = message.decode(errors=rng.choice(("replace", "surrogateescape")))  # type: ignore[union-attr]
        answer = asyncio.run(commands.obey(message, "viewer"))
        json.dumps(answer, allow_nan=False).encode()


def lines(rng: Random, _: Path) -> None:
    """Feed lines of a board in pieces of any size. All numbers that are read must be finite."""
    between = rng.choice((",", ";", "\t", " ", ", "))
    rows = ["n", "left", "right"] if rng.random() < 0.5 else ["0", "1", "2"]
    text = between.join(rows) + "\n"
    for i in range(60):
        words = [str(i), str(rng.randrange(1024)), str(rng.randrange(1024))]
        if rng.random() < 0.1:
            words[rng.randrange(3)] = rng.choice((*mutate.TEXTS, *map(str, mutate.NUMBERS)))
        text += between.join(words) + rng.choice(("\n", "\r\n"))
    stream = text.encode(errors="replace")
    stream = mutate.raw(rng, stream) if rng.random() < 0.5 else stream
    reader, at = LineReader(), 0
    while at < len(stream):
        step = rng.choice((1, 7, 64, 100_000))
        for numbers in reader.feed(stream[at : at + step]):
            if numbers is not None:
                assert 0 < len(numbers) <= MOST
                assert np.isfinite(numbers).all(), "a number that is none"
        at += step


def stamps(rng: Random, _: Path) -> None:
    """Feed stamps that jump, stop, go back or are NaN. Sample numbers must still rise."""
    counted, last, now = StampedSamples(1000.0), -1, rng.choice((0.0, 1e9, -5.0))
    for _ in range(rng.choice((3, 60, 150))):
        n = rng.choice((1, 2, 40))
        if rng.random() < 0.1:
            now += rng.choice((-1.0, 0.5, 30.0, -1e4, 1e6))
        jitter = rng.choice((0.0, 1e-4, 5e-3))
        sample = now + np.arange(n) / 1000.0 + [jitter * rng.gauss(0, 1) for _ in range(n)]
        if rng.random() < 0.1:
            sample[rng.randrange(n)] = rng.choice((np.nan, np.inf, -np.inf, 1e300))
        now += n / 1000.0
        numbers = counted.numbers(sample)
        assert numbers[0] > last, "a number twice"
        assert (np.diff(numbers) > 0).all(), "numbers that do not rise"
        last = int(numbers[-1])
