"""``firstcontact record``."""

from __future__ import annotations

import zlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from firstcontact.cli.choices import devices
from firstcontact.core import InputError, counted
from firstcontact.device import open_source, source_kind

if TYPE_CHECKING:
    from firstcontact.cli.stopping import Stop
    from firstcontact.collect import Item

#: Rest that is measured where no calibration is given, and the wait for it, s.
REST = 1.0
PATIENCE = 30.0
#: Nobody goes through a plan more often in one go.
MOST_SESSIONS = 1000


@dataclass(frozen=True)
class Record:
    """Record labelled pinches: the hand closes, the terminal says which ones count."""

    device: Annotated[str, devices(recorded=False)]
    """Where samples come from."""
    out: Path
    """Folder for the recordings, one file a session; what is in it is gone on with."""
    object: str = ""
    """What is pinched."""
    shore: float | None = None
    """Its Shore A; of the twin's objects it is known."""
    specimen: str = ""
    """Which one of its kind; the object's name by default."""
    pinches: int = 10
    """How many good pinches."""
    role: Literal["train", "test"] = "train"
    """Whether models may learn from it."""
    plan: Path | None = None
    """A CSV of several objects, with the columns object,pinches,shore,specimen,role."""
    session: str = "1"
    """Name of the session: a stretch of collecting without touching the set-up."""
    sessions: int = 1
    """Go through it all so often; --session is then the number of the first."""
    hand: str = ""
    """The hand, where the device does not say it."""
    notes: str = ""
    """For the header of the recordings."""
    calibration: Path | None = None
    """What `firstcontact calibrate` wrote; without it the noise is measured at the start."""
    condition: Literal["paper-rig", "everyday"] = "paper-rig"
    """Of the twin."""
    seed: int = 0
    """Of the twin; each session and each part of one draws its own from it."""
    speed: float = 1.0
    """Of the twin, times real time."""

    def run(self) -> None:
        """Record one session after the other."""
        from firstcontact.cli.stopping import stopping

        items = self._items()
        names = self._sessions()
        try:
            self.out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(
                f"{self.out} cannot be made ({error.strerror}): choose another --out"
            ) from error
        others = [p for p in self.out.glob("*.mcap") if not p.name.startswith("session-")]
        if others:
            print(
                f"note: {self.out} holds {counted(len(others), 'recording')} that `record` did not "
                "make, and `train` learns from all of a folder: choose another --out to keep "
                "them apart",
                flush=True,
            )
        with stopping() as stop:
            for name in names:
                if not self._record(name, items, stop):
                    print(f"session {name} is not complete: the same command goes on with it")
                    if stop.requested:
                        raise KeyboardInterrupt
                    break

    def _items(self) -> tuple[Item, ...]:
        from firstcontact.collect import Item, read_plan
        from firstcontact.core import Role

        if (self.plan is None) == (not self.object):
            raise InputError("give --object for one object, or --plan for several")
        if self.plan is not None:
            items = read_plan(self.plan)
        else:
            role = Role(self.role)
            items = (Item(self.object, self.pinches, self.shore, self.specimen, role),)
        kind = source_kind(self.device)
        if not kind.simulated and self.speed != 1.0:
            raise InputError(
                "--speed is for a simulated hand: a real one closes as fast as it does"
            )
        known = kind.shore_a
        if known is None:
            return items
        return tuple(
            replace(i, shore=known(i.object) if i.shore is None else i.shore) for i in items
        )

    def _sessions(self) -> list[str]:
        from firstcontact.core import check_text

        check_text(self.session)
        if self.sessions == 1 and self.session:
            return [self.session]
        if not 1 <= self.sessions <= MOST_SESSIONS or not self.session.isdecimal():
            raise InputError(
                f"--sessions must be from 1 to {MOST_SESSIONS}, and --session the number of the "
                "first of them"
            )
        return [str(int(self.session) + k) for k in range(self.sessions)]

    def _record(self, session: str, items: tuple[Item, ...], stop: Stop) -> bool:
        """One session; whether it is complete."""
        from firstcontact.cli.guided import Terminal
        from firstcontact.cli.sensor_words import rest_request
        from firstcontact.collect import Guide, header_of, run_session, so_far, with_noise
        from firstcontact.core import read_calibration
        from firstcontact.device import measure_noise

        calibration = None if self.calibration is None else read_calibration(self.calibration)
        # Another part of a session must not repeat what the twin did in the first.
        parts = len(list(self.out.glob("*.mcap")))
        seed = zlib.crc32(f"{self.seed} {session} {parts}".encode())
        source = open_source(self.device, speed=self.speed, condition=self.condition, seed=seed)
        with source:
            before = so_far(self.out, session, source.descriptor)
            for sentence in before.unreadable:
                print(f"warning: passed over: {sentence}")
            layout = source.descriptor.layout
            if all(before.done[item.label(session)] >= item.pinches for item in items):
                print(f"session {session} is complete: {before.files[-1]}")
                return True
            if calibration is None or len(calibration.piezo) < len(layout.vibration_fingers):
                print(
                    f"measuring the noise floor, {REST:g} s of rest: {rest_request(layout)}",
                    flush=True,
                )
                calibration = with_noise(calibration, measure_noise(source, REST, PATIENCE))
            guide = Guide(layout, items, session, calibration, before.done)
            header = header_of(source.descriptor, session, calibration, self.hand, self.notes)
            print(f"session {session}: {before.path}")
            by_hand = not source_kind(self.device).simulated
            terminal = Terminal(source, guide, asks=by_hand and len(items) > 1)
            with terminal:
                stop.gently = True
                try:
                    return run_session(
                        source, guide, before.path, header, terminal, lambda: stop.requested
                    )
                finally:
                    stop.gently = False
