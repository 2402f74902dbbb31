"""Synthetic session updates: a pinch at regular intervals, with both fingers ringing."""

from pathlib import Path

import numpy as np
from msgspec.structs import replace
from websockets.sync.client import ClientConnection, connect

from firstcontact.core import Block, ChannelKind, Contact, Finger, InputError, fingertip_layout
from firstcontact.core.physics import parse_radius, radius_text
from firstcontact.core.quantity import SHORE_A
from firstcontact.device import Arrival, Descriptor, Health
from firstcontact.device.recorder import RecorderStatus
from firstcontact.recording import Marker
from firstcontact.streaming import ClosingStart, ContactEvent, Event, NoEstimate, PinchDone, Update
from firstcontact.streaming.events import Ask
from firstcontact.streaming.page.sink import PageSink
from firstcontact.testing import make_estimate
from page_browser import PATIENCE

LAYOUT = fingertip_layout()
RATE = LAYOUT.rate
DESCRIPTOR = Descriptor(LAYOUT, "firstcontact 0.1.0", "piezo + 3x2 Velostat", "", "twin")
#: From one closing to the next, samples.
PERIOD = 6000
#: From the closing's beginning to the first contact, samples.
CLOSING = 1500
#: Names as long as people give them.
LANDMARKS = {
    **{f"block {s}": float(s) for s in (10, 29, 40, 50, 60)},
    "avocado": 33.0,
    "orange": 44.0,
    "apple": 68.0,
    "tennis ball": 72.0,
    "lemon": 52.0,
    "rubber eraser": 80.0,
    "golf ball, worn": 95.0,
}
WORDS = ("block 29", "apple", "", "tennis ball", "block 60")


class Feed:
    """Generator of updates of 247 samples (50 ms), each with its events."""

    def __init__(self, seed: int = 0) -> None:
        self.rng = np.random.default_rng(seed)
        self.sample = 0
        self.epoch = 0
        self.lost = 0
        self.pinches = 0
        self.recording = RecorderStatus()
        self._plan()

    def _plan(self) -> None:
        """Plan the events of the closing that begins now."""
        self.start = self.sample // PERIOD * PERIOD
        first = self.start + CLOSING
        self.shore = float(self.rng.uniform(8, 85))
        finger = Finger(int(self.rng.integers(2)))
        offset = int(self.rng.uniform(0.004, 0.034) * RATE)
        self.contacts = (
            Contact(finger, first, first + 9),
            Contact(finger.other, first + offset, first + offset + 9),
        )
        complete = first + 77
        self.estimate = replace(
            make_estimate(self.shore, self.shore - 5.2, self.shore + 6.1, 0.015),
            available=77 / RATE + 0.00021, model="svm", contact=self.contacts[0],
            complete=complete, epoch=self.epoch, compute=0.00021,
        )  # fmt: skip
        self.refused = self.pinches % 7 == 5
        end = self.start + 4500
        self.done = PinchDone(
            number=self.pinches + 1,
            start=self.start,
            end=end,
            epoch=self.epoch,
            contacts=self.contacts,
            offset=offset / RATE,
            estimates=() if self.refused else (self.estimate,),
            reason="the signal was at its limit" if self.refused else "",
        )

    def happenings(self, first: int, end: int) -> tuple[list[Event], list[Marker]]:
        """Return the events and markers that become known in these samples, in order."""
        a, b = self.contacts
        predictions: list[tuple[int, Event]] = [
            (self.start, ClosingStart(self.start, self.epoch)),
            (a.decided, ContactEvent(a, True, self.epoch, 0.0)),
            (b.decided, ContactEvent(b, False, self.epoch, 0.0)),
            (
                self.estimate.complete,
                NoEstimate(a, self.done.reason, self.estimate.complete, self.epoch)
                if self.refused
                else self.estimate,
            ),
            (self.done.end, self.done),
        ]
        events = [e for at, e in sorted(predictions, key=lambda t: t[0]) if first <= at < end]
        word = WORDS[self.pinches % len(WORDS)]
        is_due = word and first <= self.start + 5 < end
        return events, [Marker(self.start + 5, word, self.epoch)] if is_due else []

    def _samples(self, n: int) -> np.ndarray:
        """Return samples as a fingertip sends them."""
        i = self.sample + np.arange(n)
        volts = 0.006 * self.rng.normal(size=(n, len(LAYOUT.channels)))
        since = np.zeros(n)
        for contact in self.contacts:
            t = (i - contact.sample) / RATE
            on = (t >= 0) & (t < 0.55)
            ring = np.exp(-t / 0.012) * np.sin(2 * np.pi * (60 + 4 * self.shore) * t)
            size = 0.25 + 0.012 * self.shore
            volts[:, int(contact.finger)] += np.where(on, size * ring, 0)
            since = np.where(on, t, 0)
            taxels = LAYOUT.columns(ChannelKind.FORCE, contact.finger)
            force = np.clip(since / 0.1, 0, 1) * np.array([1.7, 2.1, 0.9, 1.2, 0.3, 0.1])[:, None]
            volts[:, taxels] = 0.05 + force.T
        raw = np.empty(volts.shape, np.int16)
        for k, channel in enumerate(LAYOUT.channels):
            strip = channel.kind is ChannelKind.STRIP
            raw[:, k] = 0 if strip else np.round(volts[:, k] / channel.scale + channel.offset)
        return raw

    def update(self, n: int = 247) -> Update:
        """Return an update with the next samples."""
        n = min(n, PERIOD - self.sample % PERIOD)
        block = Block(self._samples(n), self.sample, self.epoch)
        events, markers = self.happenings(self.sample, self.sample + n)
        self.sample += n
        if any(isinstance(e, PinchDone) for e in events):
            self.pinches += 1
        if self.sample % PERIOD == 0:
            self._plan()
        if self.recording.path is not None:
            self.recording = RecorderStatus(
                self.recording.path, self.recording.samples + n, 0, self.recording.failed
            )
        health = Health(
            True, self.epoch, self.sample, self.lost, 0, self.lost // 5, self.lost // 5, 0, 0,
            4936.1,
        )  # fmt: skip
        arrival = Arrival(block, 0.0, tuple(markers))
        return Update((arrival,), tuple(events), health, self.recording, self.ledger())

    def ledger(self) -> dict[str, float]:
        """Return time statistics as a session reports them."""
        if self.pinches == 0:
            return {"estimates": 0.0, "overruns": 0.0, "blocks": 0.0, "busy": 0.0}
        times = {"decide": 0.0018, "signal": 0.015, "compute": 0.00021, "total": 0.0158}
        figures = {"estimates": float(self.pinches), "overruns": 0.0, "blocks": 1.0, "busy": 1.0}
        for name, seconds in times.items():
            figures |= {
                f"{name}_p50": seconds,
                f"{name}_p99": 1.1 * seconds,
                f"{name}_max": 1.4 * seconds,
            }
        return figures

    def gap(self, n: int) -> None:
        """Skip samples, as if they were lost."""
        self.sample += n
        self.lost += n


class Requests:
    """Controls that record the viewers' requests and act on a feed."""

    def __init__(self, feed: Feed | None = None) -> None:
        self.feed = feed or Feed()
        self.calls: list[str] = []
        self.refuses = False
        self.asks: tuple[Ask, ...] = ()
        self.gone: list[str] = []
        self.quantity = SHORE_A

    def start_recording(self) -> Path:
        self.calls.append("record")
        if self.refuses:
            raise InputError("the folder cannot be written to: name another with --recordings")
        self.feed.recording = RecorderStatus(Path("live-1.mcap"))
        return Path("live-1.mcap")

    def stop_recording(self) -> Path | None:
        self.calls.append("stop")
        path = self.feed.recording.path
        self.feed.recording = RecorderStatus()
        return path

    def mark(self, text: str) -> None:
        self.calls.append(f"mark {text}")

    def hand_asks(self) -> tuple[Ask, ...]:
        return self.asks

    def ask_hand(self, ask: Ask, by: str) -> None:
        self.calls.append(f"{ask} {by}")

    def hand_gone(self, by: str) -> None:
        self.gone.append(by)

    uses_shape = True

    def set_shape(self, text: str) -> str:
        self.calls.append(f"shape {text}")
        return radius_text(parse_radius(text))

    def new_object(self) -> None:
        self.calls.append("new")


def port(sink: PageSink) -> int:
    """Return the TCP port of a page."""
    return int(sink.url.split(":")[2].split("/")[0])


def view(sink: PageSink) -> ClientConnection:
    """Connect a viewer to a page."""
    address = f"ws://127.0.0.1:{port(sink)}/socket"
    return connect(address, open_timeout=PATIENCE, close_timeout=0.5, compression=None)
