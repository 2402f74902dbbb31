"""Command ``firstcontact check``: guided self-test of new fingertips."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated

from firstcontact.cli.options import Condition, Option, devices
from firstcontact.core import ArgumentError
from firstcontact.device.opening import source_kind


@dataclass(frozen=True)
class Check:
    """Test new fingertips step by step, and write a page with a remedy for each fault.

    The exit code is 1 if a fault was found.
    """

    device: Annotated[str, devices(recorded=False)]
    """Source of the samples."""
    out: Path = Path("check.html")
    """Page with the results; an existing one is replaced."""
    drift: float = 30.0
    """Duration of the drift test, s: 300 for the full test, 0 for none."""
    fault: Annotated[str, Option(group="simulated hand")] = ""
    """Fault to simulate in the fingertips, such as hum or open-row."""
    condition: Condition = "paper-rig"
    """Variation between pinches, as in the paper's set-up or everyday use."""
    seed: Annotated[int, Option(group="simulated hand")] = 0
    """Random seed of the simulated hand."""
    speed: Annotated[float, Option(group="simulated hand")] = 1.0
    """Speed of the simulated hand, as a multiple of real time."""

    def run(self) -> int:
        from firstcontact.cli.stopping import stop_on_signals
        from firstcontact.collect.check import check_fingertips, summary, write_page
        from firstcontact.core.calibration import check_writable
        from firstcontact.device import open_source

        if self.fault and not source_kind(self.device).is_simulated:
            raise ArgumentError(
                "only the simulated hand can have a fault: give --device twin", parameter="fault"
            )
        check_writable(self.out)  # before a person taps and presses for nothing
        opened = open_source(
            self.device,
            speed=self.speed,
            condition=self.condition,
            seed=self.seed,
            fault=self.fault,
        )
        with stop_on_signals(), opened as source:
            say = partial(print, flush=True)
            measured, verdicts = check_fingertips(source, drift=self.drift, say=say)
        for v in verdicts:
            words = f"{v.check} {v.finger}".ljust(20)
            limit = "good" if v.is_good else f"FAULT (limit {v.limit}): {v.remedy}"
            print(f"{words} {v.measured}: {limit}")
        write_page(self.out, source.descriptor, measured, verdicts)
        print(f"{summary(verdicts)}; page: {self.out}")
        return 0 if all(v.is_good for v in verdicts) else 1
