"""Validation, rate limit and execution of viewers' requests."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import msgspec

from firstcontact.core import InputError, read_record
from firstcontact.device import marker_text
from firstcontact.streaming._hand_requests import Ask
from firstcontact.streaming._sink import Controls

#: Longest message of a viewer, bytes.
LONGEST = 4096
#: Largest number of requests of one viewer, at once and per second. No person is faster.
EACH = 10, 5.0
#: Largest number of requests of all viewers. A marker takes the device as long as 1 ms of samples.
ALL = 20, 10.0
#: Message of the page that opens the hand.
OPEN = b'{"do":"open"}'
#: Message that shows that the page is alive. It is no request and gets no reply.
HERE = '{"do":"here"}'


@dataclass(frozen=True, slots=True)
class Request:
    """Message of a viewer; ``text`` is a marker or a shape."""

    do: Literal["record", "stop", "mark", "new", "shape", "close", "open"]
    text: Annotated[str, msgspec.Meta(max_length=1000)] = ""


class Allowance:
    """Token bucket that limits requests."""

    def __init__(
        self, burst: int, refill: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._most = float(burst)
        self._refill = refill
        self._clock = clock
        self._left = self._most
        self._seen = clock()

    def take(self) -> float:
        """Allow one request and return 0.0, or return the time until the next is allowed, s."""
        now = self._clock()
        self._left = min(self._most, self._left + (now - self._seen) * self._refill)
        self._seen = now
        if self._left < 1.0:
            return (1.0 - self._left) / self._refill
        self._left -= 1.0
        return 0.0


class Commands:
    """Handler of viewers' requests."""

    def __init__(self, controls: Controls | None) -> None:
        self._controls = controls
        self._all = Allowance(*ALL)

    async def obey(
        self, message: str | bytes, allowance: Allowance, by: str
    ) -> tuple[dict[str, Any], float]:
        """Carry out a viewer's message and return a reply, also about errors."""
        data = message.encode(errors="surrogatepass") if isinstance(message, str) else message
        wait = 0.0
        if data != OPEN:  # opening a hand has no limit
            wait = allowance.take() or self._all.take()
        if wait:
            text = (
                f"That was not done: the page takes {EACH[1]:g} requests a second from a viewer "
                f"and {ALL[1]:g} from all."
            )
            return {"ok": False, "do": "", "text": text}, wait
        try:
            request = read_record(data, Request, "This message", "reload the page", LONGEST)
        except InputError as error:
            return {"ok": False, "do": "", "text": f"That was not understood. {error}."}, 0.0
        try:
            # A recorder opens files: that may take a while, and only this viewer waits.
            outcome = await asyncio.to_thread(self._do, request, by)
        except InputError as error:
            return {"ok": False, "do": request.do, "text": str(error)}, 0.0
        except Exception as error:  # a fault of the session is reported and stays there
            return {"ok": False, "do": request.do, "text": f"That did not work ({error!r})."}, 0.0
        return {"ok": True, "do": request.do, "text": outcome}, 0.0

    def gone(self, by: str) -> None:
        """Open the hand if the viewer ``by``, now disconnected, had closed it."""
        if self._controls is not None:
            self._controls.hand_gone(by)

    def _do(self, request: Request, by: str) -> str:
        controls = self._controls
        if controls is None:
            raise InputError("This page only shows the session and cannot control it.")
        match request.do:
            case "record":
                return f"Recording to {controls.start_recording().name}."
            case "stop":
                controls.stop_recording()
                return "Recording stopped."
            case "close" | "open":
                controls.ask_hand(Ask(request.do), by)
                return "The hand closes." if request.do == "close" else "The hand opens."
            case "new":
                controls.new_object()
                return "New object: its pinches are combined."
            case "shape":
                shape = controls.set_shape(request.text)
                return f"Shape of the next objects: {shape or 'unknown'}."
            case "mark":
                word = marker_text(request.text.strip()).decode().strip()
                if not word:
                    raise InputError("The marker's text is empty: type at least one word.")
                controls.mark(word)
                return f"Marked “{word}”."
