"""Parsing of a device's answer to the handshake."""

from __future__ import annotations

from dataclasses import dataclass

from firstcontact.core import InputError
from firstcontact.device._protocol import VERSION, read_descriptor
from firstcontact.device._source import Descriptor


@dataclass(frozen=True, slots=True)
class Greeting:
    """Boot number and descriptor of a usable device."""

    boot: int
    descriptor: Descriptor


def read_greeting(payload: bytes) -> Greeting:
    """Parse the payload of a descriptor frame."""
    version, boot, text = read_descriptor(payload)
    if version != VERSION:
        raise InputError(_version_mismatch(version))
    return Greeting(boot, Descriptor.from_text(text))


def refusal(payload: bytes) -> InputError:
    """Return the error for a ``refused`` frame."""
    if payload and payload[0] != VERSION:
        return InputError(_version_mismatch(payload[0]))
    reason = payload[1:].decode(errors="replace")
    return InputError(
        f"the device refuses the connection ({reason}): flash the firmware that belongs to this "
        "version of firstcontact"
    )


def _version_mismatch(version: int) -> str:
    return (
        f"the device speaks version {version} of the protocol and this program version {VERSION}: "
        "flash the firmware that belongs to this version of firstcontact"
    )
