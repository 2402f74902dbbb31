"""One closing as it comes, and whether it is a pinch to learn from."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from firstcontact.core import (
    ADC_COUNTS,
    ADC_VOLTS,
    PIEZO_OFFSET_VOLTS,
    Block,
    ChannelKind,
    Contact,
    Finger,
    Layout,
    VibrationSensor,
    finger_name,
    first_closed,
)

#: A pinch reaches so far beyond its first contact, s: the longest windows and offsets fit.
AFTER = 0.3
#: Cut short by something, it still counts from here on, s.
LEAST_AFTER = 0.15
#: Strip and piezo must agree to this, s.
AGREE = 0.005
#: A piezo within one count of the converter's ends is clipped, V.
_COUNT = ADC_VOLTS / ADC_COUNTS
HIGHEST = ADC_VOLTS - PIEZO_OFFSET_VOLTS - 1.5 * _COUNT
#: So is a sound input this near its full scale.
FULL = 0.99
LOWEST = -PIEZO_OFFSET_VOLTS + 0.5 * _COUNT


@dataclass(slots=True)
class ClosingCheck:
    """What is known of a closing; follows its samples without keeping them.

    Parameters
    ----------
    layout
        The columns of the blocks.
    began, epoch
        Sample at which the gate opened.
    """

    layout: Layout
    began: int
    epoch: int
    strips: dict[Finger, int] = field(default_factory=dict)
    contacts: dict[Finger | None, Contact] = field(default_factory=dict)
    clipped: set[Finger | None] = field(default_factory=set)
    held: set[Finger] = field(default_factory=set)
    lost: bool = False
    seen: int = 0

    def __post_init__(self) -> None:
        self.seen = self.began

    @property
    def anchor(self) -> int | None:
        """Sample of the first contact: by the strips, or as detected."""
        samples = self.strips.values() or [c.sample for c in self.contacts.values()]
        return min(samples, default=None)

    @property
    def end(self) -> int | None:
        """One past the last sample that belongs to it, where there was a contact."""
        anchor = self.anchor
        return None if anchor is None else anchor + round(AFTER * self.layout.rate)

    @property
    def complete(self) -> bool:
        """Whether all its samples have come."""
        end = self.end
        return end is not None and self.seen >= end

    @property
    def truth(self) -> tuple[Contact, ...]:
        """The contacts that the strips tell, in the order of time."""
        found = [Contact(f, s, s) for f, s in self.strips.items()]
        return tuple(sorted(found, key=lambda c: c.sample))

    @property
    def found(self) -> tuple[Contact, ...]:
        """The contacts of sensors without a strip, as detected, in the order of time."""
        found = [
            c
            for f, c in self.contacts.items()
            if f is None or not self.layout.columns(ChannelKind.STRIP, f)
        ]
        return tuple(sorted(found, key=lambda c: c.sample))

    def follow(self, block: Block) -> None:
        """Take the next samples; those before its beginning or after its end do not count."""
        start = max(0, self.seen - block.first_sample)
        data = block.data[start:]
        if not len(data):
            return
        first = block.first_sample + start
        self._watch_strips(data, first)
        stop = None if self.end is None else max(0, self.end - first)
        self._watch_rails(data[:stop])
        self.seen = first + len(data)

    def faults(self) -> list[str]:
        """Why it is no pinch to learn from; nothing where it is one."""
        said = ["samples were lost"] if self.lost else []
        if self.anchor is None:
            return [*said, "no contact"]
        if self.seen < self.anchor + round(LEAST_AFTER * self.layout.rate):
            said.append("it was cut short")
        said += [f"the {finger_name(f)}'s strip was closed before" for f in sorted(self.held)]
        for finger in Finger:
            has_strip = bool(self.layout.columns(ChannelKind.STRIP, finger))
            if has_strip and finger not in self.strips and finger not in self.held:
                said.append(f"the {finger_name(finger)}'s strip did not close")
            elif finger in self.strips and not self._felt(finger):
                said.append(f"the {finger_name(finger)}'s piezo and strip do not agree")
        said += [
            f"the {finger_name(f)}'s {self._sensor(f)} clipped"
            for f in sorted(self.clipped, key=finger_name)
        ]
        return said

    def disagreement(self) -> float | None:
        """From the first contact of the strips to that of its piezo, s."""
        if not self.truth or self.truth[0].finger not in self.contacts:
            return None
        first = self.truth[0]
        return (self.contacts[first.finger].sample - first.sample) / self.layout.rate

    def _felt(self, finger: Finger) -> bool:
        """Whether the piezo has the contact of the strip.

        The second finger may feel the first one's touch through the object.
        """
        if finger not in self.layout.vibration_fingers:
            return True
        margin = AGREE * self.layout.rate
        contact = self.contacts.get(finger)
        if contact is None or self.anchor is None:
            return False
        return self.anchor - margin <= contact.sample <= self.strips[finger] + margin

    def _sensor(self, finger: Finger | None) -> str:
        its = (c.sensor for c in self.layout.vibration if c.finger is finger)
        return str(next(its, VibrationSensor.PIEZO))

    def _watch_strips(self, data: np.ndarray, first: int) -> None:
        for finger in Finger:
            columns = self.layout.columns(ChannelKind.STRIP, finger)
            if not columns or finger in self.strips or finger in self.held:
                continue
            closed = data[:, columns[0]] > 0
            sample = first_closed(closed, first)
            if first == self.began and closed[0]:
                self.held.add(finger)
            elif sample is not None and (self.end is None or sample < self.end):
                self.strips[finger] = sample

    def _watch_rails(self, data: np.ndarray) -> None:
        for channel in self.layout.vibration:
            finger = channel.finger
            columns = self.layout.columns(ChannelKind.VIBRATION, finger)
            if channel.unit == "full scale" and len(data):
                if np.abs(self.layout.physical(data, columns)).max() >= FULL:
                    self.clipped.add(finger)
            elif channel.sensor is VibrationSensor.PIEZO and channel.unit == "V" and len(data):
                volts = self.layout.physical(data, columns)
                if volts.max() >= HIGHEST or volts.min() <= LOWEST:
                    self.clipped.add(finger)
