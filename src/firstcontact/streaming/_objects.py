"""Names of the pinched objects, and pooled estimates from several pinches of one object."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence

from firstcontact.core import Estimate, Label
from firstcontact.device.twin_words import concerns_hand
from firstcontact.models.predictions import combine
from firstcontact.recording import Marker, PinchMark
from firstcontact.streaming.events import ObjectEstimate, PinchDone

#: Largest number of stored markers, labels and pinches, and of combined pinches of one object.
WAITING, PINCHES = 16, 100


class ObjectNames:
    """Names of the pinched objects, from markers and from the labels of a replayed recording."""

    def __init__(self) -> None:
        self._markers: deque[Marker] = deque(maxlen=WAITING)
        self._marks: deque[PinchMark] = deque(maxlen=WAITING)
        self._pinches: deque[PinchDone] = deque(maxlen=WAITING)

    def add_markers(self, markers: Iterable[Marker]) -> None:
        self._markers += [m for m in markers if not concerns_hand(m.text)]

    def add_labels(self, marks: Iterable[PinchMark]) -> None:
        self._marks += marks

    def add_pinch(self, pinch: PinchDone) -> None:
        self._pinches.append(pinch)

    def markers(self, pinch: PinchDone) -> list[str]:
        """Return the texts of the markers from the end of the previous pinch to that of a pinch."""
        end = pinch.epoch, pinch.end
        since = max((e for p in self._pinches if (e := (p.epoch, p.end)) < end), default=(0, 0))
        return [m.text for m in self._markers if since <= (m.epoch, m.sample) < end]

    def label(self, pinch: PinchDone) -> Label | None:
        return next((m.label for m in reversed(self._marks) if pinch.overlaps(m)), None)


class ObjectCombiner:
    """Pool of the final estimates of several pinches of one object."""

    def __init__(self) -> None:
        self._names = ObjectNames()
        self._estimates: deque[Estimate] = deque(maxlen=PINCHES)
        self._object: str | None = None  # "" for an object without a name; None if unmarked
        self._last: PinchDone | None = None
        self._is_new = False
        self._has_labels = False
        self._waits = False  # True while the last pinch waits for its label

    def new_object(self) -> None:
        """Begin another object with the next pinch; may be called from any thread."""
        self._is_new = True

    def add_markers(self, markers: Iterable[Marker]) -> None:
        self._names.add_markers(markers)

    def add_pinch(self, pinch: PinchDone) -> ObjectEstimate | None:
        self._names.add_pinch(pinch)
        self._last = pinch
        self._waits = self._has_labels and self._names.label(pinch) is None
        if self._is_new:
            self._is_new = False
            self._estimates.clear()
            self._object = ""
        if self._waits:
            return None
        for text in () if self._has_labels else self._names.markers(pinch):
            self._rename(text)
        self._relabel(pinch)
        return self._pool(pinch)

    def add_labels(self, marks: Sequence[PinchMark]) -> ObjectEstimate | None:
        """Process labels of pinches in a replayed recording."""
        self._names.add_labels(marks)
        if not marks or self._last is None:
            return None
        was_alone = len(self._estimates) == 1
        is_other = self._relabel(self._last)
        if self._waits:
            if self._names.label(self._last) is None:
                return None
            self._waits = False
            return self._pool(self._last)
        if not is_other:
            return None
        estimate = self._pool(self._last)
        return None if was_alone else estimate

    def _relabel(self, pinch: PinchDone) -> bool:
        """Name the object by the label of a pinch. Return True if that begins another object."""
        label = self._names.label(pinch)
        name = None if label is None else label.specimen or label.object or None
        if label is None or (name is None and not self._has_labels):
            return False  # markers name the objects here, or nothing does
        self._has_labels = True
        return self._rename(name)

    def _rename(self, name: str | None) -> bool:
        is_other = name is None or name != self._object
        if is_other:
            self._estimates.clear()
        self._object = name
        return is_other

    def _pool(self, pinch: PinchDone) -> ObjectEstimate | None:
        if self._object is None:
            self._estimates.clear()
        final = pinch.final
        if final is None or final.out_of_range or final.half_width is None:
            return None
        self._estimates.append(final)
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
