"""The last pinches as rows of a table, and what was pinched in each, where somebody said."""

from __future__ import annotations

from collections import deque
from typing import Any

from firstcontact.device import concerns_hand, lost_object
from firstcontact.recording import Marker, PinchMark
from firstcontact.streaming._events import Estimated, HandPinch, PinchDone, Running
from firstcontact.streaming._spoken import spoken
from firstcontact.streaming._text import hand_line
from firstcontact.streaming.page._closeup import finger_place

#: Rows that are held.
ROWS = 12


def timing(estimate: Estimated | Running, rate: float) -> dict[str, float]:
    """From contact to estimate in its parts, ms.

    The window and the wait for the end of the block that completed it are counted in
    the device's samples, the transport and the computation by the host's clock.
    """
    until = 1e3 * ((estimate.complete - estimate.contact.sample) / rate + estimate.waited)
    window = min(1e3 * estimate.duration, until)
    return {
        "window": round(window, 3),
        "wait": round(until - window, 3),
        "transport": round(1e3 * estimate.transport, 3),
        "compute": round(1e3 * estimate.compute, 3),
        "total": round(1e3 * estimate.after(rate), 3),
    }


def hand_timing(event: HandPinch, rate: float) -> dict[str, float] | None:
    """The same on a device that answers by itself: no cable, no wait for packets."""
    stands = event.standing
    if stands is None:
        return None
    return {
        "signal": round(1e3 * (stands.decided - stands.contact) / rate, 3),
        "compute": round(1e3 * stands.compute_time, 3),
        "total": round(1e3 * stands.after(rate), 3),
    }


def verdict(done: PinchDone) -> dict[str, Any]:
    """Verdict on a pinch: its case, both times in ms, and an estimate that came too late to count.

    Both times are rounded alike, so that what is in time also reads so.
    """
    shown, final = shown_estimate(done), done.final
    later = None
    if final is not None and final is not shown:
        later = {**value(final), "ms": timing(final, done.rate)["total"]}
    return {
        "case": None if done.case is None else done.case.name,
        "ms": timing(shown, done.rate)["total"] if shown and done.real_time else None,
        "offset": None if done.offset is None else round(1e3 * done.offset, 3),
        "later": later,
    }


def shown_estimate(done: PinchDone) -> Running | Estimated | None:
    """The estimate available at the second contact, or the last one where the time means nothing.

    None where no estimate was in time.
    """
    return done.final if done.case is None else done.available


def value(estimate: Estimated | Running) -> dict[str, float]:
    """An estimate and its interval."""
    return {
        "value": round(estimate.value, 2),
        "low": round(estimate.low, 2),
        "high": round(estimate.high, 2),
        "level": estimate.level,
    }


class Pinches:
    """Rows of the last pinches, the newest last.

    Parameters
    ----------
    rate
        Of the samples, Hz.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._rows: deque[tuple[PinchDone, dict[str, Any]]] = deque(maxlen=ROWS)
        self._words: deque[Marker] = deque(maxlen=ROWS)
        self._lost: deque[Marker] = deque(maxlen=ROWS)

    def word(self, marker: Marker) -> None:
        """A marker came: it names the pinch it lies in, or the next, or says what became of it."""
        if lost_object(marker.text):
            self._lost.append(marker)
        if concerns_hand(marker.text):
            return
        self._words.append(marker)
        for done, row in self._rows:
            if done.holds(marker.epoch, marker.sample):
                row["object"] = marker.text

    def label(self, mark: PinchMark) -> None:
        """A replayed recording says what was pinched."""
        for done, row in self._rows:
            if mark.label.object and done.overlaps(mark):
                row["object"] = mark.label.object

    def done(self, done: PinchDone) -> None:
        """A pinch is over: one more row."""
        estimate = shown_estimate(done)
        first = done.contacts[0] if done.contacts else None
        row = {
            "number": done.number,
            "object": spoken(self._words, done, self._rows[-1][0] if self._rows else None),
            "finger": None if first is None else finger_place(first.finger),
            "estimate": None if estimate is None else value(estimate),
            **verdict(done),
            "strange": isinstance(estimate, Running) and estimate.strange,
            "refused": done.refused,
            "hand": "",
        }
        self._rows.append((done, row))

    def hand(self, pinch: HandPinch) -> None:
        """A device that answers by itself told this of a pinch."""
        if pinch.first is None:
            return
        for done, row in self._rows:
            if done.holds(pinch.first.epoch, pinch.first.sample):
                row["hand"] = hand_line(pinch, self._rate).strip()

    def tree(self) -> list[dict[str, Any]]:
        """The rows; of each what the twin says it has dropped or broken, None where nothing."""
        told = []
        since: PinchDone | None = None  # the next pinch: what comes after its begin is of it
        for done, row in reversed(self._rows):
            its = (m for m in self._lost if _of(m, done, since))
            told.append(row | {"lost": next((lost_object(m.text) for m in its), None)})
            since = done
        return told[::-1]


def _of(marker: Marker, done: PinchDone, following: PinchDone | None) -> bool:
    """Whether a marker came after a pinch had begun, and before the next one had."""
    place = (marker.epoch, marker.sample)
    if place < (done.epoch, done.armed) or marker.epoch != done.epoch:
        return False
    return following is None or place < (following.epoch, following.armed)
