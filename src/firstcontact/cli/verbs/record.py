"""``firstcontact record``."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from firstcontact.cli.choices import devices
from firstcontact.core import InputError
from firstcontact.device import source_kind

#: Most sessions of one command.
MOST_SESSIONS = 1000


@dataclass(frozen=True)
class Record:
    """Record labelled pinches: the hand closes, the terminal says which ones count."""

    device: Annotated[str, devices(recorded=False)]
    """Where samples come from."""
    out: Path
    """Folder for recordings, one file a session; existing sessions are continued."""
    object: str = ""
    """Name of the object that is pinched."""
    shore: float | None = None
    """Shore A of the object; known for objects of the simulated hand."""
    specimen: str = ""
    """Name of the specimen; the object's name by default."""
    pinches: int = 10
    """Number of valid pinches of the object."""
    role: Literal["train", "test"] = "train"
    """Use of the pinches: models are trained on those of role train."""
    plan: Path | None = None
    """CSV file of several objects, with the columns object,pinches,shore,specimen,role."""
    session: str = "1"
    """Name of the session: pinches that are recorded without a change of the set-up."""
    sessions: int = 1
    """Number of sessions; --session is then the number of the first."""
    hand: str = ""
    """Name of the hand, where the device does not send it."""
    notes: str = ""
    """Remarks for the header of the recordings."""
    calibration: Path | None = None
    """File that `firstcontact calibrate` wrote; the noise is measured first by default."""
    condition: Literal["paper-rig", "everyday"] = "paper-rig"
    """Variation of the simulated hand."""
    seed: int = 0
    """Random seed of the simulated hand; each file draws its own from it."""
    speed: float = 1.0
    """Speed of the simulated hand, as a multiple of real time."""

    #: Options whose parameter of the library has another name.
    options: ClassVar[dict[str, str]] = {"shore_a": "shore", "source": "device"}

    def run(self) -> None:
        """Record one session after the other."""
        from firstcontact import record
        from firstcontact.cli.guided import Terminal
        from firstcontact.cli.stopping import stopping
        from firstcontact.device import open_source

        simulated = source_kind(self.device).simulated
        if not simulated and self.speed != 1.0:
            raise InputError("it is for a simulated hand only", parameter="speed")
        names = self._sessions()
        with stopping() as stop:
            for name in names:
                # A further part of a session must not repeat the simulated pinches of the first.
                parts = len(list(self.out.glob("*.mcap")))
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
                        shore_a=self.shore,
                        specimen=self.specimen,
                        role=self.role,
                        plan=self.plan,
                        session=name,
                        calibration=self.calibration,
                        hand=self.hand,
                        notes=self.notes,
                        screen=terminal,
                        stopped=lambda: stop.requested,
                    )
                if not terminal.complete:
                    print(f"session {name} is not complete: the same command continues it")
                    raise KeyboardInterrupt

    def _sessions(self) -> list[str]:
        """Return the names of the sessions."""
        from firstcontact.core import check_text

        check_text(self.session)
        if self.sessions == 1 and self.session:
            return [self.session]
        if not 1 <= self.sessions <= MOST_SESSIONS:
            raise InputError(f"it must lie between 1 and {MOST_SESSIONS}", parameter="sessions")
        if not self.session.isdecimal():
            raise InputError("several sessions need the number of the first", parameter="session")
        return [str(int(self.session) + k) for k in range(self.sessions)]
