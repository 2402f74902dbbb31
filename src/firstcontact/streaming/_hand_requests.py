"""Requests of people and programs to a driven hand, from any thread."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from threading import Lock

from firstcontact.core import InputError
from firstcontact.grasp import Begins


class Ask(StrEnum):
    """Request to a hand."""

    CLOSE = "close"
    OPEN = "open"


@dataclass(frozen=True, slots=True)
class Request:
    """Request and its origin ``by``. ``ask`` is None if the origin has disconnected."""

    ask: Ask | None
    by: str


class HandRequests:
    """Queue of requests from any thread; the session's own thread carries them out."""

    def __init__(self, name: str, begins: Begins, release: Callable[[], None]) -> None:
        self.by: str | None = None
        self.opening = False
        self._name, self._begins, self._release = name, begins, release
        self._waiting: deque[Request] = deque()
        self._gone: set[str] = set()
        self._lock = Lock()  # of opening, _waiting and _gone
        self._over = False

    @property
    def allowed(self) -> tuple[Ask, ...]:
        """Possible requests to this hand."""
        return tuple(Ask) if self._begins & (Begins.US | Begins.HURRY) else (Ask.OPEN,)

    def ask(self, ask: Ask, by: str) -> None:
        """Add a request."""
        if self._over:
            raise InputError("The session has ended: start it again")
        if ask is Ask.OPEN:
            self._open(Request(ask, by))
            return
        if ask not in self.allowed:
            raise InputError(
                f"The hand {self._name!r} closes by itself, so it takes no requests to close: "
                "request only to open it"
            )
        if self.by is not None and not self.opening:
            raise InputError("The hand is closed already: open it first")
        with self._lock:
            if by not in self._gone:
                self._waiting.append(Request(ask, by))

    def gone(self, by: str) -> None:
        """Open the hand if the origin ``by``, now disconnected, had closed it."""
        with self._lock:
            self._gone.add(by)
            if self.by != by:
                self._waiting.append(Request(None, by))
                return
        self._open(Request(None, by))

    def end(self) -> None:
        """Accept no more requests."""
        self._over = True

    def take(self) -> Request | None:
        """Return the next request, in the session's thread; None if none waits."""
        with self._lock:
            self.opening = any(self.opens(request) for request in self._waiting)
            return self._waiting.popleft() if self._waiting else None

    def opens(self, request: Request) -> bool:
        """Return True if a request opens the hand."""
        return request.ask is Ask.OPEN or (request.ask is None and request.by == self.by)

    def _open(self, request: Request) -> None:
        with self._lock:
            self.opening = True
            self._waiting.append(request)
        self._release()
