"""What a device answers when it is asked who it is."""

from __future__ import annotations

from dataclasses import dataclass

from firstcontact.core import InputError
from firstcontact.device._protocol import VERSION, read_descriptor
from firstcontact.device._source import Descriptor


@dataclass(frozen=True, slots=True)
class Greeting:
    """A device that can be used: which start of it, and what it says about itself."""

    boot: int
    descriptor: Descriptor


def read_greeting(payload: bytes) -> Greeting:
    """Take a descriptor frame's payload apart.

    Raises
    ------
    FrameError
        It is damaged.
    InputError
        The device speaks another version, or its descriptor cannot be used.
    """
    version, boot, text = read_descriptor(payload)
    if version != VERSION:
        raise InputError(_other(version))
    return Greeting(boot, Descriptor.from_text(text))


def refusal(payload: bytes) -> InputError:
    """What a ``refused`` frame comes to."""
    if payload and payload[0] != VERSION:
        return InputError(_other(payload[0]))
    why = payload[1:].decode(errors="replace")
    return InputError(
        f"the device refuses ({why}): flash the firmware that belongs to this version of "
        "firstcontact"
    )


def _other(version: int) -> str:
    return (
        f"the device speaks version {version} of the protocol and this program version {VERSION}: "
        "flash the firmware that belongs to this version of firstcontact"
    )
