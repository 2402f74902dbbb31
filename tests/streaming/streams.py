"""What the live tests share: a trained detector and model, and offline answers to compare with."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from firstcontact.contact import Detector, detect
from firstcontact.core import Block, Dataset, Pinch
from firstcontact.signal import contact_windows
from firstcontact.streaming import (
    Armed,
    Estimated,
    ModelWithInterval,
    PinchDone,
    Pipeline,
    Refused,
    Running,
    Settled,
    Touched,
)
from firstcontact.streaming._events import Event


@dataclass(frozen=True)
class Told:
    """An event without the host's clock."""

    kind: str
    facts: tuple[object, ...]


def told(events: list[Event]) -> list[Told]:
    """What must not depend on blocks or on the host's clock."""
    out = []
    for e in events:
        match e:
            case Armed():
                facts: tuple[object, ...] = (e.sample, e.epoch)
            case Touched():
                facts = (e.contact, e.first, e.epoch)
            case Estimated():
                facts = _estimate(e)
            case Running():
                facts = _running(e)
            case Settled():
                stands = None if e.answer is None else _running(e.answer)
                facts = (e.contact, stands, e.withdrawn, e.complete, e.epoch)
            case Refused():
                facts = (e.contact, e.reason, e.epoch)
            case PinchDone():
                estimates = tuple(_estimate(x) for x in e.estimates)
                facts = (e.number, e.armed, e.end, e.epoch, e.contacts, e.strips, estimates)
                facts += tuple(_running(x) for x in e.answers)
        out.append(Told(type(e).__name__, facts))
    return out


def _running(e: Running) -> tuple[object, ...]:
    # Answers of one batch share the sums of matrix products: the last digits may differ.
    numbers = tuple(round(x, 3) + 0.0 for x in (e.value, e.low, e.high, e.half_width))
    return (e.contact, numbers, e.strange, e.samples, e.duration, e.complete, e.epoch)


def _estimate(e: Estimated) -> tuple[object, ...]:
    return (e.contact, e.value, e.low, e.high, e.duration, e.complete, e.epoch, e.used)


def run(pipeline: Pipeline, blocks: list[Block]) -> list[Event]:
    """All events of a stream."""
    events = [event for block in blocks for event in pipeline.update(block, 0.0)]
    return events + pipeline.finish()


def cut(block: Block, edges: list[int]) -> list[Block]:
    """A block in pieces."""
    places = [0, *sorted(edges), len(block.data)]
    pairs = itertools.pairwise(places)
    return [Block(block.data[a:b], block.first_sample + a, block.epoch) for a, b in pairs]


def offline(
    detector: Detector, entry: ModelWithInterval, pinch: Pinch
) -> tuple[object, float | None]:
    """First contact and answer as the study finds them."""
    contacts = detect(detector, pinch)
    first = contacts[0] if contacts else None
    windows, kept = contact_windows(Dataset((pinch,)), [first], entry.model.spec.duration)
    if not kept.any():
        return first, None
    return first, float(entry.model.predict_one(windows[0]))
