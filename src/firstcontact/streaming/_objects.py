"""Names of the pinched objects, and averages of the estimates for each object."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from firstcontact.core import Estimate, Label
from firstcontact.core.records import LONGEST_NAME
from firstcontact.device.twin_words import concerns_hand, parse_held_object
from firstcontact.models.predictions import combine
from firstcontact.recording import Marker, PinchMark
from firstcontact.streaming.events import ObjectEstimate, PinchDone

#: Largest number of stored markers, labels and pinches, and of combined pinches of one object.
WAITING, PINCHES = 16, 100


class ObjectNames:
    """Collector of the objects' names, from markers and from the labels of a replayed recording."""

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
        """Return the texts of the markers between the end of the previous pinch and of this one.

        Markers of the twin are left out if a user has sent markers, too.
        """
        end = pinch.epoch, pinch.end
        since = max((e for p in self._pinches if (e := (p.epoch, p.end)) < end), default=(0, 0))
        texts = [m.text for m in self._markers if since <= (m.epoch, m.sample) < end]
        return [text for text in texts if parse_held_object(text) is None] or texts

    def label(self, pinch: PinchDone) -> Label | None:
        return next((m.label for m in reversed(self._marks) if pinch.overlaps(m)), None)


class ObjectCombiner(ObjectNames):
    """Collector that averages the final estimates over all pinches of the same object."""

    def __init__(self) -> None:
        super().__init__()
        self._estimates: deque[Estimate] = deque(maxlen=PINCHES)
        self._object: str | None = None  # "" for an object without a name; None if unmarked
        self._is_new = self._has_labels = False

    def new_object(self) -> None:
        """Treat the next pinch as the first one of a new object. Any thread may call this."""
        self._is_new = True

    @property
    def name(self) -> str:
        """Name of the object of the last pinch; "" if the object has no name."""
        text = self._object or ""
        return (parse_held_object(text) or text)[:LONGEST_NAME]

    def pool(self, pinch: PinchDone) -> ObjectEstimate | None:
        """Add a finished pinch. Return the average over all pinches of its object so far.

        Return None if the pinch has no estimate that can be averaged.
        """
        self.add_pinch(pinch)
        if self._is_new:
            self._is_new = False
            self._estimates.clear()
            self._object = ""
        label = self.label(pinch)
        name = "" if label is None else label.specimen or label.object
        self._has_labels |= bool(name)
        for text in [name] if self._has_labels else self.markers(pinch):
            if text != self._object:
                self._estimates.clear()
            self._object = text or None
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
