"""What a pinch was of, as a marker or the label of a replayed recording says it."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable

from firstcontact.core import Label
from firstcontact.device.twin_words import concerns_hand, held_object
from firstcontact.live.events import PinchDone
from firstcontact.recording import Marker, PinchMark

#: Words and pinches that are kept, at most.
KEPT = 16


def spoken(words: Iterable[Marker], done: PinchDone, before: PinchDone | None) -> str:
    """The last marker since the pinch before this one, "" without one."""
    since = before.end if before is not None and before.epoch == done.epoch else 0
    its = [m.text for m in words if m.epoch == done.epoch and since <= m.sample < done.end]
    return its[-1] if its else ""


class Objects:
    """Names what was pinched, in the words of whoever told it.

    Parameters
    ----------
    shore_a
        Of an object of the twin by its name, None where it is not known.
    """

    def __init__(self, shore_a: Callable[[str], float | None]) -> None:
        self._shore_a = shore_a
        self._words: deque[Marker] = deque(maxlen=KEPT)
        self._marks: deque[PinchMark] = deque(maxlen=KEPT)
        self._before: PinchDone | None = None
        self._unnamed: deque[PinchDone] = deque(maxlen=KEPT)

    def words(self, markers: Iterable[Marker]) -> None:
        """Markers came."""
        self._words += [m for m in markers if not concerns_hand(m.text)]

    def labels(self, marks: Iterable[PinchMark]) -> None:
        """A replayed recording told of pinches."""
        self._marks += [m for m in marks if m.label.object]

    def of(self, done: PinchDone) -> str:
        """Of a pinch that is over; "" where nobody has told by now."""
        word = spoken(self._words, done, self._before)
        self._before = done
        if word:
            held = held_object(word)
            return f'marked "{word}"' if held is None else word + _shore(self._shore_a(held))
        mark = next((m for m in self._marks if _overlap(m, done)), None)
        if mark is None:
            self._unnamed.append(done)
            return ""
        return _label(mark.label)

    def later(self) -> list[tuple[int, str]]:
        """Numbers of pinches that are told of only now, and what they were."""
        found = []
        for done in list(self._unnamed):
            mark = next((m for m in self._marks if _overlap(m, done)), None)
            if mark is not None:
                self._unnamed.remove(done)
                found.append((done.number, _label(mark.label)))
        return found


def _overlap(mark: PinchMark, done: PinchDone) -> bool:
    return mark.epoch == done.epoch and mark.first_sample < done.end and done.armed < mark.end


def _label(label: Label) -> str:
    return f"labelled {label.object}{_shore(label.shore_a)}"


def _shore(shore_a: float | None) -> str:
    return "" if shore_a is None else f", {shore_a:g} Shore A"
