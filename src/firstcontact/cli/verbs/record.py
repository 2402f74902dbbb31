"""Command ``firstcontact record``: guided recording of labelled pinches."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from firstcontact.cli.options import Condition, Option, devices
from firstcontact.core import ArgumentError
from firstcontact.device.opening import source_kind

#: Most sessions of one command.
MOST_SESSIONS = 1000


@dataclass(frozen=True)
class Record:
    """Record labelled pinches. The terminal shows which closings are valid."""

    device: Annotated[str, devices(recorded=False)]
    """Source of the samples."""
    out: Annotated[Path, Option(group="recording")]
    """Folder for recordings; a session that it already holds is continued."""
    object: Annotated[str, Option(group="object")] = ""
    """Name of the object that is pinched."""
    shore_a: Annotated[float | None, Option(group="object")] = None
    """Shore A of the object; not needed for the simulated hand."""
    modulus_mpa: Annotated[float | None, Option(advanced=True, group="object")] = None
    """Young's modulus of the object, MPa, instead of its Shore A."""
    stiffness_n_per_mm: Annotated[float | None, Option(advanced=True, group="object")] = None
    """Stiffness of the object, N/mm, instead of its Shore A."""
    specimen: Annotated[str, Option(advanced=True, group="object")] = ""
    """Name of this physical piece; the object's name by default."""
    pinches: Annotated[int, Option(group="object")] = 10
    """Number of valid pinches of the object."""
    role: Annotated[Literal["train", "test"], Option(advanced=True, group="object")] = "train"
    """Use of the pinches: training, or test on unseen objects."""
    plan: Annotated[Path | None, Option(group="object")] = None
    """CSV file of objects; columns: object,pinches,shore,specimen,role."""
    session: Annotated[str, Option(group="recording", advanced=True)] = "1"
    """Name of the session; keep the set-up unchanged within a session."""
    sessions: Annotated[int, Option(group="recording", advanced=True)] = 1
    """Number of sessions; --session is then the number of the first one."""
    hand_name: Annotated[str, Option(group="recording", advanced=True)] = ""
    """Name of the hand, if the device does not send it."""
    notes: Annotated[str, Option(group="recording", advanced=True)] = ""
    """Remarks for the header of the recordings."""
    calibration: Annotated[Path | None, Option(group="recording")] = None
    """File that `calibrate` wrote; by default the noise is measured first."""
    condition: Condition = "paper-rig"
    """Variation between pinches, as in the paper's set-up or everyday use."""
    seed: Annotated[int, Option(group="simulated hand")] = 0
    """Random seed of the simulated hand."""
    speed: Annotated[float, Option(group="simulated hand")] = 1.0
    """Speed of the simulated hand, as a multiple of real time."""

    #: Options whose parameter of the library has another name.
    options: ClassVar[dict[str, str]] = {"source": "device", "hand": "hand_name"}

    def run(self) -> None:
        from firstcontact import record
        from firstcontact.cli.guided import Terminal
        from firstcontact.cli.stopping import stop_on_signals
        from firstcontact.device import open_source

        simulated = source_kind(self.device).is_simulated
        names = self._sessions()
        with stop_on_signals() as stop:
            for name in names:
                # A further part of a session must not repeat the simulated pinches of the first.
                parts = len(list(self.out.glob("[!.]*.mcap")))
                seed = zlib.crc32(f"{self.seed} {name} {parts}".encode())
                opened = open_source(
                    self.device, speed=self.speed, condition=self.condition, seed=seed
                )
                with opened as source:
                    terminal = Terminal(source, stop, asks=not simulated)
                    record(
                        source,
                        self.out,
                        object=self.object,
                        pinches=self.pinches,
                        shore_a=self.shore_a,
                        modulus_mpa=self.modulus_mpa,
                        stiffness_n_per_mm=self.stiffness_n_per_mm,
                        specimen=self.specimen,
                        role=self.role,
                        plan=self.plan,
                        session=name,
                        calibration=self.calibration,
                        hand=self.hand_name,
                        notes=self.notes,
                        screen=terminal,
                        stopped=lambda: stop.requested,
                    )
                if not terminal.complete:
                    print(f"session {name} is not complete: run the same command to continue it")
                    raise KeyboardInterrupt

    def _sessions(self) -> list[str]:
        from firstcontact.core.text import check_text

        check_text(self.session)
        if self.sessions == 1 and self.session:
            return [self.session]
        if not 1 <= self.sessions <= MOST_SESSIONS:
            raise ArgumentError(
                f"the number of sessions is {self.sessions}: give 1 to {MOST_SESSIONS}",
                parameter="sessions",
            )
        if not self.session.isdecimal():
            raise ArgumentError(
                f"with --sessions {self.sessions}, the first session must be a number, but is "
                f"{self.session!r}: give one, such as 1",
                parameter="session",
            )
        return [str(int(self.session) + k) for k in range(self.sessions)]
