"""How the answer of an any-time model narrows after a contact, for the page."""

from __future__ import annotations

from typing import Any

from firstcontact.models import in_words
from firstcontact.streaming._events import Estimated, PinchDone, Running, SameObject, Settled
from firstcontact.streaming.page._closeup import finger_place
from firstcontact.streaming.page._pinches import shown_estimate, timing, value, verdict


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
                return self._shown(event, now)
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
                return self._shown(event.answer, now)
            case SameObject():
                same = {"value": event.value, "low": event.low, "high": event.high}
                rounded: dict[str, Any] = {k: round(v, 2) for k, v in same.items()}
                return {**now, "same": {**rounded, "pinches": event.pinches, "told": event.told}}

    def done(self, done: PinchDone, now: dict[str, Any]) -> dict[str, Any]:
        """What is shown once the pinch is judged: what was in time, or else what came last."""
        shown = shown_estimate(done) or done.final
        if shown is None or "estimate" not in now:
            return now
        if isinstance(shown, Running):
            now = self._shown(shown, now)
        else:
            now = {**now, **estimate_tree(shown, self._rate)}
        return {**now, **verdict(done), "judged": True}

    def _shown(self, answer: Running, now: dict[str, Any]) -> dict[str, Any]:
        return {
            **now,
            **estimate_tree(answer, self._rate),
            "contact": answer.contact.sample,
            "strange": answer.strange,
            "told": in_words(answer.radius),
            "heard": round(1e3 * answer.duration, 2),
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


def estimate_tree(estimate: Running | Estimated, rate: float) -> dict[str, Any]:
    """An estimate, where its time went, and what is not known of it before the pinch is over."""
    return {
        "estimate": value(estimate),
        "finger": finger_place(estimate.contact.finger),
        "timing": timing(estimate, rate),
        "judged": False,
        "later": None,
    }
