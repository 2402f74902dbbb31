"""Command ``firstcontact replay``: a recording that is served as a live device."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from firstcontact.cli.options import Option


@dataclass(frozen=True)
class Replay:
    """Serve a recording as a live device, on a port that any program can open.

    The calibration and the marks of pinches are not sent: `live` measures the noise again or takes
    --calibration.
    """

    recording: Annotated[Path, Option(positional=True)]
    """Recording of int16 samples, as a device sends them."""
    speed: float = 1.0
    """Speed as a multiple of real time; inf is as fast as possible."""
    once: bool = False
    """End after the last sample instead of starting again."""
    link: Path | None = None
    """Path at which the port is created; by default in a temporary folder."""

    def run(self) -> None:
        from firstcontact.cli.stopping import stop_on_signals
        from firstcontact.core import DeviceError
        from firstcontact.device.ports import PseudoTerminal, port_folder
        from firstcontact.device.replay import ReplayDevice

        with port_folder() as folder, stop_on_signals() as stop:
            port = self.link or folder / "port"
            try:
                terminal = PseudoTerminal(port)
            except OSError as error:
                raise DeviceError(
                    f"{port} cannot be created ({error.strerror}): choose another name for the port"
                ) from error
            try:
                device = ReplayDevice(self.recording, terminal, self.speed)
                stop.gently = True
                print(f"port: {port}", flush=True)
                device.run(lambda: stop.requested, self.once)
            finally:
                terminal.unplug()
