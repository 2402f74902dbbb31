"""Command ``firstcontact ports``: list of serial ports and sound inputs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from firstcontact.core import InputError
from firstcontact.core.text import counted

#: Longest wait for an answer, s.
PATIENCE = 1.5


@dataclass(frozen=True)
class Ports:
    """List serial ports and sound inputs, and say which of them may be a fingertip."""

    ask: bool = False
    """Send a few bytes to each port, to find out if a fingertip answers there."""

    def run(self) -> None:
        for line in port_lines(ask=self.ask):
            print(line)


def port_lines(*, ask: bool = False) -> Iterator[str]:
    """Yield a line per port with its description and access rights.

    With ``ask``, more lines state what answers on it.
    """
    from firstcontact.device.opening import list_devices
    from firstcontact.device.ports import access, groups, ports

    serial_ports, inputs = ports(), list_devices()
    for port in serial_ports:
        yield f"{port.name:16} {port.description}"
        for line in (access(Path(port.name)), *(answer(port.name) if ask else ())):
            yield f"{'':16} {line}"
    for name, title in inputs:
        yield f"{name:16} {title}"
    if serial_ports:
        yield f"{'groups':16} {', '.join(groups())}"
    if not serial_ports and not inputs:
        yield (
            "no serial port found: connect the fingertip with a data cable, or use the simulated "
            "hand (--device twin)"
        )
    elif serial_ports and not ask and not any(p.teensy for p in serial_ports):
        yield (
            "no port has the USB numbers of a Teensy: use `firstcontact ports --ask` to find out "
            "on which port a fingertip answers"
        )


def answer(port: str) -> Iterator[str]:
    """Yield lines about the device on a port, or one with the reason why it cannot be read."""
    from firstcontact.device.descriptor import skipped_model
    from firstcontact.device.serial_source import SerialSource

    try:
        with SerialSource(port, PATIENCE) as source:
            descriptor = source.descriptor
    except InputError as error:
        yield str(error)
        return
    hand = f", {descriptor.hand}" if descriptor.hand else ""
    yield f"a fingertip: {descriptor.firmware}; {descriptor.sensor}{hand} ({descriptor.source})"
    layout = descriptor.layout
    yield f"{counted(layout.width, 'channel')} at {layout.rate:g} Hz"
    if descriptor.model_slot is not None and descriptor.model_slot.fault:
        yield skipped_model(descriptor.model_slot, descriptor.predictor is not None)
