"""Faults that change frames on a serial line, and helpers to read the frames that arrive."""

from __future__ import annotations

from collections.abc import Callable

from firstcontact.device import Arrival, FrameType, SerialSource, encode
from firstcontact.device._protocol import decode


def samples(arrivals: list[Arrival]) -> int:
    return sum(len(a.block.data) for a in arrivals)


def read_until(source: SerialSource, condition: Callable[[], object]) -> list[Arrival]:
    """Read arrivals until a condition is true."""
    arrivals: list[Arrival] = []
    while not condition():
        assert not source.ended
        arrivals += source.read(0.05)
    return arrivals


def every_other(count: int, sends: Callable[[bytes], bytes]) -> Callable[[bytes], bytes]:
    """Return a fault that changes each ``count``-th samples frame, except the first."""
    count_seen = 0

    def change(frame: bytes) -> bytes:
        nonlocal count_seen
        if decode(frame[:-1]).type != FrameType.SAMPLES:
            return frame
        count_seen += 1
        return sends(frame) if count_seen % count == 0 else frame

    return change


def answer_frame(kind: FrameType, payload: bytes) -> Callable[[bytes], bytes]:
    return lambda frame: encode(kind, decode(frame[:-1]).counter, payload)
