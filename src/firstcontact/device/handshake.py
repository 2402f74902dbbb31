"""Hello: who is on the other end of the line, and whether it speaks this version."""

from __future__ import annotations

import time
from dataclasses import dataclass

from firstcontact.core import InputError
from firstcontact.device.decoder import Decoder
from firstcontact.device.protocol import VERSION, FrameError, FrameType, read_descriptor
from firstcontact.device.source import Descriptor
from firstcontact.device.transport import SerialTransport

#: Hello is said again after so long without an answer, s ...
AGAIN = 0.5
#: ... and no more after so long: some boards restart when their port is opened.
PATIENCE = 4.0


@dataclass(frozen=True, slots=True)
class Greeting:
    """What a device answered."""

    boot: int
    descriptor: Descriptor


def greet(transport: SerialTransport, patience: float = PATIENCE) -> Greeting:
    """Ask a device who it is.

    Parameters
    ----------
    transport
        Open.
    patience
        How long to wait for an answer, s.

    Raises
    ------
    LinkError
        The port is gone.
    InputError
        No answer, another version, or a descriptor that cannot be used.
    """
    decoder = Decoder()
    began = time.monotonic()
    said = -1.0
    while (now := time.monotonic()) - began < patience:
        if said < 0 or now - said > AGAIN:
            transport.send(FrameType.HELLO, bytes([VERSION]))
            said = now
        for frame in decoder.feed(transport.read()):
            if frame.type == FrameType.REFUSED:
                raise InputError(_refused(transport.port, frame.payload))
            if frame.type == FrameType.DESCRIPTOR:
                return _greeting(transport.port, frame.payload)
    raise InputError(
        f"{transport.port}: what is on this port does not answer: check that it is the fingertip "
        "(`firstcontact ports --ask`) and flash its firmware"
    )


def _greeting(port: str, payload: bytes) -> Greeting:
    try:
        version, boot, text = read_descriptor(payload)
    except FrameError as error:
        raise InputError(f"{port}: the device's descriptor is damaged ({error})") from error
    if version != VERSION:
        raise InputError(_other(port, version))
    try:
        return Greeting(boot, Descriptor.from_text(text))
    except InputError as error:
        raise InputError(f"{port}: {error}") from None


def _refused(port: str, payload: bytes) -> str:
    if payload and payload[0] != VERSION:
        return _other(port, payload[0])
    why = payload[1:].decode(errors="replace")
    return f"{port}: the device refuses: {why}: flash the firmware that belongs to this program"


def _other(port: str, version: int) -> str:
    return (
        f"{port}: the device speaks protocol version {version} and this program {VERSION}: "
        "flash the firmware that belongs to this version of firstcontact"
    )
