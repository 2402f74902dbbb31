"""What a pinch was of, as a marker or the label of a replayed recording says it."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable

from firstcontact.device import concerns_hand, held_object
from firstcontact.recording import Marker, PinchMark
from firstcontact.streaming._events import PinchDone

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

    def labels(self, marks: Iterable[PinchMark]) -> list[tuple[int, str]]:
        """A replayed recording told of pinches: numbers and words of those that are over."""
        self._marks += [m for m in marks if m.label.object]
        found = [(done, label) for done in self._unnamed if (label := self._labelled(done))]
        for done, _ in found:
            self._unnamed.remove(done)
        return [(done.number, label) for done, label in found]

    def of(self, done: PinchDone) -> str:
        """Of a pinch that is over; "" where nobody has told by now."""
        word = spoken(self._words, done, self._before)
        self._before = done
        if word:
            held = held_object(word)
            return f'marked "{word}"' if held is None else word + _shore(self._shore_a(held))
        label = self._labelled(done)
        if not label:
            self._unnamed.append(done)
        return label

    def _labelled(self, done: PinchDone) -> str:
        label = next((m.label for m in self._marks if done.overlaps(m)), None)
        return "" if label is None else f"labelled {label.object}{_shore(label.shore_a)}"


def _shore(shore_a: float | None) -> str:
    return "" if shore_a is None else f", {shore_a:g} Shore A"
