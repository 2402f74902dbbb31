"""Names of the pinched objects, and pooled estimates from several pinches of one object."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable

from firstcontact.core import Estimate
from firstcontact.device import concerns_hand, held_object
from firstcontact.models import combine
from firstcontact.recording import Marker, PinchMark
from firstcontact.streaming._events import ObjectEstimate, PinchDone

#: Largest number of markers that wait for their pinch, and of combined pinches of one object.
WAITING, PINCHES = 16, 100


class ObjectCombiner:
    """Pool of the final estimates of several pinches of one object.

    Pinches are pooled only if they are marked as one object: by :meth:`new_object`, by a marker
    with an object's name, or by the labels of a replayed recording. A new name, or
    :meth:`new_object`, begins another object. An unmarked pinch is not pooled with others. Pinches
    whose final estimate is out of range are left out.
    """

    def __init__(self) -> None:
        self._estimates: deque[Estimate] = deque(maxlen=PINCHES)
        self._markers: deque[Marker] = deque(maxlen=WAITING)
        self._object: str | None = None  # "" for an object without a name; None if unmarked
        self._last: tuple[PinchDone, Estimate] | None = None
        self._is_new = False
        self._has_labels = False

    def new_object(self) -> None:
        """Begin another object with the next pinch; may be called from any thread."""
        self._is_new = True

    def add_markers(self, markers: Iterable[Marker]) -> None:
        """Process markers. A marker names the object of the next pinch."""
        self._markers += [m for m in markers if not concerns_hand(m.text)]

    def add_pinch(self, pinch: PinchDone) -> ObjectEstimate | None:
        """Add a finished pinch. Return its object's estimate; None if the pinch is left out."""
        if self._is_new:
            self._is_new = False
            self._estimates.clear()
            self._object = ""
        while self._markers and self._precedes(self._markers[0], pinch):
            self._name(self._markers.popleft().text)
        final = pinch.final
        if final is None or final.out_of_range or final.half_width is None:
            return None
        if self._object is None:
            self._estimates.clear()
        self._estimates.append(final)
        self._last = pinch, final
        return self._combined(pinch)

    def add_labels(self, marks: Iterable[PinchMark]) -> ObjectEstimate | None:
        """Process labels of past pinches in a replayed recording.

        If a label shows that the last pinch was of another object than those before it, return the
        estimate from the last pinch alone.
        """
        if self._last is None:
            return None
        pinch, final = self._last
        corrected = None
        for mark in filter(pinch.overlaps, marks):
            name = mark.label.specimen or mark.label.object or None
            if name is None and not self._has_labels:
                continue  # markers name the objects here, or nothing does
            self._has_labels = True
            if name is not None and name == self._object:
                continue
            self._object = name
            if len(self._estimates) > 1:
                self._estimates.clear()
                self._estimates.append(final)
                corrected = self._combined(pinch)
        return corrected

    @staticmethod
    def _precedes(marker: Marker, pinch: PinchDone) -> bool:
        return (marker.epoch, marker.sample) < (pinch.epoch, pinch.end)

    def _name(self, name: str) -> None:
        if name != self._object:
            self._estimates.clear()
        self._object = name

    def _combined(self, pinch: PinchDone) -> ObjectEstimate:
        estimates = self._estimates
        combined = combine([e.value for e in estimates], [e.half_width or 0.0 for e in estimates])
        return ObjectEstimate(
            number=pinch.number,
            value=combined.value,
            low=combined.low,
            high=combined.high,
            level=estimates[-1].level,
            pinches=combined.pinches,
            is_named=self._object is not None,
            end=pinch.end,
            epoch=pinch.epoch,
        )


def last_marker(markers: Iterable[Marker], pinch: PinchDone, previous: PinchDone | None) -> str:
    """Return the text of the last marker since the previous pinch, "" if there is none."""
    since = previous.end if previous is not None and previous.epoch == pinch.epoch else 0
    texts = [m.text for m in markers if m.epoch == pinch.epoch and since <= m.sample < pinch.end]
    return texts[-1] if texts else ""


class ObjectNames:
    """Names of the pinched objects, from markers and from the labels of a replayed recording.

    Parameters
    ----------
    shore_a
        Function that returns the Shore A of an object of the twin by its name, None if unknown.
    """

    def __init__(self, shore_a: Callable[[str], float | None]) -> None:
        self._shore_a = shore_a
        self._markers: deque[Marker] = deque(maxlen=WAITING)
        self._marks: deque[PinchMark] = deque(maxlen=WAITING)
        self._before: PinchDone | None = None
        self._unnamed: deque[PinchDone] = deque(maxlen=WAITING)

    def add_markers(self, markers: Iterable[Marker]) -> None:
        """Process markers."""
        self._markers += [m for m in markers if not concerns_hand(m.text)]

    def add_labels(self, marks: Iterable[PinchMark]) -> list[tuple[int, str]]:
        """Process labels of a recording.

        Return number and object name of each past pinch that a label belongs to.
        """
        self._marks += [m for m in marks if m.label.object]
        named = [(pinch, label) for pinch in self._unnamed if (label := self._label(pinch))]
        for pinch, _ in named:
            self._unnamed.remove(pinch)
        return [(pinch.number, label) for pinch, label in named]

    def object_name(self, pinch: PinchDone) -> str:
        """Return the name of the object of a finished pinch; "" if it has none yet."""
        text = last_marker(self._markers, pinch, self._before)
        self._before = pinch
        if text:
            object_ = held_object(text)
            return f'marked "{text}"' if object_ is None else text + _shore(self._shore_a(object_))
        label = self._label(pinch)
        if not label:
            self._unnamed.append(pinch)
        return label

    def _label(self, pinch: PinchDone) -> str:
        label = next((m.label for m in self._marks if pinch.overlaps(m)), None)
        return "" if label is None else f"labelled {label.object}{_shore(label.shore_a)}"


def _shore(shore_a: float | None) -> str:
    return "" if shore_a is None else f", {shore_a:g} Shore A"
