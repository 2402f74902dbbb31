"""What people and programs ask of a hand while it is driven, from any thread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from queue import Empty, SimpleQueue
from threading import Lock

from firstcontact.core import InputError
from firstcontact.grasp import Begins


class Ask(StrEnum):
    """What may be asked of a hand."""

    CLOSE = "close"
    OPEN = "open"


@dataclass(frozen=True, slots=True)
class Request:
    """What was asked, and by whom; ``ask`` is None where that one is gone."""

    ask: Ask | None
    by: str


class HandRequests:
    """Takes requests from any thread; the session's own thread obeys.

    To open does not wait for that: the hand is released at once, and nothing is sent to it until
    the session's thread has taken notice.

    Parameters
    ----------
    name
        Of the hand.
    begins
        Who begins its closings.
    release
        Releases it; safe to call from any thread.

    Attributes
    ----------
    by
        Who asked for the closing that is going on, or that it holds; None where nobody did. Set
        by the session's thread.
    opening
        Whether it was asked to open and the session's thread has not obeyed yet.
    """

    def __init__(self, name: str, begins: Begins, release: Callable[[], None]) -> None:
        self.by: str | None = None
        self.opening = False
        self._name, self._begins, self._release = name, begins, release
        self._waiting: SimpleQueue[Request] = SimpleQueue()
        self._gone: set[str] = set()
        self._lock = Lock()  # nobody asks who is gone
        self._over = False

    @property
    def allowed(self) -> tuple[Ask, ...]:
        """What this hand can be asked."""
        return tuple(Ask) if Begins.US in self._begins else (Ask.OPEN,)

    def ask(self, ask: Ask, by: str) -> None:
        """Ask the hand for something.

        Raises
        ------
        InputError
            It cannot be asked for that, or not now.
        """
        if self._over:
            raise InputError("The hand is driven no more: start again")
        if ask is Ask.OPEN:
            self._open(Request(ask, by))
            return
        if ask not in self.allowed:
            raise InputError(
                f"The hand {self._name!r} begins its closings by itself: it can only be asked to "
                "open"
            )
        if self.by is not None and not self.opening:
            raise InputError("The hand is closed already: open it first")
        with self._lock:
            if by not in self._gone:
                self._waiting.put(Request(ask, by))

    def gone(self, by: str) -> None:
        """Somebody can ask no more: what they had closed is opened."""
        with self._lock:
            self._gone.add(by)
            if self.by != by:
                self._waiting.put(Request(None, by))
                return
        self._open(Request(None, by))

    def end(self) -> None:
        """Take no more."""
        self._over = True

    def take(self) -> Request | None:
        """The next request, in the session's thread; None where none waits."""
        try:
            return self._waiting.get_nowait()
        except Empty:
            return None

    def _open(self, request: Request) -> None:
        self.opening = True
        self._waiting.put(request)
        self._release()
