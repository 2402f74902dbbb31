"""Answers of a device that answers by itself: pinch by pinch, held against the host's own."""

from __future__ import annotations

from collections.abc import Sequence

from firstcontact.core import Block
from firstcontact.device import DeviceContact, DeviceEstimate, DevicePrediction
from firstcontact.streaming._events import Event, FromHand, HandCheck, HandPinch, PinchDone

#: A device's pinch is over so long after its first contact, s: the host's has been told by then.
OVER = 0.3
#: Epoch and sample of a contact.
Place = tuple[int, int]


class HandAnswers:
    """Gathers what a device tells and what the host found of the same pinches.

    Parameters
    ----------
    model
        Digest of the device's model.
    rate
        Of the samples, Hz.
    checked
        Whether the host asks a model of its own, so that there is something to compare.
    """

    def __init__(self, model: str, rate: float, checked: bool) -> None:
        self._model = model
        self._over = round(OVER * rate)
        self._checked = checked
        # With the first contact that each belongs to: a second one is known later and may be placed
        # before it.
        self._told: list[tuple[Place, DevicePrediction]] = []
        self._first: Place | None = None
        self._done: list[PinchDone] = []
        self._number = 0
        self._heard: Place | None = None  # up to here, and what was not heard before: from, to
        self._gaps: list[tuple[Place, Place]] = []

    def came(self, told: Sequence[DevicePrediction], block: Block, host: float) -> list[Event]:
        """The device told these, and samples up to the end of a block are here."""
        begin = (block.epoch, block.first_sample)
        if self._heard is not None and self._heard < begin:
            self._gaps = [g for g in self._gaps if g[1] > self._away(self._heard, -4)]
            self._gaps.append((self._heard, begin))
        self._heard = (block.epoch, block.end)
        for one in told:
            if isinstance(one, DeviceContact) and one.first:
                self._first = _place(one)
            second = isinstance(one, DeviceContact) and not one.first
            own = self._first if second and self._first is not None else _place(one)
            self._told.append((own, one))
        events: list[Event] = [FromHand(t, host) for t in told]
        return events + self._pinches(block.epoch, block.end - self._over)

    def done(self, pinch: PinchDone) -> None:
        """The host found a pinch."""
        if self._checked and pinch.contacts:
            self._done.append(pinch)

    def ended(self) -> list[Event]:
        """No more samples come."""
        last = max((place for place, _ in self._told), default=(0, 0))
        own = max(map(_found, self._done), default=(0, 0))
        return self._pinches(*max(last, own))

    def _pinches(self, epoch: int, until: int) -> list[Event]:
        """Pinches whose first contact was up to this sample, each once."""
        due = (epoch, until)
        events: list[Event] = []
        firsts = [t for _, t in self._told if isinstance(t, DeviceContact) and t.first]
        for first in firsts:
            place = _place(first)
            if place > due:
                break
            following = [_place(f) for f in firsts if _place(f) > place]
            end = min([*following, self._away(place, 1)])
            its = [t for at, t in self._told if place <= at < end]
            self._told = [(at, t) for at, t in self._told if at >= end]
            near = [
                d for d in self._done
                if d.epoch == first.epoch and abs(d.contacts[0].sample - first.sample) < self._over
            ]  # fmt: skip
            own = min(near, key=lambda d: abs(d.contacts[0].sample - first.sample), default=None)
            if own is not None:
                self._done.remove(own)
            lost = own is None and self._in_gap(place)
            events.append(self._pinch(first, its, own, lost))
        # Answers without a first contact belong to no pinch.
        self._told = [(at, t) for at, t in self._told if at > due]
        for own in [d for d in self._done if _found(d) <= due]:
            self._done.remove(own)
            events.append(self._pinch(None, [], own, lost=False))
        return events

    def _in_gap(self, contact: Place) -> bool:
        """Whether the host lost samples about a contact: it judges from what lies around it."""
        before, after = self._away(contact, -1), self._away(contact, 1)
        return any(start < after and before < end for start, end in self._gaps)

    def _away(self, place: Place, pinches: int) -> Place:
        return place[0], place[1] + pinches * self._over

    def _pinch(
        self,
        first: DeviceContact | None,
        its: Sequence[DevicePrediction],
        own: PinchDone | None,
        lost: bool,
    ) -> HandPinch:
        contacts = [t for t in its if isinstance(t, DeviceContact)]
        second = contacts[1] if len(contacts) > 1 else None
        answers = [t for t in its if isinstance(t, DeviceEstimate) and not t.refused]
        if first is not None and second is not None:
            # As on the host: what was made from samples after the second contact does not count.
            offset = second.sample - first.sample
            answers = [t for t in answers if t.samples <= offset]
        self._number += 1
        at = (0, 0) if own is None else _found(own)
        epoch, sample = at if first is None else _place(first)
        return HandPinch(
            number=self._number,
            model=self._model,
            first=first,
            second=second,
            standing=answers[-1] if answers else None,
            answers=len(answers),
            check=_check(contacts, answers, own, lost) if self._checked else None,
            sample=sample,
            epoch=epoch,
        )


def _place(told: DevicePrediction) -> Place:
    """Epoch and sample of the contact that something is about."""
    return told.epoch, told.sample if isinstance(told, DeviceContact) else told.contact


def _found(done: PinchDone) -> Place:
    """Epoch and sample of a pinch's first contact, as the host found it."""
    return done.epoch, done.contacts[0].sample


def _check(
    contacts: Sequence[DeviceContact],
    answers: Sequence[DeviceEstimate],
    own: PinchDone | None,
    lost: bool,
) -> HandCheck:
    here = [] if own is None else list(own.contacts)
    same = [(c.finger, c.sample, c.decided) for c in contacts] == [
        (c.finger, c.sample, c.decided) for c in here
    ]
    found = {} if own is None else {(e.contact.sample, e.samples): e for e in own.answers}
    pairs = [(t, found.get((t.contact, t.samples))) for t in answers]
    both = [(t, e) for t, e in pairs if e is not None]
    differences = [
        abs(a - b)
        for t, e in both
        for a, b in ((t.value, e.value), (t.low, e.low), (t.high, e.high))
    ]
    last = own.standing.samples if own is not None and own.standing is not None else None
    stands = answers[-1].samples if answers else None
    return HandCheck(
        contacts=same,
        compared=len(both),
        largest=max(differences, default=0.0),
        flags=all(t.out_of_range == e.strange for t, e in both),
        missing=len(pairs) - len(both) + (last != stands),
        lost=lost,
    )
