"""Interface of all sources of samples, and the state of their connection."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Self

from firstcontact.core import (
    ArgumentError,
    Block,
    Calibration,
    ClosingSpeed,
    DeviceError,
    InputError,
)
from firstcontact.device.descriptor import Descriptor, DevicePrediction
from firstcontact.recording import Marker, PinchMark

#: Losses within this time are reported in one line, s.
MERGE_TIME = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Arrival:
    """Consecutive samples, with the time at which this computer (the host) received them.

    Parameters
    ----------
    block
        Samples with their numbers. The numbers do not wrap around.
    host
        Value of ``time.monotonic()`` when the last byte of the samples arrived, s.
    markers
        Markers (texts set by a person or program) at these samples. A marker whose sample was lost
        comes with the newest unread samples, or with an empty block.
    pinches
        Labels and positions of the pinches that begin in these samples, if a recording is replayed.
    predictions
        Contacts and estimates that the device computed by itself, in the order received.
    """

    block: Block
    host: float
    markers: tuple[Marker, ...] = ()
    pinches: tuple[PinchMark, ...] = ()
    predictions: tuple[DevicePrediction, ...] = ()


@dataclass(frozen=True, slots=True)
class Health:
    """State of a source's connection, and counts since the source was opened.

    Parameters
    ----------
    connected
        True if the device is connected and has sent a usable sample within the last second.
    epoch
        Number of the epoch (run of the device's sample counter) of the newest sample.
    samples
        Number of received samples.
    lost_samples
        Number of samples that the device counted but the host did not receive in usable form.
    overflow_samples
        Number of the lost samples that the device dropped because the host did not read them.
    unusable_samples
        Number of the lost samples that arrived with a value that was NaN, infinite or beyond
        32-bit integers, or with a time stamp that jumps.
    lost_frames
        Number of frames (serial packets) that never arrived, by the numbers of those received.
    bad_frames
        Number of frames that arrived damaged, so that their content was lost.
    doubled_frames
        Number of frames that were ignored because they were repeated or out of order.
    late_answers
        Number of predictions that the device's own model skipped because it was too slow.
    unheard_samples
        Number of samples that the device sent, but that the model on the device did not process.
    reconnects
        Number of times that the device was reconnected or restarted. Each begins an epoch.
    host_rate
        Sampling rate in this epoch, Hz, measured with the host's clock; 0 until it is measured.
    losses_known
        True if the device numbers its samples, so that every lost sample is counted.
    ended
        True if no more samples will arrive, for example after the end of a recording.
    """

    connected: bool = False
    epoch: int = 0
    samples: int = 0
    lost_samples: int = 0
    overflow_samples: int = 0
    unusable_samples: int = 0
    lost_frames: int = 0
    bad_frames: int = 0
    doubled_frames: int = 0
    late_answers: int = 0
    unheard_samples: int = 0
    reconnects: int = 0
    host_rate: float = 0.0
    losses_known: bool = True
    ended: bool = False

    @property
    def lost(self) -> str:
        """Text with the number of lost samples, and a remark if more may be lost."""
        unknown = "" if self.losses_known else " or more (the device does not count its samples)"
        return f"{self.lost_samples}{unknown}"

    @property
    def link(self) -> str:
        """Text with the counts of received and lost samples, damaged frames and reconnects."""
        return (
            f"link: {self.samples} samples, {self.lost} lost, {self.bad_frames} damaged frames, "
            f"{self.reconnects} reconnects"
        )

    @property
    def unusable_text(self) -> str:
        """Text with the number of unusable samples and the possible reasons."""
        count = self.unusable_samples
        return f"{count} NaN, infinite, out of range, or with a time stamp that jumps"


class Source(ABC):
    """Source of samples, such as a device or a recording. It delivers each sample once, in order.

    A ``with`` statement opens and closes the source. A thread receives the samples, so a slow
    reader loses none. Call :meth:`read` from one thread only.

    Attributes
    ----------
    speed
        Speed at which samples arrive, as a multiple of real time; 1 for real devices.
    is_replay
        True if the source replays a recording.
    calibration
        Calibration (noise floors) from the header of a replayed recording; None without one.
    can_poll
        True if ``read(0.0)`` is fast enough to be called in a loop without a pause.
    twin_hand
        Condition, such as "paper-rig", and random seed of a simulated hand; None for a real one.
    """

    speed: float = 1.0
    is_replay: bool = False
    calibration: Calibration | None = None
    can_poll: bool = False
    twin_hand: tuple[str, int] | None = None

    def __init_subclass__(cls, **options: object) -> None:
        super().__init_subclass__(**options)
        if hasattr(cls, "recorded"):
            raise TypeError(f"{cls.__name__}.recorded has no effect: rename it to is_replay")

    @property
    @abstractmethod
    def name(self) -> str:
        """Name of the source for users: the serial port, "twin", or the path of the file."""

    @property
    @abstractmethod
    def descriptor(self) -> Descriptor:
        """Metadata of the source: columns, rate and names. The source must be open."""

    @property
    @abstractmethod
    def health(self) -> Health:
        """State of the connection and counts of samples, now. Any thread can read them."""

    @property
    @abstractmethod
    def ended(self) -> bool:
        """True if :meth:`read` has returned all samples and no more will arrive."""

    @abstractmethod
    def read(self, timeout: float, least: int = 1) -> list[Arrival]:
        """Return all samples received since the last call, in order.

        Wait until there are ``least`` samples, but at most ``timeout`` s.

        Raises
        ------
        InputError
            Reading failed for good, or a device with another layout is now connected to the port.
            The source was never opened, or it was closed and all its samples were read. The
            timeout is NaN or longer than :data:`threading.TIMEOUT_MAX` s.
        """

    @abstractmethod
    def mark(self, text: str) -> None:
        """Attach ``text`` to the next sample as a marker. A marker never moves a hand."""

    def order(self, text: str) -> None:  # noqa: B027
        """Send the order ``text`` to a simulated hand. Real devices ignore it.

        Never send text that a viewer or a file chose freely: see
        :mod:`firstcontact.device.twin_words`.
        """

    def closing_speed(self, sample: int, epoch: int) -> ClosingSpeed | None:
        """Return the fingertip's speed just before a contact; None if it was not measured.

        ``sample`` is the contact's sample number, in the epoch ``epoch``.
        """
        return None

    def positions_since(self, since: float) -> list[tuple[float, float]]:
        """Return (time, s; travel, m) pairs of a simulated hand, later than ``since``, s.

        Times are on the clock of the samples. Real devices return [].
        """
        return []

    @abstractmethod
    def close(self) -> None:
        """Stop the samples, and release the port or file. A second call does nothing."""

    @abstractmethod
    def __enter__(self) -> Self: ...

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _check_readable(self, timeout: float, *, is_drained: bool) -> None:
        """Raise InputError if :meth:`read` could never return samples, or the timeout is too long.

        ``is_drained`` is True if the source is closed and has no unread samples.
        """
        self.descriptor  # noqa: B018  # refuses if the source is not open
        if is_drained:
            raise DeviceError(f"{self.name} is closed: open it again")
        if not timeout <= threading.TIMEOUT_MAX:
            raise ArgumentError(
                f"the timeout is {timeout:g} s: give at most {threading.TIMEOUT_MAX:.3g} s",
                parameter="timeout",
            )

    def _not_open(self) -> InputError:
        return DeviceError(f"{self.name} is not open: use the source in a with block")


def require_source(source: object) -> None:
    """Raise ArgumentError if a value is not a :class:`Source` but, for example, a device name."""
    if not isinstance(source, Source):
        raise ArgumentError(
            f"a source is needed, not a {type(source).__name__}: open one with "
            "`with firstcontact.open(device) as source`",
            parameter="source",
        )


def drain(source: Source) -> list[Arrival]:
    """Close a source. Return the samples that it has received but that were not read yet."""
    source.close()
    arrivals: list[Arrival] = []
    with suppress(InputError):  # the reader has raised it already, or is ending
        while new := source.read(0.0):
            arrivals += new
    return arrivals


def _changes(previous: Health, now: Health) -> list[str]:
    """Return a line of text for each disconnection, reconnection and loss of samples.

    ``previous`` is the state of the source before them, and ``now`` the state after them.
    """
    news = []
    if previous.connected and not now.connected:
        unusable = now.unusable_samples + now.bad_frames
        if now.ended:
            news.append("link: end of the recording")
        elif unusable > previous.unusable_samples + previous.bad_frames:
            news.append("link: the samples are not usable; waiting for usable samples")
        else:
            news.append("link: the device is gone; waiting for it")
    if now.reconnects > previous.reconnects:
        news.append(f"link: the device is back, epoch {now.epoch}")
    elif now.connected and not previous.connected:
        news.append("link: the device is back")
    if (lost := now.lost_samples - previous.lost_samples) > 0:
        news.append(f"link: {lost} samples lost, {now.lost_samples} in all")
    return news


class LinkNews:
    """Reporter of disconnections, reconnections and losses of a source, as lines for the user.

    :meth:`lines` returns the changes since its last call. It reports losses once a second at most.
    """

    def __init__(self, health: Health, clock: Callable[[], float] = time.monotonic) -> None:
        self._previous = health
        self._clock = clock
        self._next_loss_line = clock()

    def lines(self, now: Health, *, last: bool = False) -> list[str]:
        reported_losses = self._previous.lost_samples
        is_merging = not last and self._clock() < self._next_loss_line
        reported = replace(now, lost_samples=reported_losses) if is_merging else now
        if last and not now.ended:  # the end of the session is no disconnection
            reported = replace(reported, connected=self._previous.connected)
        news = _changes(self._previous, reported)
        if reported.lost_samples > reported_losses:
            self._next_loss_line = self._clock() + MERGE_TIME
        self._previous = reported
        return news


def clock_line(health: Health, rate: float) -> str:
    """Return a line that compares the measured sampling rate with the stated ``rate``, Hz.

    Return "" while the rate is not measured.
    """
    if not health.host_rate > 0:
        return ""
    off = 1e6 * (health.host_rate / rate - 1)
    return f"clock: {health.host_rate:.2f} samples a second of the host's clock, {off:+.0f} ppm"
