"""What a viewer asks for: checked, and as much of it as the link can bear."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import msgspec

from firstcontact.core import InputError, read_record
from firstcontact.device import marker_text
from firstcontact.streaming._hand_requests import Ask
from firstcontact.streaming._sink import Controls
from firstcontact.streaming.page._allowance import Allowance

#: Longest message of a viewer, bytes.
LONGEST = 4096
#: What one viewer may ask for: at once, and a second. Nobody's finger is faster.
EACH = 10, 5.0
#: What all viewers together may: a marker takes the device as long as 1 ms of samples.
ALL = 20, 10.0
#: The message of the page that opens the hand.
OPEN = b'{"do":"open"}'
#: The message of the page that says that it is there: no request, and without an answer.
HERE = '{"do":"here"}'


@dataclass(frozen=True, slots=True)
class Wish:
    """A viewer's message; ``text`` is a marker's, cut to what a device sets, or a shape."""

    do: Literal["record", "stop", "mark", "new", "shape", "close", "open"]
    text: Annotated[str, msgspec.Meta(max_length=1000)] = ""


class Commands:
    """Does what viewers ask for.

    Parameters
    ----------
    controls
        Of the session, None where viewers may only look.
    """

    def __init__(self, controls: Controls | None) -> None:
        self._controls = controls
        self._all = Allowance(*ALL)

    async def obey(
        self, message: str | bytes, own: Allowance, by: str
    ) -> tuple[dict[str, Any], float]:
        """Do what a message asks; whatever it is, there is an answer and nothing is raised.

        Parameters
        ----------
        message
            JSON of a :class:`Wish`.
        own
            What this viewer may still ask for.
        by
            Who this viewer is to the hand.

        Returns
        -------
        answer : dict
            ``ok``, what was asked for as ``do``, and ``text`` for the person.
        wait : float
            How long this viewer is not listened to, s: 0 unless it asked too much.
        """
        data = message.encode(errors="surrogatepass") if isinstance(message, str) else message
        wait = 0.0
        if data != OPEN:  # a hand is opened however much was asked before
            wait = own.take() or self._all.take()
        if wait:
            text = (
                f"That was not done: the page takes {EACH[1]:g} requests a second from a viewer "
                f"and {ALL[1]:g} from all."
            )
            return {"ok": False, "do": "", "text": text}, wait
        try:
            wish = read_record(data, Wish, "This message", "reload the page", LONGEST)
        except InputError as error:
            return {"ok": False, "do": "", "text": f"That was not understood. {error}."}, 0.0
        try:
            # A recorder opens files: that may take a while, and only this viewer waits.
            done = await asyncio.to_thread(self._do, wish, by)
        except InputError as error:
            return {"ok": False, "do": wish.do, "text": str(error)}, 0.0
        except Exception as error:  # a fault of the session is told, and stays there
            return {"ok": False, "do": wish.do, "text": f"That did not work ({error!r})."}, 0.0
        return {"ok": True, "do": wish.do, "text": done}, 0.0

    def gone(self, by: str) -> None:
        """A viewer is gone: what it had the hand close is opened."""
        if self._controls is not None:
            self._controls.hand_gone(by)

    def _do(self, wish: Wish, by: str) -> str:
        controls = self._controls
        if controls is None:
            raise InputError("This page may only look.")
        match wish.do:
            case "record":
                return f"Recording to {controls.start_recording().name}."
            case "stop":
                controls.stop_recording()
                return "Recording stopped."
            case "close" | "open":
                controls.ask_hand(Ask(wish.do), by)
                return "The hand is told to close." if wish.do == "close" else "The hand opens."
            case "new":
                controls.new_object()
                return "The next pinches are of a new object."
            case "shape":
                told = controls.tell_shape(wish.text)
                return f"Shape of what is pinched next: {told or 'not known'}."
            case "mark":
                word = marker_text(wish.text.strip()).decode().strip()
                if not word:
                    raise InputError("A marker needs a word.")
                controls.mark(word)
                return f"Marked “{word}”."
