"""Which pinches are of the same object, and what they say together."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from firstcontact.device import concerns_hand
from firstcontact.models import combine
from firstcontact.recording import Marker, PinchMark
from firstcontact.streaming._events import PinchDone, Running, SameObject

#: Words that wait for their pinch, and pinches of one object that count, at most.
WORDS, PINCHES = 16, 100


class Pinched:
    """Combines the standing answers of pinches as they come.

    Only pinches of which somebody says that they are of one object count together: from
    :meth:`anew` on, from a marker on that names an object, and where labels of a replayed
    recording name the same one. Another object begins where another is named, or with
    :meth:`anew`. A pinch of which nobody says anything stands by itself. Answers that are out of
    range do not count.
    """

    def __init__(self) -> None:
        self._answers: deque[Running] = deque(maxlen=PINCHES)
        self._words: deque[Marker] = deque(maxlen=WORDS)
        self._object: str | None = None  # "" is one without a name; None where nobody knows
        self._last: tuple[PinchDone, Running] | None = None
        self._new = False
        self._labelled = False  # some pinch was

    def anew(self) -> None:
        """The next pinch is of another object; may be called from any thread."""
        self._new = True

    def words(self, markers: Iterable[Marker]) -> None:
        """Markers came: each names the object of the next pinch."""
        self._words += [m for m in markers if not concerns_hand(m.text)]

    def done(self, done: PinchDone) -> SameObject | None:
        """A pinch is over: what all of this object say, None where it gave nothing to count."""
        if self._new:
            self._new = False
            self._answers.clear()
            self._object = ""
        while self._words and self._before(self._words[0], done):
            self._named(self._words.popleft().text)
        answer = done.standing
        if answer is None or answer.strange:
            return None
        if self._object is None:
            self._answers.clear()
        self._answers.append(answer)
        self._last = done, answer
        return self._combined(done)

    def labels(self, marks: Iterable[PinchMark]) -> SameObject | None:
        """A replayed recording tells what was pinched, after it was: what is right now."""
        if self._last is None:
            return None
        done, answer = self._last
        corrected = None
        for mark in filter(done.overlaps, marks):
            name = mark.label.specimen or mark.label.object or None
            if name is None and not self._labelled:
                continue  # words name objects here, or nobody does
            self._labelled = True
            if name is not None and name == self._object:
                continue
            self._object = name
            if len(self._answers) > 1:
                self._answers.clear()
                self._answers.append(answer)
                corrected = self._combined(done)
        return corrected

    @staticmethod
    def _before(marker: Marker, done: PinchDone) -> bool:
        return (marker.epoch, marker.sample) < (done.epoch, done.end)

    def _named(self, name: str) -> None:
        if name != self._object:
            self._answers.clear()
        self._object = name

    def _combined(self, done: PinchDone) -> SameObject:
        answers = self._answers
        found = combine([e.value for e in answers], [e.half_width for e in answers])
        return SameObject(
            number=done.number,
            value=found.value,
            low=found.low,
            high=found.high,
            level=answers[-1].level,
            pinches=found.pinches,
            told=self._object is not None,
            end=done.end,
            epoch=done.epoch,
        )
