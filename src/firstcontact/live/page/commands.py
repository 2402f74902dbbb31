"""What a viewer asks for."""

from __future__ import annotations

import asyncio
import json
from typing import Any

from firstcontact.core import InputError
from firstcontact.device.protocol import marker_text
from firstcontact.live.sink import Controls


async def obey(message: str | bytes, controls: Controls | None) -> dict[str, Any]:
    """Do what a message asks; whatever it is, there is an answer and nothing is raised.

    Parameters
    ----------
    message
        JSON: ``{"do": "record" | "stop" | "mark", "text": ...}``.
    controls
        Of the session, None where viewers may only look.

    Returns
    -------
    dict
        ``ok``, what was asked for as ``do``, and ``text`` for the person.
    """
    try:
        tree = json.loads(message)
        do, text = str(tree["do"]), str(tree.get("text", ""))
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return {"ok": False, "do": "", "text": "That was not understood."}
    try:
        # A recorder opens files: that may take a while, and only this viewer waits.
        done = await asyncio.to_thread(_do, do, text, controls)
    except InputError as error:
        return {"ok": False, "do": do, "text": str(error)}
    except Exception as error:  # a fault of the session is told, and stays there
        return {"ok": False, "do": do, "text": f"That did not work ({error!r})."}
    return {"ok": True, "do": do, "text": done}


def _do(do: str, text: str, controls: Controls | None) -> str:
    if controls is None:
        raise InputError("This page may only look.")
    if do == "record":
        return f"Recording to {controls.start_recording().name}."
    if do == "stop":
        controls.stop_recording()
        return "Recording stopped."
    if do == "mark" and text.strip():
        word = _word(text.strip())
        controls.mark(word)
        return f"Marked “{word}”."
    raise InputError("That was not understood.")


def _word(text: str) -> str:
    """What a device sets of a marker's text."""
    try:
        return marker_text(text).decode().strip()
    except UnicodeEncodeError as error:  # half a surrogate pair
        raise InputError(
            "This marker holds a character that cannot be sent: write it anew."
        ) from error
