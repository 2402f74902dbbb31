"""Check of one closing during a recording, to decide if it is a valid training pinch."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from firstcontact.core import Block, ChannelKind, Contact, Finger, Layout, VibrationSensor
from firstcontact.core.layout import ADC_COUNTS, ADC_VOLTS, PIEZO_OFFSET_VOLTS, finger_words
from firstcontact.core.pinch import first_closed_sample

#: Length of a pinch after its first contact, s: the longest windows and offsets fit in it.
AFTER = 0.3
#: Shortest length after the first contact of a valid pinch, s. Recording can cut a pinch short.
LEAST_AFTER = 0.15
#: Largest difference between the contacts that strip and piezo show, s.
AGREE = 0.005
#: A piezo within one count of the converter's ends is clipped, V.
_COUNT = ADC_VOLTS / ADC_COUNTS
LOWEST, HIGHEST = 0.5 * _COUNT - PIEZO_OFFSET_VOLTS, ADC_VOLTS - PIEZO_OFFSET_VOLTS - 1.5 * _COUNT
#: A sound input above this share of its full scale is clipped.
FULL = 0.99


@dataclass(slots=True)
class ClosingCheck:
    """Check of one closing during a recording. Pass each block of samples to :meth:`follow`.

    ``began`` is the number of the closing's first sample, in the epoch ``epoch``. ``strips`` are
    the samples at which the contact strips closed, and ``contacts`` those detected by the piezos,
    by finger. ``lost`` is True if samples were lost, and ``seen`` is the next sample's number.
    """

    layout: Layout
    began: int
    epoch: int
    strips: dict[Finger, int] = field(default_factory=dict)
    contacts: dict[Finger | None, Contact] = field(default_factory=dict)
    clipped: set[Finger | None] = field(default_factory=set)
    closed_before: set[Finger] = field(default_factory=set)
    lost: bool = False
    seen: int = 0

    def __post_init__(self) -> None:
        self.seen = self.began

    @property
    def anchor(self) -> int | None:
        """Sample number of the first contact, from strips or else piezos; None without one."""
        samples = self.strips.values() or [c.sample for c in self.contacts.values()]
        return min(samples, default=None)

    @property
    def end(self) -> int | None:
        """Number of the first sample after the pinch; None without a contact."""
        anchor = self.anchor
        return None if anchor is None else anchor + round(AFTER * self.layout.rate)

    @property
    def truth(self) -> tuple[Contact, ...]:
        """True contacts, at which the contact strips closed, in time order."""
        contacts = [Contact(f, s, s) for f, s in self.strips.items()]
        return tuple(sorted(contacts, key=lambda c: c.sample))

    @property
    def detected(self) -> tuple[Contact, ...]:
        """Contacts that the piezos of fingers without a contact strip showed, in time order."""
        has_strip = {f for f in Finger if self.layout.columns(ChannelKind.STRIP, f)}
        contacts = [c for f, c in self.contacts.items() if f not in has_strip]
        return tuple(sorted(contacts, key=lambda c: c.sample))

    def follow(self, block: Block) -> None:
        """Process the next block of samples. Samples outside the pinch are ignored."""
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
        """Return the reasons why the closing is not a valid pinch; [] if it is."""
        faults = ["samples were lost"] if self.lost else []
        if self.anchor is None:
            return [*faults, "no contact"]
        if self.seen < self.anchor + round(LEAST_AFTER * self.layout.rate):
            faults.append("the closing was cut short")
        faults += [
            f"the {finger_words(f)}'s strip was closed from the start"
            for f in sorted(self.closed_before)
        ]
        for finger in Finger:
            has_strip = bool(self.layout.columns(ChannelKind.STRIP, finger))
            if has_strip and finger not in self.strips and finger not in self.closed_before:
                faults.append(f"the {finger_words(finger)}'s strip did not close")
            elif finger in self.strips and not self._piezo_agrees(finger):
                faults.append(f"the {finger_words(finger)}'s piezo and strip do not agree")
        return faults + [
            f"the {finger_words(c.finger)}'s {c.sensor} clipped"
            for c in self.layout.vibration
            if c.finger in self.clipped
        ]

    def disagreement(self) -> float | None:
        """Return the first finger's time of contact by its piezo minus that by its strip, s.

        Return None if the strip or the piezo of this finger showed no contact.
        """
        if not self.truth or self.truth[0].finger not in self.contacts:
            return None
        first = self.truth[0]
        return (self.contacts[first.finger].sample - first.sample) / self.layout.rate

    def _piezo_agrees(self, finger: Finger) -> bool:
        """Return True if the piezo and the strip of a finger show the same contact.

        Return True also for a finger without a piezo.
        """
        if finger not in self.layout.vibration_fingers:
            return True
        margin = AGREE * self.layout.rate
        contact = self.contacts.get(finger)
        if contact is None or self.anchor is None:
            return False
        return self.anchor - margin <= contact.sample <= self.strips[finger] + margin

    def _watch_strips(self, data: np.ndarray, first: int) -> None:
        for finger in Finger:
            columns = self.layout.columns(ChannelKind.STRIP, finger)
            if not columns or finger in self.strips or finger in self.closed_before:
                continue
            closed = data[:, columns[0]] > 0
            sample = first_closed_sample(closed, first)
            if first == self.began and closed[0]:
                self.closed_before.add(finger)
            elif sample is not None and (self.end is None or sample < self.end):
                self.strips[finger] = sample

    def _watch_rails(self, data: np.ndarray) -> None:
        for channel in self.layout.vibration if len(data) else ():
            columns = self.layout.columns(ChannelKind.VIBRATION, channel.finger)
            values = self.layout.physical(data, columns)
            if channel.unit == "full scale":
                is_clipped = np.abs(values).max() >= FULL
            else:
                is_piezo = channel.sensor is VibrationSensor.PIEZO and channel.unit == "V"
                is_clipped = is_piezo and (values.max() >= HIGHEST or values.min() <= LOWEST)
            if is_clipped:
                self.clipped.add(channel.finger)
