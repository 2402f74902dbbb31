"""How the answer of an any-time model narrows after a contact, for the page."""

from __future__ import annotations

from typing import Any

from firstcontact.anytime.told_shape import in_words
from firstcontact.live.events import Case, PinchDone, Running, SameObject, Settled
from firstcontact.live.page._closeup import finger_place
from firstcontact.live.page._pinches import timing, value


class Narrowing:
    """The answers of the closing that goes on, as the page draws them.

    Parameters
    ----------
    rate
        Of the samples, Hz.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._answers: list[Running] = []

    @property
    def begun(self) -> bool:
        """Whether there was an answer in this closing."""
        return bool(self._answers)

    def begin(self) -> None:
        """A first contact."""
        self._answers = []

    def happened(
        self, event: Running | Settled | SameObject, now: dict[str, Any]
    ) -> dict[str, Any]:
        """What is shown now, with this in it."""
        match event:
            case Running():
                self._answers.append(event)
                return self._shown(event, {**now, "settled": False})
            case Settled() if event.answer is None and "estimate" in now and not self.begun:
                return now  # a model of a fixed window has an answer
            case Settled() if event.answer is None:
                self._answers = []
                kept = {k: v for k, v in now.items() if k in ("finger", "second", "same")}
                return {**kept, "refused": event.reason}
            case Settled():
                assert event.answer is not None
                stands = event.answer.samples
                self._answers = [e for e in self._answers if e.samples <= stands]
                return self._shown(event.answer, {**now, "settled": True})
            case SameObject():
                same = {"value": event.value, "low": event.low, "high": event.high}
                rounded: dict[str, Any] = {k: round(v, 2) for k, v in same.items()}
                return {**now, "same": {**rounded, "pinches": event.pinches, "told": event.told}}

    def done(self, done: PinchDone, now: dict[str, Any]) -> dict[str, Any]:
        """In hindsight: whether an answer was out before the second contact happened."""
        case = Case.IN_TIME if done.out else Case.TOO_LATE
        return {**now, "case": case.name, "settled": True}

    def _shown(self, answer: Running, now: dict[str, Any]) -> dict[str, Any]:
        return {
            **now,
            "estimate": value(answer),
            "finger": finger_place(answer.contact.finger),
            "timing": timing(answer, self._rate),
            "contact": answer.contact.sample,
            "strange": answer.strange,
            "told": in_words(answer.radius),
            "used": True,
            "case": Case.IN_TIME.name,
            "answers": [
                {
                    "ms": round(1e3 * e.duration, 2),
                    "value": round(e.value, 2),
                    "low": round(e.low, 2),
                    "high": round(e.high, 2),
                    "strange": e.strange,
                }
                for e in self._answers
            ],
        }
