"""Messages about changes of a link: disconnection, reconnection, lost samples."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from firstcontact.device._source import Health

#: Losses within this time are reported in one line, s.
MERGE_TIME = 1.0


def link_news(previous: Health, now: Health) -> list[str]:
    """Return one line for each disconnection, reconnection and loss between two health states."""
    news = []
    if previous.connected and not now.connected:
        unusable = now.unusable_samples + now.bad_frames
        sends_unusable = unusable > previous.unusable_samples + previous.bad_frames
        if now.ended:
            reason = "end of the recording"
        elif sends_unusable:
            reason = "the samples are not usable; waiting for usable samples"
        else:
            reason = "the device is gone; waiting for it"
        news.append(f"link: {reason}")
    if now.reconnects > previous.reconnects:
        news.append(f"link: the device is back, epoch {now.epoch}")
    elif now.connected and not previous.connected:
        news.append("link: the device is back")
    lost = now.lost_samples - previous.lost_samples
    if lost > 0:
        news.append(f"link: {lost} samples lost, {now.lost_samples} in all")
    return news


class LinkNews:
    """Reporter of changes of a link since the last report.

    It merges consecutive losses, so that at most one line a second reports them.

    Parameters
    ----------
    health
        Current health of the source.
    clock
        Function that returns the host's time, s.
    """

    def __init__(self, health: Health, clock: Callable[[], float] = time.monotonic) -> None:
        self._previous = health
        self._clock = clock
        self._next_loss_line = clock()

    def lines(self, now: Health, *, last: bool = False) -> list[str]:
        """Return lines about changes since the last call.

        If ``last``, also report losses that would otherwise wait to be merged with later ones.
        """
        reported_losses = self._previous.lost_samples
        is_merging = not last and self._clock() < self._next_loss_line
        reported = replace(now, lost_samples=reported_losses) if is_merging else now
        if last and not now.ended:  # the end of the session is no disconnection
            reported = replace(reported, connected=self._previous.connected)
        news = link_news(self._previous, reported)
        if reported.lost_samples > reported_losses:
            self._next_loss_line = self._clock() + MERGE_TIME
        self._previous = reported
        return news


def clock_line(health: Health, rate: float) -> str:
    """Return a line about the difference between the clocks of device and host; "" if unknown.

    Parameters
    ----------
    health
        Health of the source.
    rate
        Stated sample rate, Hz.
    """
    if not health.host_rate > 0:
        return ""
    off = 1e6 * (health.host_rate / rate - 1)
    return f"clock: {health.host_rate:.2f} samples a second of the host's clock, {off:+.0f} ppm"
