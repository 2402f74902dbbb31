"""Comparison of a device's predictions with predictions by this computer, pinch by pinch."""

from __future__ import annotations

from collections.abc import Sequence

from firstcontact.chain import Reason
from firstcontact.core import Block, Contact, Estimate
from firstcontact.device.descriptor import DeviceContact, DevicePrediction
from firstcontact.streaming.events import (
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
Prediction = ContactEvent | ContactWithdrawn | Estimate | NoEstimate


class HandPredictions:
    """Collector that compares a device's predictions with predictions by this computer."""

    def __init__(self, model: str, rate: float, checked: bool) -> None:
        self._model = model
        self._rate = rate
        self._over = round(OVER * rate)
        self._checked = checked
        #: Predictions of the device's open pinches, by the place of the first contact.
        self._pinches: dict[Place, list[Prediction]] = {}
        self._first: Contact | None = None
        self._host_pinches: list[PinchDone] = []
        self._number = 0
        self._heard: Place = (0, 0)  # end of the samples so far
        self._gaps: list[tuple[Place, Place]] = []  # begin and end of gaps in them

    def update(
        self, messages: Sequence[DevicePrediction], block: Block, host: float
    ) -> list[Event]:
        """Process the messages of a device and the newest samples. Return new events.

        ``host`` is the time of arrival by this computer's ``time.monotonic()``, s.
        """
        begin = (block.epoch, block.first_sample)
        if (0, 0) < self._heard < begin:
            self._gaps = [g for g in self._gaps if g[1] > self._away(self._heard, -4)]
            self._gaps.append((self._heard, begin))
        self._heard = (block.epoch, block.end)
        events: list[Event] = []
        for message in messages:
            prediction = self._event(message, host)
            events.append(HandPrediction(prediction))
            # The second contact is known later, but may lie before the first. Predictions without a
            # first contact belong to no pinch.
            place = (message.epoch, -1 if self._first is None else self._first.sample)
            if isinstance(prediction, ContactEvent) and prediction.first:
                self._pinches[place] = []
            if isinstance(prediction, ContactWithdrawn):
                self._pinches.pop(place, None)
            elif place in self._pinches:
                self._pinches[place].append(prediction)
        return events + self._complete((block.epoch, block.end - self._over))

    def add_pinch(self, pinch: PinchDone) -> None:
        if self._checked and pinch.contacts:
            self._host_pinches.append(pinch)

    def ended(self) -> list[Event]:
        """Return the results of all remaining pinches, at the end of the session."""
        # The device may have predicted from samples that the host has not processed.
        return self._complete(self._heard)

    def _event(self, message: DevicePrediction, host: float) -> Prediction:
        sample = message.sample if isinstance(message, DeviceContact) else message.contact
        contact = Contact(message.finger, sample, message.decided)
        if isinstance(message, DeviceContact) and not message.withdrawn:
            if message.first:
                self._first = contact
            return ContactEvent(contact, message.first, message.epoch, host)
        if self._first is not None and self._first.sample == sample:
            contact = self._first  # decided earlier than this message
        if isinstance(message, DeviceContact):
            return ContactWithdrawn(contact, message.decided, message.epoch)
        if message.refused:
            is_known = message.reason in list(Reason)
            reason = Reason(message.reason).name if is_known else "unknown"
            reason = reason.lower().replace("_", " ")
            return NoEstimate(contact, reason, message.decided, message.epoch)
        return Estimate(
            value=message.value,
            low=message.low,
            high=message.high,
            level=0.0,
            elapsed=message.samples / self._rate,
            available=(message.decided - message.contact) / self._rate + message.compute_time,
            out_of_range=message.out_of_range,
            model=self._model,
            contact=contact,
            complete=message.decided,
            epoch=message.epoch,
            host=host,
            compute=message.compute_time,
        )

    def _complete(self, due: Place) -> list[Event]:
        """Return the results of all pinches whose first contact is not after ``due``.

        ``due`` is an epoch (run of the device's sample counter) and a sample number in it.
        """
        events: list[Event] = []
        for place in [place for place in self._pinches if place <= due]:
            near = [
                p for p in self._host_pinches
                if p.epoch == place[0] and abs(p.contacts[0].sample - place[1]) < self._over
            ]  # fmt: skip
            host_pinch = min(near, key=lambda p: abs(p.contacts[0].sample - place[1]), default=None)
            if host_pinch is not None:
                self._host_pinches.remove(host_pinch)
            lost = host_pinch is None and self._is_in_gap(place)
            events.append(self._pinch(place, self._pinches.pop(place), host_pinch, lost=lost))
        for host_pinch in list(self._host_pinches):
            place = host_pinch.epoch, host_pinch.contacts[0].sample
            if place <= due:
                self._host_pinches.remove(host_pinch)
                events.append(self._pinch(place, [], host_pinch, lost=False))
        return events

    def _is_in_gap(self, contact: Place) -> bool:
        earliest, latest = self._away(contact, -1), self._away(contact, 1)
        return any(start < latest and earliest < end for start, end in self._gaps)

    def _away(self, place: Place, pinches: int) -> Place:
        return place[0], place[1] + pinches * self._over

    def _pinch(
        self,
        place: Place,
        predictions: Sequence[Prediction],
        host_pinch: PinchDone | None,
        *,
        lost: bool,
    ) -> HandPinch:
        contacts = [p.contact for p in predictions if isinstance(p, ContactEvent)]
        estimates = [p for p in predictions if isinstance(p, Estimate)]
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


def _check(
    contacts: Sequence[Contact],
    estimates: Sequence[Estimate],
    host_pinch: PinchDone | None,
    lost: bool,
) -> HandCheck:
    host_contacts = [] if host_pinch is None else list(host_pinch.contacts)
    theirs = [] if host_pinch is None else [_numbers(e) for e in host_pinch.estimates]
    ours = [_numbers(e) for e in estimates]
    # The device may have skipped estimates that were late, but not the last one.
    is_same = (
        list(contacts) == host_contacts and set(ours) <= set(theirs) and ours[-1:] == theirs[-1:]
    )
    return HandCheck(same=is_same, compared=len(ours), lost=lost)


def _numbers(e: Estimate) -> tuple[int, float, float, float, float, bool]:
    """Return the fields of an estimate that must be equal on the device and on this computer."""
    return e.contact.sample, e.elapsed, e.value, e.low, e.high, e.out_of_range
