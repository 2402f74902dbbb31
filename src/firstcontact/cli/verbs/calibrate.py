"""Command ``firstcontact calibrate``: noise floors, taps and force curves of fingertips."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, ClassVar

from firstcontact.cli.options import devices


@dataclass(frozen=True)
class Calibrate:
    """Measure noise floors, taps and force curves of a pair of fingertips."""

    device: Annotated[str, devices(recorded=False)]
    """Source of the samples."""
    out: Path = Path("calibration.json")
    """File for the result; an existing one is replaced."""
    seconds: float = 2.0
    """Duration of the measurement with the hand at rest, s."""
    patience: float = 10.0
    """Longest additional wait until the hand is at rest, s."""
    no_tap: bool = False
    """Skip the tap test; required with the simulated hand."""
    weights: Path | None = None
    """CSV file of voltages under weights; columns: finger,newtons,volts."""
    weigh: tuple[float, ...] = ()
    """Weights, N. You are asked to put each on a force cell (taxel)."""

    #: Options whose parameter of the library has another name.
    options: ClassVar[dict[str, str]] = {"tap": "no_tap"}

    def run(self) -> None:
        from firstcontact import calibrate
        from firstcontact.cli.guided import entered
        from firstcontact.cli.stopping import stop_on_signals
        from firstcontact.core.calibration import check_writable, write_calibration
        from firstcontact.device import open_source

        check_writable(self.out)  # before a person taps and weighs for nothing
        with stop_on_signals(), open_source(self.device) as source:
            calibration = calibrate(
                source,
                seconds=self.seconds,
                patience=self.patience,
                tap=not self.no_tap,
                weights=self.weights,
                weigh=self.weigh,
                say=partial(print, flush=True),
                confirmed=entered,
            )
        write_calibration(calibration, self.out)
        print(f"calibration: {self.out}")
