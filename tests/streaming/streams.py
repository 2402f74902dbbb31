"""Helpers of the live tests: events without the host's clock, and offline results."""

import itertools
import threading

import numpy as np

from firstcontact.contact import Detector, detect
from firstcontact.core import Block, Contact, Dataset, Pinch
from firstcontact.device import Descriptor
from firstcontact.models import WindowPredictor
from firstcontact.signal import contact_windows
from firstcontact.streaming import (
    ClosingStart,
    ContactEvent,
    Event,
    NoEstimate,
    PinchDone,
    Pipeline,
    Update,
)
from firstcontact.streaming.events import Estimate

Facts = tuple[object, ...]
#: Longest wait for a thread, s: only a failing test ever waits so long.
LONG = 60.0


class Keeper:
    """Sink that stores its updates, and waits for ``go_on`` before each."""

    every = 0.02

    def __init__(self, name: str = "keeper", go_on: threading.Event | None = None) -> None:
        self.name = name
        self.updates: list[Update] = []
        self.order: list[str] = []
        self.taking = threading.Event()
        self.closed = threading.Event()
        self._go_on = go_on

    def open(self, descriptor: Descriptor) -> None:
        self.order.append("open")

    def take(self, update: Update) -> None:
        self.taking.set()
        if self._go_on is not None:
            self._go_on.wait(LONG)
        self.updates.append(update)

    def close(self) -> None:
        self.order.append("close")
        self.closed.set()

    @property
    def pinches(self) -> list[PinchDone]:
        """Pinches of all updates."""
        return [e for u in self.updates for e in u.events if isinstance(e, PinchDone)]


class Close(tuple[float, ...]):
    """Numbers that equal others within 0.001.

    Rows of one batch share the sums of matrix products, so the last digits may differ.
    """

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Close) and bool(np.allclose(self, other, rtol=0.0, atol=1e-3))

    def __ne__(self, other: object) -> bool:
        return not self == other


def facts(events: list[Event]) -> list[Facts]:
    """Return the events without fields that depend on block sizes or the host's clock."""
    return [(type(event).__name__, *_facts(event)) for event in events]


def _facts(e: Event) -> Facts:
    match e:
        case ClosingStart():
            return e.sample, e.epoch
        case ContactEvent():
            return e.contact, e.first, e.epoch
        case Estimate():
            numbers = Close((e.value, e.low, e.high))
            return e.contact, numbers, e.out_of_range, e.elapsed, e.complete, e.epoch, e.final
        case NoEstimate():
            return e.contact, e.reason, e.epoch
        case PinchDone():
            estimates = tuple(_facts(x) for x in e.estimates)
            return e.number, e.start, e.end, e.epoch, e.contacts, e.strips, e.reason, estimates
    raise TypeError(e)


def run(pipeline: Pipeline, blocks: list[Block]) -> list[Event]:
    """Return the events of a stream."""
    events = [event for block in blocks for event in pipeline.update(block, 0.0)]
    return events + pipeline.finish()


def as_blocks(dataset: Dataset) -> list[Block]:
    """Return one block for each pinch, each in its own epoch."""
    return [Block(p.data, p.first_sample, epoch) for epoch, p in enumerate(dataset.pinches)]


def cut_frames(dataset: Dataset, size: int = 5) -> list[Block]:
    """Return the blocks of a dataset, cut to this many samples."""
    return [p for b in as_blocks(dataset) for p in cut(b, [*range(size, len(b.data), size)])]


def cut(block: Block, edges: list[int]) -> list[Block]:
    """Return a block in pieces."""
    places = [0, *sorted(edges), len(block.data)]
    pairs = itertools.pairwise(places)
    return [Block(block.data[a:b], block.first_sample + a, block.epoch) for a, b in pairs]


def offline(
    detector: Detector, entry: WindowPredictor, pinch: Pinch
) -> tuple[Contact | None, float | None]:
    """Return the first contact and the prediction that offline functions give for a pinch."""
    contacts = detect(detector, pinch)
    first = contacts[0] if contacts else None
    windows, selected = contact_windows(Dataset((pinch,)), [first], entry.model.spec.duration)
    if not selected.any():
        return first, None
    return first, float(entry.model.predict(windows[:1])[0])
