"""``firstcontact replay``."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import tyro


@dataclass(frozen=True)
class Replay:
    """Make a recording a live device: a port that this or any other program can open.

    Its calibration does not travel over the wire: `live` measures the noise anew or takes
    --calibration. Nor do its marks of pinches.
    """

    recording: tyro.conf.Positional[Path]
    """A recording of int16 samples, as a device sends them."""
    speed: float = 1.0
    """Times real time; inf sends as fast as the host takes it."""
    once: bool = False
    """End when a host has had all of it; else it begins again."""
    port: Path | None = None
    """Name of the port; one in a temporary folder if none is given."""

    def run(self) -> None:
        """Print the port's name and serve until Ctrl-C, or until it was sent once."""
        from firstcontact.cli.stopping import stopping
        from firstcontact.core import InputError
        from firstcontact.device import PseudoTerminal, ReplayDevice, port_folder

        with port_folder() as folder, stopping() as stop:
            port = self.port or folder / "port"
            try:
                terminal = PseudoTerminal(port)
            except OSError as error:
                raise InputError(
                    f"{port} cannot be made ({error.strerror}): choose another name for the port"
                ) from error
            try:
                device = ReplayDevice(self.recording, terminal, self.speed)
                if device.calibrated:
                    print("its calibration does not travel over the wire", file=sys.stderr)
                stop.gently = True
                print(f"port: {port}", flush=True)
                device.run(lambda: stop.requested, self.once)
            finally:
                terminal.unplug()
