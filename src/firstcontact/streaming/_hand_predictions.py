"""Comparison of the predictions of device and host, pinch by pinch."""

from __future__ import annotations

from collections.abc import Sequence

from firstcontact.chain import Reason
from firstcontact.core import Block, Contact, Estimate
from firstcontact.device import DeviceContact, DevicePrediction
from firstcontact.streaming._events import (
    ContactEvent,
    ContactWithdrawn,
    Event,
    HandCheck,
    HandPinch,
    HandPrediction,
    NoEstimate,
    PinchDone,
)

#: Time after its first contact at which a device's pinch is complete, s. The host's pinch is known
#: by then.
OVER = 0.3
#: Epoch and sample of a contact.
Place = tuple[int, int]


class HandPredictions:
    """Collector that compares the predictions of a device and of the host for the same pinches."""

    def __init__(self, model: str, rate: float, checked: bool) -> None:
        self._model = model
        self._rate = rate
        self._over = round(OVER * rate)
        self._checked = checked
        # Each event with the place of its pinch's first contact. The second contact is known later,
        # but may lie before the first.
        self._events: list[tuple[Place, HandPrediction]] = []
        self._first: Contact | None = None
        self._first_place: Place | None = None
        self._done: list[PinchDone] = []
        self._number = 0
        self._heard: Place | None = None  # end of the samples so far
        self._gaps: list[tuple[Place, Place]] = []  # begin and end of gaps in them

    def update(
        self, messages: Sequence[DevicePrediction], block: Block, host: float
    ) -> list[Event]:
        """Process messages of the device and the newest samples. Return the events that follow."""
        begin = (block.epoch, block.first_sample)
        if self._heard is not None and self._heard < begin:
            self._gaps = [g for g in self._gaps if g[1] > self._away(self._heard, -4)]
            self._gaps.append((self._heard, begin))
        self._heard = (block.epoch, block.end)
        events: list[Event] = []
        for message in messages:
            place = _place(message)
            if isinstance(message, DeviceContact):
                if message.first:
                    self._first_place = place
                elif self._first_place is not None:
                    place = self._first_place
            event = HandPrediction(self._event(message, host))
            events.append(event)
            if isinstance(event.event, ContactWithdrawn):
                # What followed this contact in its closing was none either.
                self._events = [(at, e) for at, e in self._events if at < place]
            else:
                self._events.append((place, event))
        return events + self._pinches(block.epoch, block.end - self._over)

    def _event(
        self, message: DevicePrediction, host: float
    ) -> ContactEvent | ContactWithdrawn | Estimate | NoEstimate:
        """Return the live event of a message."""
        if isinstance(message, DeviceContact):
            contact = Contact(message.finger, message.sample, message.decided)
            if message.withdrawn:
                if self._first is not None and self._first.sample == message.sample:
                    contact = self._first
                return ContactWithdrawn(contact, message.decided, message.epoch)
            if message.first:
                self._first = contact
            return ContactEvent(contact, message.first, message.epoch, host)
        contact = Contact(message.finger, message.contact, message.decided)
        if self._first is not None and self._first.sample == message.contact:
            contact = self._first
        if message.refused:
            known = message.reason in list(Reason)
            reason = Reason(message.reason).name if known else "unknown"
            reason = reason.lower().replace("_", " ")
            return NoEstimate(contact, reason, message.decided, message.epoch)
        return Estimate(
            value=message.value,
            low=message.low,
            high=message.high,
            level=0.0,
            elapsed=message.samples / self._rate,
            available=message.delay(self._rate),
            out_of_range=message.out_of_range,
            model=self._model,
            contact=contact,
            complete=message.decided,
            epoch=message.epoch,
            host=host,
            compute=message.compute_time,
        )

    def add_pinch(self, pinch: PinchDone) -> None:
        """Add a finished pinch of the host."""
        if self._checked and pinch.contacts:
            self._done.append(pinch)

    def ended(self) -> list[Event]:
        """Return the events of the remaining pinches, at the end of the stream."""
        last = max((place for place, _ in self._events), default=(0, 0))
        host_last = max(map(_pinch_place, self._done), default=(0, 0))
        # The device may have predicted from samples that the host has not processed.
        return self._pinches(*min(max(last, host_last), self._heard or (0, 0)))

    def _pinches(self, epoch: int, until: int) -> list[Event]:
        """Return new events of pinches whose first contact is at sample ``until`` or earlier."""
        due = (epoch, until)
        events: list[Event] = []
        firsts = [
            place
            for place, event in self._events
            if isinstance(event.event, ContactEvent) and event.event.first
        ]
        for place in firsts:
            if place > due:
                break
            following = [other for other in firsts if other > place]
            end = min([*following, self._away(place, 1)])
            predictions = [event for at, event in self._events if place <= at < end]
            self._events = [(at, event) for at, event in self._events if at >= end]
            near = [
                d for d in self._done
                if d.epoch == place[0] and abs(d.contacts[0].sample - place[1]) < self._over
            ]  # fmt: skip
            host_pinch = min(near, key=lambda d: abs(d.contacts[0].sample - place[1]), default=None)
            if host_pinch is not None:
                self._done.remove(host_pinch)
            lost = host_pinch is None and self._in_gap(place)
            events.append(self._pinch(place, predictions, host_pinch, lost=lost))
        # Predictions without a first contact belong to no pinch.
        self._events = [(at, event) for at, event in self._events if at > due]
        for host_pinch in [d for d in self._done if _pinch_place(d) <= due]:
            self._done.remove(host_pinch)
            events.append(self._pinch(_pinch_place(host_pinch), [], host_pinch, lost=False))
        return events

    def _in_gap(self, contact: Place) -> bool:
        """Return True if the host lost samples near a contact."""
        earliest, latest = self._away(contact, -1), self._away(contact, 1)
        return any(start < latest and earliest < end for start, end in self._gaps)

    def _away(self, place: Place, pinches: int) -> Place:
        return place[0], place[1] + pinches * self._over

    def _pinch(
        self,
        place: Place,
        predictions: Sequence[HandPrediction],
        host_pinch: PinchDone | None,
        *,
        lost: bool,
    ) -> HandPinch:
        contacts = [p.event.contact for p in predictions if isinstance(p.event, ContactEvent)]
        estimates = [p.event for p in predictions if isinstance(p.event, Estimate)]
        if len(contacts) > 1:
            # As on the host: estimates from samples after the second contact do not count.
            offset = (contacts[1].sample - contacts[0].sample) / self._rate
            estimates = [e for e in estimates if e.elapsed <= offset]
        self._number += 1
        return HandPinch(
            number=self._number,
            model=self._model,
            contacts=tuple(contacts[:2]),
            final=estimates[-1] if estimates else None,
            estimates=len(estimates),
            check=_check(contacts, estimates, host_pinch, lost) if self._checked else None,
            sample=place[1],
            epoch=place[0],
        )


def _place(message: DevicePrediction) -> Place:
    """Return epoch and sample of the contact that a message describes."""
    sample = message.sample if isinstance(message, DeviceContact) else message.contact
    return message.epoch, sample


def _pinch_place(host_pinch: PinchDone) -> Place:
    """Return epoch and sample of a pinch's first contact, as the host detected it."""
    return host_pinch.epoch, host_pinch.contacts[0].sample


def _check(
    contacts: Sequence[Contact],
    estimates: Sequence[Estimate],
    host_pinch: PinchDone | None,
    lost: bool,
) -> HandCheck:
    host_contacts = [] if host_pinch is None else list(host_pinch.contacts)
    host_estimates = () if host_pinch is None else host_pinch.estimates
    theirs = [_numbers(e) for e in host_estimates]
    ours = [_numbers(e) for e in estimates]
    # The device may have skipped estimates that were late, but not the last one.
    is_same = (
        list(contacts) == host_contacts and set(ours) <= set(theirs) and ours[-1:] == theirs[-1:]
    )
    return HandCheck(same=is_same, compared=len(ours), lost=lost)


def _numbers(e: Estimate) -> tuple[int, float, float, float, float, bool]:
    """Return what must be equal on device and host."""
    return e.contact.sample, e.elapsed, e.value, e.low, e.high, e.out_of_range
