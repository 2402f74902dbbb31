"""What has become of a link since it was last looked at, in words."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from firstcontact.device._source import Health

#: Losses of so long are told in one line, s.
GATHER = 1.0


def link_news(before: Health, now: Health) -> list[str]:
    """A line each for a device that went, one that came back, and samples lost."""
    news = []
    if before.connected and not now.connected:
        comes = now.unusable_samples + now.bad_frames > before.unusable_samples + before.bad_frames
        gone = f"{'what comes is not usable' if comes else 'the device is gone'}; waiting for it"
        news.append(f"link: {'that was all of the recording' if now.ended else gone}")
    if now.reconnects > before.reconnects:
        news.append(f"link: the device is back, epoch {now.epoch}")
    elif now.connected and not before.connected:
        news.append("link: the device is back")
    lost = now.lost_samples - before.lost_samples
    if lost > 0:
        news.append(f"link: {lost} samples lost, {now.lost_samples} in all")
    return news


class LinkNews:
    """What becomes of a link while it is looked at again and again.

    Losses that follow one another are gathered: a line a second at most.

    Parameters
    ----------
    health
        Of the source, now.
    clock
        Gives the host's time, s.
    """

    def __init__(self, health: Health, clock: Callable[[], float] = time.monotonic) -> None:
        self._before = health
        self._clock = clock
        self._not_before = clock()

    def lines(self, now: Health, *, last: bool = False) -> list[str]:
        """What is new, in words; with ``last`` also the losses that were to be gathered."""
        told = self._before.lost_samples
        gather = not last and self._clock() < self._not_before
        shown = replace(now, lost_samples=told) if gather else now
        if last and not now.ended:  # nobody waits for the device any more
            shown = replace(shown, connected=self._before.connected)
        news = link_news(self._before, shown)
        if shown.lost_samples > told:
            self._not_before = self._clock() + GATHER
        self._before = shown
        return news


def clock_line(health: Health, rate: float) -> str:
    """How far the device's clock is off the host's, "" before it can be told.

    Parameters
    ----------
    health
        Of the source.
    rate
        That it says it has, Hz.
    """
    if not health.host_rate > 0:
        return ""
    off = 1e6 * (health.host_rate / rate - 1)
    return f"clock: {health.host_rate:.2f} samples a second of the host's clock, {off:+.0f} ppm"
