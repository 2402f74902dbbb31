"""Recordings of a live session: samples, pinches, and positions of the hand."""

from __future__ import annotations

import itertools
import logging
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from datetime import datetime
from pathlib import Path

from firstcontact.core import (
    ArgumentError,
    Block,
    Calibration,
    Contact,
    FileError,
    InputError,
    Label,
)
from firstcontact.device import Arrival, Source
from firstcontact.device.recorder import Recorder, RecorderStatus
from firstcontact.grasp import HandError
from firstcontact.recording import PinchMark
from firstcontact.recording.messages import HAND, hand_group
from firstcontact.streaming.events import PinchDone
from firstcontact.streaming.grasping import Grasping, PositionTrack

_log = logging.getLogger("firstcontact.streaming")


class SessionRecording:
    """Recordings of a live session in a folder, one after the other.

    ``detector`` names the detector of the session, which found the contacts.
    """

    def __init__(
        self,
        source: Source,
        folder: Path,
        calibration: Calibration | None,
        grasping: Grasping | None,
        detector: str,
    ) -> None:
        self._source, self._folder, self._calibration = source, folder, calibration
        self._grasping, self._detector = grasping, detector
        self._recorder = Recorder()
        self._noted: Path | None = None  # recording to which the next three fields belong
        self._number = 0
        self._start: tuple[int, int] | None = None
        self._track: PositionTrack | None = None

    @property
    def status(self) -> RecorderStatus:
        return self._recorder.status

    def start(self) -> Path:
        """Start a recording in the folder, with an unused name. Return the path of its file."""
        now = datetime.now().astimezone()
        created = now.isoformat(timespec="seconds")
        header = self._source.descriptor.header(created=created, calibration=self._calibration)
        hand = None if self._grasping is None else self._grasping.hand
        if hand is not None and hand.position_rate > 0:
            group = hand_group(hand.position_rate, hand.position_resolution)
            layout = replace(header.layout, groups=(*header.layout.groups, group))
            try:
                header = replace(header, layout=layout)
            except ValueError as error:
                raise ArgumentError(
                    f"positions of the hand {hand.name!r} cannot be recorded, because {error}: "
                    "set another `position_rate` in its class",
                    parameter="hand",
                ) from error
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(
                f"{self._folder} cannot be created ({error.strerror}): choose another folder"
            ) from error
        stem = f"live-{now:%Y%m%d-%H%M%S}"
        for number in itertools.count(1):
            name = stem if number == 1 else f"{stem}-{number}"
            path = self._folder / f"{name}.mcap"
            try:
                self._recorder.start(path, replace(header, session=name))
            except InputError as error:
                if not isinstance(error.__cause__, FileExistsError):
                    raise
            else:
                break
        _log.info("recording %s", path)
        return path

    def stop(self) -> Path | None:
        """End the recording and return the path of its file; None if none was running."""
        path = self.status.path
        self._recorder.stop()
        return path

    def close(self) -> None:
        self._recorder.close()

    def add(
        self,
        arrivals: Sequence[Arrival],
        pinches: Sequence[tuple[PinchDone, str]],
        *,
        is_predicting: bool,
        hurries: Callable[[], bool],
    ) -> None:
        """Add new samples to the recording, and finished pinches with the names of their objects.

        Wait for the recorder unless ``hurries`` returns True.
        """
        # Recordings begin and end in the threads of viewers.
        path = self.status.path
        if path != self._noted:
            self._noted, self._number, self._start, self._track = path, 0, None, None
        if self._start is None and arrivals:
            self._start = (arrivals[0].block.epoch, arrivals[0].block.first_sample)
        self._recorder.put(arrivals)
        if path is not None and arrivals:
            self._record_positions(arrivals[-1].block, is_predicting=is_predicting)
        self._recorder.wait(hurries)
        for pinch, name in pinches:
            self._note(pinch, name)

    def _record_positions(self, block: Block, *, is_predicting: bool) -> None:
        """Record the hand's positions up to the end of a block, but not while estimates are due."""
        hand = None if self._grasping is None else self._grasping.hand
        if self._grasping is None or hand is None or not hand.position_rate > 0:
            return
        if self._track is None or self._track.epoch != block.epoch:
            start = block.first_sample / self._source.descriptor.layout.rate
            dtype = self._source.descriptor.dtype
            self._track = PositionTrack(hand, dtype, block.epoch, start)
        if not is_predicting:
            with suppress(HandError):  # a hand that has failed ends the session by itself
                for steps in self._track.read(self._grasping.host_zero):
                    self._recorder.put_group(HAND, steps)

    def _note(self, pinch: PinchDone, name: str) -> None:
        is_whole = self._start is not None and (pinch.epoch, pinch.start) >= self._start
        if self._noted is None or self.status.path != self._noted or not is_whole:
            return
        found: tuple[Contact, ...] = ()
        if not self._source.descriptor.layout.has_strip:
            # A person who confirms contacts later begins with the detected ones.
            found = tuple(c for c in pinch.contacts if pinch.start <= c.sample < pinch.end)
        self._recorder.mark(
            PinchMark(
                self._number,
                pinch.start,
                pinch.end,
                pinch.epoch,
                Label(object=name),
                truth=tuple(c for c in pinch.strips if pinch.start <= c.sample < pinch.end),
                closing_speed=pinch.closing_speed,
                found=found,
                found_by=self._detector if found else "",
            )
        )
        self._number += 1
